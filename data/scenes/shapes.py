"""Meshes and bodies from which the scenes are built. Needs numpy alone."""

from typing import NamedTuple

import numpy as np

LATTICE_M = 2.0**-20  # [m], a micrometre; see `Step`
CLOTH_KG_PER_M2 = 0.2


class Step(NamedTuple):
    """The arrays of one step, as they are stored.

    Positions are multiples of LATTICE_M. Sine and square root may differ in the last bit
    between two machines; after rounding to the lattice every machine gets the same file. The
    exact arithmetic also works with shorter integers, and the files compress better.
    """

    positions_t0: np.ndarray  # (n, 3) f8 [m]
    positions_t1: np.ndarray  # (n, 3) f8 [m]
    faces: np.ndarray  # (m, 3) i4
    masses: np.ndarray  # (n,) f8 [kg]
    pinned: np.ndarray  # (n,) b1


class Sequence(NamedTuple):
    """The arrays of an animation, as they are stored."""

    positions: np.ndarray  # (frames, n, 3) f8 [m], multiples of LATTICE_M
    faces: np.ndarray  # (m, 3) i4
    masses: np.ndarray  # (n,) f8 [kg]
    pinned: np.ndarray  # (n,) b1


class Body(NamedTuple):
    """One body of a scene."""

    start: np.ndarray  # (n, 3) f8 [m]
    end: np.ndarray  # (n, 3) f8 [m]
    faces: np.ndarray  # (m, 3) i4, into this body
    masses: np.ndarray | float  # (n,) f8 [kg], or one mass for each vertex
    pinned: np.ndarray | bool  # (n,) b1, or one answer for all


def assemble(*bodies: Body) -> Step:
    """Join the bodies to one step and round its positions to the lattice."""
    counts = [len(body.start) for body in bodies]
    firsts = np.cumsum([0, *counts[:-1]])
    return Step(
        on_lattice(np.concatenate([body.start for body in bodies])),
        on_lattice(np.concatenate([body.end for body in bodies])),
        np.concatenate(
            [body.faces + first for body, first in zip(bodies, firsts, strict=True)]
        ).astype(np.int32),
        np.concatenate(
            [np.broadcast_to(body.masses, n) for body, n in zip(bodies, counts, strict=True)]
        ).astype(np.float64),
        np.concatenate(
            [np.broadcast_to(body.pinned, n) for body, n in zip(bodies, counts, strict=True)]
        ).astype(bool),
    )


def on_lattice(positions):
    """Round positions to multiples of LATTICE_M."""
    return np.rint(np.asarray(positions, np.float64) / LATTICE_M) * LATTICE_M


def rectangle(n_x, n_y, size_x, size_y):
    """Return a flat sheet around the origin, in the plane z = 0.

    Returns:
        (n_x * n_y, 3) f8 positions [m] and (m, 3) i4 faces. The diagonals of the cells
        alternate.
    """
    x, y = np.meshgrid(
        np.linspace(-0.5 * size_x, 0.5 * size_x, n_x),
        np.linspace(-0.5 * size_y, 0.5 * size_y, n_y),
        indexing="ij",
    )
    positions = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))
    return positions, _grid_faces(n_x, n_y, wrap_y=False)


def tube(n_along, n_around, length, radius):
    """Return an open tube around the x axis.

    Returns:
        (n_along * n_around, 3) f8 positions [m] and (m, 3) i4 faces.
    """
    x = np.repeat(np.linspace(-0.5 * length, 0.5 * length, n_along), n_around)
    angle = np.tile(2.0 * np.pi * np.arange(n_around) / n_around, n_along)
    positions = np.column_stack((x, radius * np.cos(angle), radius * np.sin(angle)))
    return positions, _grid_faces(n_along, n_around, wrap_y=True)


def sphere(n_rings, n_around, radius):
    """Return a sphere around the origin, with poles on the z axis.

    Returns:
        ((n_rings - 1) * n_around + 2, 3) f8 positions [m] and (m, 3) i4 faces.
    """
    polar = np.pi * np.arange(1, n_rings)[:, None] / n_rings
    angle = 2.0 * np.pi * np.arange(n_around)[None, :] / n_around
    rings = (
        np.sin(polar) * np.cos(angle),
        np.sin(polar) * np.sin(angle),
        np.broadcast_to(np.cos(polar), (n_rings - 1, n_around)),
    )
    positions = np.column_stack([part.ravel() for part in rings])
    positions = radius * np.concatenate((positions, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))
    first = np.arange(n_around)
    after = (first + 1) % n_around
    last_ring = (n_rings - 2) * n_around
    north, south = len(positions) - 2, len(positions) - 1
    caps = (
        np.column_stack((np.full(n_around, north), first, after)),
        np.column_stack((np.full(n_around, south), last_ring + after, last_ring + first)),
    )
    faces = np.concatenate((_grid_faces(n_rings - 1, n_around, wrap_y=True), *caps))
    return positions, faces.astype(np.int32)


def uneven(rng, positions, amount):
    """Move each coordinate by up to `amount` [m], so that no vertex lies above an edge."""
    return positions + amount * (2.0 * rng.random(positions.shape) - 1.0)


def cloth_masses(n_vertices, area):
    """Return the mass of each vertex [kg] of cloth with this area [m^2]."""
    return CLOTH_KG_PER_M2 * area / n_vertices


def _grid_faces(n_x, n_y, wrap_y):
    """Split the cells of a grid into triangles; `wrap_y` joins the last column to the first."""
    n_cells_y = n_y if wrap_y else n_y - 1
    i, j = np.divmod(np.arange((n_x - 1) * n_cells_y), n_cells_y)
    a, b = i * n_y + j, (i + 1) * n_y + j
    c, d = (i + 1) * n_y + (j + 1) % n_y, i * n_y + (j + 1) % n_y
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.column_stack((a, b, c)), np.column_stack((a, b, d)))
    second = np.where(even, np.column_stack((a, c, d)), np.column_stack((b, c, d)))
    return np.concatenate((first, second)).astype(np.int32)

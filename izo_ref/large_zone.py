"""One large zone: sweeps as long as they are fast, else the interior point from where they end.

Impacts between vertices that have little to do with each other are solved in some tens of
sweeps, while their factors fill up: a random zone of 4096 impacts takes 0.2 s by sweeps and 16 s
by factorisations. Piles of layers are the other way round.
"""

import numpy as np

from izo_ref.cpu import zones as kernels
from izo_ref.interior_point import interior_point

# Sweeps before it is decided, and the gap that they have to reach: random zones are at 1e-4 or
# below then, the zones of armadillo-rollers, which take 8,500 sweeps, at 4e-2 and 9e-2.
FIRST_SWEEPS, PROMISING = 48, 1e-3
MORE_SWEEPS = 2000
# Of the gap: the distance to the optimum is bounded by its root.
ENOUGH = 1e-2


class LargeZone:
    """The rows of one zone: as they are, and as a matrix.

    Args:
        nodes: (m, 4) i4, into the zone's vertices; -1 for pinned ones.
        coefficients: (m, 4) f8; with the normals, unit rows.
        normals: (m, 3) f8.
        rhs: (m,) f8 [m kg^1/2], s; at least one entry is positive.
        lengths: (m,) f8 [kg^-1/2], of the rows before scaling.
        n_vertices: that are not pinned.
    """

    def __init__(self, nodes, coefficients, normals, rhs, lengths, n_vertices):
        self.nodes, self.coefficients, self.normals = nodes, coefficients, normals
        self.rhs, self.lengths, self.n_vertices = rhs, lengths, n_vertices
        self.matrix = scaled_matrix(nodes, coefficients, normals, n_vertices)


def scaled_matrix(nodes, coefficients, normals, n_unknowns):
    """C as a sparse matrix; nodes < 0 are pinned and have coefficient 0."""
    from scipy.sparse import csr_array

    columns = 3 * np.maximum(nodes, 0)[:, :, None] + np.arange(3)
    values = coefficients[:, :, None] * normals[:, None, :]
    starts = np.arange(0, 12 * len(nodes) + 1, 12)
    shape = (len(nodes), 3 * n_unknowns)
    return csr_array((values.ravel(), columns.ravel(), starts), shape=shape)


def solve_large_zone(zone: LargeZone, gap_tolerance, violation_tolerance, sweeps_may_do):
    """Solve one zone.

    Args:
        zone: `LargeZone`.
        gap_tolerance: relative duality gap.
        violation_tolerance: [m].
        sweeps_may_do: whether sweeps may end it; else they are the start only.

    Returns:
        z (n,), multipliers (m,), the method that ended it, its steps, and whether the rows are
        satisfied.
    """
    tolerances = ENOUGH * gap_tolerance, 0.5 * violation_tolerance
    u, z = np.zeros(len(zone.rhs)), np.zeros((zone.n_vertices, 3))
    steps = _sweep(zone, FIRST_SWEEPS, *tolerances, u, z)
    if sweeps_may_do and steps == FIRST_SWEEPS and _gap(zone, u, z.ravel()) < PROMISING:
        steps += _sweep(zone, MORE_SWEEPS, *tolerances, u, z)
    if sweeps_may_do and steps not in (FIRST_SWEEPS, FIRST_SWEEPS + MORE_SWEEPS):
        return z.ravel(), u, "apgs", steps, True
    of_unit_rows = violation_tolerance / zone.lengths.max()
    solution = interior_point(zone, (z.ravel(), u), gap_tolerance, of_unit_rows)
    return *solution[:2], "interior-point", *solution[2:]


def _sweep(zone, count, gap_tolerance, violation_tolerance, u, z):
    """Go on from u by at most so many sweeps; returns how many."""
    steps = np.zeros(1, np.int32)
    kernels.solve_sweeps.alone(
        np.array([0, len(u)]),
        np.array([0, len(z)]),
        zone.nodes,
        zone.coefficients,
        zone.normals,
        zone.rhs,
        zone.lengths,
        True,
        count,
        gap_tolerance,
        violation_tolerance,
        u,
        z,
        steps,
        np.empty((1, 0, 2)),
    )
    return int(steps[0])


def _gap(zone, u, z):
    """Relative duality gap of z = C^T u."""
    products = u * np.abs(zone.matrix @ z - zone.rhs)
    return float(products.sum() / (0.5 * (z * z).sum()))

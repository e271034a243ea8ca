"""An animation of a garment on a body that moves and turns; the garment goes into the body."""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Floats, Positions
from validation.scenes.garments import (
    COVERED,
    GAP_CELLS,
    GAP_M,
    HALF_HEIGHT_M,
    RADIUS_M,
    around_axis,
    ellipsoid,
    ellipsoid_radius,
    smooth_field,
    tube_faces,
    uneven_grid,
    wrinkle,
)

FIRST_CONTACT = 10  # the first frame in which the garment is inside the body
CALM = 0.2  # how far the garment goes in before that, in gaps
DEPTH = 1.8  # how far it goes in from then on, in gaps
BREATH = 0.25  # part of the depth that comes and goes
STEP_M = 0.004  # how far the body goes in a frame
TURN = 0.02  # how far it turns in a frame [rad]
FRAMES_A_TURN = 40  # after these frames, the body turns back


class Part(NamedTuple):
    """A named mesh of an animation.

    Attributes:
        name: Its name.
        first: Number of its first vertex among those of all parts.
        n_vertices: Number of its vertices.
        faces: (m, 3) i4, vertices of this part, from 0.
    """

    name: str
    first: int
    n_vertices: int
    faces: Faces


class Moving(NamedTuple):
    """An animation of named meshes.

    Attributes:
        positions: (n_frames, n, 3) f8 [m]; all are float32 numbers, which every format can hold.
        parts: The meshes.
        pinned: Names of the parts that move as they are.
    """

    positions: Floats
    parts: tuple[Part, ...]
    pinned: tuple[str, ...]

    @property
    def faces(self) -> Faces:
        """(m, 3) i4, the faces of all parts, with the vertices of all."""
        return np.concatenate([part.faces + np.int32(part.first) for part in self.parts])

    @property
    def pinned_vertices(self) -> Flags:
        """(n,) b1."""
        flags = np.zeros(self.positions.shape[1], bool)
        for part in self.parts:
            flags[part.first : part.first + part.n_vertices] = part.name in self.pinned
        return flags


def moving_garment(
    rng: np.random.Generator,
    n_frames: int = 100,
    n_triangles: int = 2000,
    n_layers: int = 1,
    pressed: float = 0.5,
) -> Moving:
    """Make layers of cloth on a pinned body, which go into it and into each other.

    The body is an ellipsoid that goes along a curve, turns and leans. Each layer is an open tube
    around it that is carried along. Up to frame FIRST_CONTACT, the layers keep their distances;
    from then on, each is inside the layer below it, and the lowest one inside the body, over a part
    of the way around. How deep comes and goes, and moves around with a smooth random field.

    Args:
        rng: Draws wrinkles, meshes and motion.
        n_frames: Number of frames.
        n_triangles: Triangles of the body and all layers; the animation has about that number.
        n_layers: Number of layers, at least 1.
        pressed: Part of the way around that goes in, from 0 to 1.

    Returns:
        The animation; its parts are `body`, which is pinned, and `layer1`, `layer2` and so on.
    """
    n_around, n_along = _resolution(n_triangles, n_layers + 1)
    gap = GAP_CELLS * 2.0 * np.pi * RADIUS_M / n_around + GAP_M
    body, body_faces = ellipsoid(n_around, n_along)
    frames = [[_placed(body, frame)] for frame in range(n_frames)]
    parts = [Part("body", 0, len(body), body_faces)]
    phases = rng.uniform(0.0, 2.0 * np.pi, 3)
    for layer in range(1, n_layers + 1):
        angle, height = uneven_grid(rng, n_around, n_along + 1)
        outside = ellipsoid_radius(height) + wrinkle(phases, angle, height) + layer * gap
        # from 0 outside of the pressed part to 1 in its middle
        near = np.cos(0.5 * np.clip((angle - phases[2]) % (2.0 * np.pi) - np.pi, -np.pi, np.pi))
        share = np.clip((near - 1.0 + pressed) / max(pressed, 1e-9), 0.0, 1.0)
        fields = [smooth_field(rng, angle, height) for _ in range(2)]
        for frame in range(n_frames):
            depth = _depth(frame) * share * (1.0 + BREATH * _mixed(fields, frame))
            # a layer goes in together with those below it, which make room for nothing
            radius = outside - gap * layer * depth
            frames[frame].append(_placed(around_axis(angle, radius, height), frame))
        first = parts[-1].first + parts[-1].n_vertices
        parts.append(Part(f"layer{layer}", first, len(angle), tube_faces(n_around, n_along + 1)))
    positions = np.array([np.concatenate(own) for own in frames], np.float32)
    return Moving(positions.astype(np.float64), tuple(parts), ("body",))


def _resolution(n_triangles: int, n_meshes: int) -> tuple[int, int]:
    """Return the cells around and along each mesh; they are as long as they are wide."""
    rows_a_column = 2.0 * COVERED * HALF_HEIGHT_M / (2.0 * np.pi * RADIUS_M)
    n_around = max(8, round(np.sqrt(0.5 * n_triangles / (n_meshes * rows_a_column))))
    return n_around, max(3, round(0.5 * n_triangles / (n_meshes * n_around)))


def _depth(frame: int) -> float:
    """Return how far the layers go in at a frame, in gaps."""
    if frame < FIRST_CONTACT:
        return CALM * frame / FIRST_CONTACT
    return DEPTH * (1.0 + BREATH * float(np.sin(0.3 * (frame - FIRST_CONTACT))))


def _mixed(fields: list[Floats], frame: int) -> Floats:
    """Return a field that changes slowly from frame to frame, between -1 and 1."""
    turn = 0.05 * frame
    return np.clip(np.cos(turn) * fields[0] + np.sin(turn) * fields[1], -1.0, 1.0)


def _placed(points: Positions, frame: int) -> Positions:
    """Return points of the body at rest where the body is at a frame."""
    turn = TURN * FRAMES_A_TURN * np.sin(frame / FRAMES_A_TURN)
    lean = 0.3 * np.sin(0.05 * frame)
    c, s = np.cos(turn), np.sin(turn)
    about_z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    c, s = np.cos(lean), np.sin(lean)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    way = STEP_M * FRAMES_A_TURN
    along = np.array([way * np.sin(frame / FRAMES_A_TURN), 0.3 * way * np.sin(0.08 * frame), 0.0])
    return points @ (about_x @ about_z).T + along

"""The scenes of stage S12, and how each is built."""

from __future__ import annotations

from random import Random

from izo_ref.porting.generate.scene_parts import SceneParts, fan, hanging_triangle, sheet

FACE = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.0, 0.0)]
ONE = [[0, 1, 2]]
TETRA = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
ALL_FOUR = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def over_a_face(
    drop: float = 1.0,
    gap: float = 0.25,
    mass: float = 1.0,
    pinned: int = 0,
    rise: float = 0.0,
    thickness: float = 2.0**-7,
) -> SceneParts:
    """Return the tip of a triangle over a face; only the tip falls, or the face rises."""
    parts = SceneParts(thickness)
    parts.add(FACE, ONE, (0.0, 0.0, rise), pinned=pinned)
    tip = hanging_triangle((0.0, -0.25, gap))
    parts.add(tip, ONE, lambda k, _: (0.0, 0.0, -drop if k == 0 else 0.0), mass)
    return parts


def decimal_rise() -> SceneParts:
    """Return a pinned face that rises from -0.7 m to 0.9 m, through a triangle at 0.3 m.

    For these numbers, start + (end - start) is not the end in float64.
    """
    parts = SceneParts()
    pinned = parts.add([(x, y, -0.7) for x, y, _ in FACE], ONE, pinned=1)
    for vertex in pinned:
        parts.end[vertex] = (*parts.end[vertex][:2], 0.9)
    parts.add(hanging_triangle((0.0, -0.25, 0.3)), ONE)
    return parts


def two_sheets(
    drop: float, gap: float = 0.125, pinned: int = 0, seed: int | None = None, heavy: float = 1.0
) -> SceneParts:
    """Return a sheet that falls onto another one, or through it."""
    parts = SceneParts()
    ripple = None if seed is None else Random(seed)
    parts.add(*sheet(5, 0.0, ripple=ripple), pinned=pinned)
    upper = sheet(5, gap + (0.0625 if seed else 0.0), at=(0.03125, 0.046875), ripple=ripple)
    parts.add(*upper, (0.0, 0.0, -drop), heavy)
    return parts


def through_layers(layers: int, drop: float, heavy: float = 1.0) -> SceneParts:
    """Return a sheet that falls through other ones."""
    parts = SceneParts()
    for k in range(layers):
        parts.add(*sheet(3, -0.125 * k, at=(k / 64.0, -k / 32.0)))
    parts.add(*sheet(3, 0.125, at=(0.078125, 0.046875)), (0.0, 0.0, -drop), heavy)
    return parts


def swapped_layers() -> SceneParts:
    """Return two sheets that are proposed to change places."""
    parts = SceneParts()
    parts.add(*sheet(4, 0.0, 0.75), (0.0, 0.0, 0.25))
    parts.add(*sheet(4, 0.25, 0.75, at=(0.046875, 0.0625)), (0.0, 0.0, -0.25))
    return parts


def small_through_large(width: float = 0.0625) -> SceneParts:
    """Return a small triangle that flies through a large face, and is clear of it at the end."""
    parts = SceneParts()
    parts.add(FACE, ONE)
    own = [(-width, -0.25, 0.5), (width, -0.25, 0.53125), (0.0, -0.25 + width, 0.5625)]
    parts.add(own, ONE, (0.0, 0.0, -1.0))
    return parts


def crossing_blades() -> SceneParts:
    """Return two triangles that stand on edges across each other; only the edges meet."""
    parts = SceneParts()
    parts.add([(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -2.0)], ONE)
    upper = [(0.125, -1.0, 0.25), (0.125, 1.0, 0.25), (0.125, 0.0, 2.25)]
    parts.add(upper, ONE, (0.0, 0.0, -0.75))
    return parts


def pushed_sheet(speed: float, tilt: float = 0.0) -> SceneParts:
    """Return a sheet at rest that a pinned triangle pushes upwards; it may tilt meanwhile."""
    parts = SceneParts()
    parts.add(*sheet(5, 0.0))
    own = [(0.21875, 0.28125, -0.25), (0.78125, 0.3125, -0.25), (0.46875, 0.71875, -0.25)]
    parts.add(own, ONE, lambda k, _: (0.0, tilt * (k - 1), speed + tilt * k), pinned=1)
    return parts


def pinch(end_gap: float, bump: float = 0.0) -> SceneParts:
    """Return a sheet between pinned plates that come as near to each other as `end_gap`."""
    parts = SceneParts()
    for side in (-1.0, 1.0):
        move = side * (0.5 * end_gap - 0.25)
        parts.add(*sheet(3, 0.25 * side, 2.0, at=(-1.0, -1.0)), (0.0, 0.0, move), pinned=1)
    parts.add(*sheet(4, 0.0, 0.75, at=(-0.359375, -0.390625)), (0.0, 0.0, bump))
    return parts


def crushed_in_a_box(depth: float) -> SceneParts:
    """Return a triangle in a closed pinned box whose lid goes down through its bottom."""
    parts = SceneParts()
    parts.add(TETRA, ALL_FOUR, lambda k, _: (0.0, 0.0, -depth if k == 3 else 0.0), pinned=1)
    own = [(-0.125, -0.25, 0.25), (0.125, -0.25, 0.28125), (0.0, 0.0, 0.3125)]
    parts.add(own, ONE)
    return parts


def cone_through_sheet(rim: int, side: int, drop: float) -> SceneParts:
    """Return a cone whose tip and rim fall through a sheet: many impacts at one vertex."""
    parts = SceneParts()
    parts.add(*sheet(side, 0.0, 2.0, at=(-1.0, -1.0)))
    cone = fan((0.046875, 0.078125, 0.125), rim, 0.75, 0.125)
    parts.add(*cone, (0.0, 0.0, -drop))
    return parts


def resting(gap: float, drop: float, up: float = 0.0) -> SceneParts:
    """Return a sheet that starts just above a pinned one."""
    parts = SceneParts()
    parts.add(*sheet(3, 0.0, 2.0, at=(-1.0, -1.0)), pinned=1)
    upper = sheet(4, gap, 0.75, at=(-0.359375, -0.390625))
    parts.add(*upper, lambda k, _: (0.0, 0.0, up if k % 4 == 1 else -drop))
    return parts


def apart() -> SceneParts:
    """Return two sheets that slide past each other and meet nothing."""
    parts = two_sheets(0.0625)
    parts.end[:25] = [(x + 0.25, y, z) for x, y, z in parts.end[:25]]
    return parts

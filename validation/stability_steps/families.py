"""Families of steps: a mesh and its motion, each near 1 m and 1 kg, without further trouble.

Each draws a case of about `n` faces. Its start may not be free; `draw.py` makes most of them free.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from validation.stability_steps.case import Case
from validation.stability_steps.meshes import (
    AXES,
    OCTAHEDRON,
    ball,
    join,
    power,
    sheet,
    turn,
    turned,
)

Family: TypeAlias = Callable[[np.random.Generator, int], Case]


def _soup(rng: np.random.Generator, n: int) -> Case:
    """Triangles at random places that fly in all directions, and turn and stretch a little."""
    centres = rng.random((n, 1, 3)) * 1.5 * n ** (1 / 3)
    start = centres + 0.3 * rng.normal(size=(n, 3, 3))
    end = start + power(rng, -1, 1) * rng.normal(size=(n, 1, 3)) + 0.2 * rng.normal(size=(n, 3, 3))
    return _case(start, end, np.arange(3 * n))


def _layers(rng: np.random.Generator, n: int) -> Case:
    """Sheets above one another that are proposed at other heights, in any order."""
    side = int(rng.integers(2, 6))
    count = max(2, round(n / (2 * (side - 1) ** 2)))
    gap = power(rng, -3, -0.5)
    start, faces = join([sheet(side, gap * k) for k in range(count)])
    start += gap * rng.uniform(-0.2, 0.2, start.shape)
    drop = np.repeat(gap * rng.uniform(-3, 3, count), side * side)
    end = start + gap * rng.uniform(-0.5, 0.5, start.shape)
    end[:, 2] += drop
    return _case(start, end, faces)


def _tunnel(rng: np.random.Generator, n: int) -> Case:
    """A body that flies through many sheets, up to 100 edge lengths in one step."""
    side = int(rng.integers(2, 4))
    count = max(1, round((n - 4) / (2 * (side - 1) ** 2)))
    gap = power(rng, -2, 0)
    sheets = [sheet(side, gap * k, 4.0) for k in range(count)]
    points, faces = ball(rng)
    start, faces = join([*sheets, (points + (*rng.uniform(-0.9, 0.9, 2), -1.01), faces)])
    end = start + 1e-3 * rng.normal(size=start.shape)
    end[-len(points) :] += np.array([*rng.normal(size=2), power(rng, 0, 2)])
    pinned = np.arange(len(start)) < (0 if rng.random() < 0.5 else len(start) - len(points))
    return _case(start, end, faces, pinned=pinned)


def _fold(rng: np.random.Generator, n: int) -> Case:
    """A flat sheet that folds over itself, in its plane or by a turn of half of it."""
    side = max(2, round(np.sqrt(n / 2))) + 1
    start, faces = sheet(side)
    start[:, 2] = rng.choice([0.0, power(rng, -16, -3)]) * rng.normal(size=len(start))
    end, crease = start.copy(), rng.uniform(-0.4, 0.4)
    over = start[:, 0] > crease
    if rng.random() < 0.5:
        end[over, 0] = 2.0 * crease - start[over, 0]
    else:
        end[over] = turned(
            start, 1, rng.choice([90, 170, 180, 190, 360]), np.array([crease, 0, 0])
        )[over]
    end += rng.choice([0.0, 0.1]) * rng.normal(size=end.shape) * (1.0, 1.0, rng.integers(2))
    return _case(start, end, faces)


def _in_plane(rng: np.random.Generator, n: int) -> Case:
    """A sheet exactly in a plane that stays in it, while its vertices change places."""
    side = max(2, round(np.sqrt(n / 2))) + 1
    start, faces = sheet(side, float(rng.integers(-1, 2)))
    end, ways = start.copy(), rng.integers(3)
    if ways == 0:
        end[:, :2] += power(rng, -2, 0) * rng.normal(size=(len(start), 2))
    elif ways == 1:
        end = end[rng.permutation(len(end))]
    else:
        end[:, :2] *= rng.uniform(-1.5, 1.5, 2)
    return _case(start, end, faces)


def _slivers(rng: np.random.Generator, n: int) -> Case:
    """Triangles with hardly any area, or none."""
    case = _soup(rng, n)
    start = case.positions_t0.reshape(-1, 3, 3)
    height = np.where(rng.random(n) < 0.2, 0.0, 10.0 ** rng.uniform(-17, -1, n))[:, None]
    along = rng.uniform(-0.2, 1.2, n)[:, None]
    start[:, 2] = (1 - along) * start[:, 0] + along * start[:, 1] + height * rng.normal(size=(n, 3))
    flat = rng.random(n) < 0.5
    end = case.ends[0].reshape(-1, 3, 3)
    end[flat, 2] = (end[flat, 0] + end[flat, 1]) / 2 + height[flat] * rng.normal(size=3)
    return _case(start, end, np.arange(3 * n))


def _needles(rng: np.random.Generator, n: int) -> Case:
    """Faces with edges of all lengths, down to zero and up to 1e6 times the others."""
    case = _soup(rng, n)
    start = case.positions_t0.reshape(-1, 3, 3)
    stretch = 10.0 ** rng.uniform(-12, 6, (n, 1))
    stretch[rng.random(n) < 0.1] = 0.0
    short = start[:, 0] + stretch * (start[:, 1] - start[:, 0])
    end = case.ends[0].reshape(-1, 3, 3) - start
    start[:, 1] = short
    return _case(start, start + end, np.arange(3 * n))


def _grazing(rng: np.random.Generator, n: int) -> Case:
    """Triangles that slide past the corners, sides and plane of others at the last digits."""
    parts_0, parts_1 = [], []
    for k in range(max(1, n // 2)):
        place = np.array([4.0 * k, 0.0, 0.0])
        face = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        tip = np.array([*rng.choice([0.0, 0.25, 0.5, 1.0], 2), 1.0])
        other = tip + np.array([[0.0, 0, 0], [0.25, 0.0, 1.0], [0.0, 0.25, 1.0]])
        last = rng.choice([0.0, 1.0, -1.0]) * rng.choice([0.0, 2.0**-52, 1e-12, 1e-6])
        move = np.array([*(rng.choice([0.0, 0.5, -0.5], 2)), -1.0 + last])
        move *= rng.choice([1.0, 1.0, 2.0, 1.5])
        parts_0 += [face + place, other + place]
        parts_1 += [face + place, other + place + move]
    start, end = np.array(parts_0), np.array(parts_1)
    return _case(start, end, np.arange(3 * len(start)))


def _balls(rng: np.random.Generator, n: int) -> Case:
    """Closed bodies on a lattice that are pressed together, or thrown through one another."""
    count = max(2, n // 6)
    cells = np.argwhere(np.ones((round(count ** (1 / 3)) + 1,) * 3))[:count]
    bodies = [ball(rng) for _ in cells]
    size = rng.uniform(0.2, 0.49)
    places = cells + rng.uniform(-0.01, 0.01, cells.shape)
    parts = [(p * size + at, f) for (p, f), at in zip(bodies, places, strict=True)]
    start, faces = join(parts)
    centre = start.mean(axis=0)
    end = centre + rng.choice([0.9, 0.7, 0.5, 0.3, 0.1, 0.05, 0.0, -1.0]) * (start - centre)
    end += power(rng, -6, -1) * rng.normal(size=end.shape)
    return _case(start, end, faces)


def _cage(rng: np.random.Generator, n: int) -> Case:
    """A pinned ball that shrinks, moves or grows around a free body, or around a single vertex."""
    outer, outer_faces = ball(rng, 1 if n > 12 else 0)
    inner, inner_faces = ball(rng)
    inner = inner * rng.uniform(0.01, 0.3)
    start, faces = join([(outer, outer_faces), (inner, inner_faces)])
    k = len(outer)
    if rng.random() < 0.2:
        start, faces = start[: k + 1], outer_faces
    end = start.copy()
    end[:k] *= rng.choice([0.5, 0.1, 0.0, 2.0])
    end[:k] += rng.choice([0.0, 0.5, 3.0]) * rng.normal(size=3)
    end[k:] += rng.choice([0.0, 0.5, 3.0]) * rng.normal(size=3)
    return _case(start, end, faces, pinned=np.arange(len(start)) < k)


def _swapped(rng: np.random.Generator, n: int) -> Case:
    """Two sheets that change places, or a body or a sheet that is turned inside out."""
    side = max(2, round(np.sqrt(n / 4)) + 1)
    gap = power(rng, -4, 0)
    if rng.random() < 0.5:
        start, faces = join([sheet(side), sheet(side, gap)])
        start[:, :2] += rng.choice([0.0, 0.01]) * rng.normal(size=(len(start), 2))
        end = start.copy()
        end[:, 2] = gap - end[:, 2]
    else:
        alone = rng.normal(size=(4, 3)) * 0.1 + (2.5, 0.0, 0.0)
        start, faces = join([ball(rng, 1), (alone, np.empty((0, 3), int))])
        end = -start
    return _case(start, end, faces)


def _turning(rng: np.random.Generator, n: int) -> Case:
    """Bodies that turn by 90, 180 or more degrees; on a straight path they collapse on the way."""
    case = _balls(rng, n)
    start = case.positions_t0
    centre = start.mean(axis=0) if rng.random() < 0.5 else start[0]
    end = turned(start, int(rng.integers(3)), rng.choice([90, 179, 180, 181, 270, 720]), centre)
    return _case(start, end, case.faces)


def _fans(rng: np.random.Generator, n: int) -> Case:
    """Faces around one edge or one vertex, duplicates, T-junctions and vertices in no face."""
    axis = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    angles = np.sort(rng.random(n)) * 2 * np.pi
    rim = np.column_stack((np.cos(angles), np.sin(angles), rng.random(n)))
    ring = np.arange(n) + 2
    if rng.random() < 0.5:
        faces = np.column_stack((np.zeros(n, int), np.ones(n, int), ring))
    else:
        faces = np.column_stack((np.zeros(n, int), ring, np.roll(ring, -1)))
    if n < 3:
        faces = np.array([[0, 1, 2]])
    if rng.random() < 0.3:
        faces = np.concatenate((faces, faces[:1], faces[:1, ::-1]))
    alone = rng.normal(size=(3, 3))
    start = np.concatenate((axis, rim, alone))
    end = start + power(rng, -2, 0.5) * rng.normal(size=start.shape)
    return _case(start, end, faces)


def _few(rng: np.random.Generator, n: int) -> Case:
    """Meshes of 0, 1 and 2 faces, with vertices in no face."""
    count, alone = int(rng.integers(3)), int(rng.integers(4))
    start = rng.normal(size=(3 * count + alone, 3))
    end = start + power(rng, -2, 1) * rng.normal(size=start.shape)
    if rng.random() < 0.3:
        end[rng.random(len(end)) < 0.5] = 0.0
    return _case(start, end, np.arange(3 * count))


def _collapse(rng: np.random.Generator, n: int) -> Case:
    """Everything is proposed to end in one point, on a line or in a plane, or starts in one."""
    case = _balls(rng, n) if rng.random() < 0.5 else _soup(rng, n)
    start, end = case.positions_t0, case.positions_t0.copy()
    flat = rng.permutation(3)[: rng.integers(1, 4)]
    end[:, flat] = rng.choice([0.0, 1.0, 0.1])
    if rng.random() < 0.2:
        start, end = end, start
    return _case(start, end, case.faces)


def _touching(rng: np.random.Generator, n: int) -> Case:
    """Bodies with small whole numbers as coordinates, many of them in exact contact."""
    side = max(2, round(np.sqrt(n / 4)) + 1)
    table, low = sheet(side, 0.0, side - 1.0)
    parts = [(np.round(table * 2), low)]
    for _ in range(max(1, (n - len(low)) // 8)):
        points = AXES * float(rng.integers(1, 3)) + rng.integers(-side, side + 1, 3).astype(float)
        parts.append((points + (0.0, 0.0, float(rng.integers(0, 3))), OCTAHEDRON[:4]))
    start, faces = join(parts)
    end = start + rng.integers(-2, 3, start.shape) * (rng.random((len(start), 1)) < 0.5)
    end[:, 2] += rng.choice([0.0, -1.0, 1.0])
    return _case(start, end, faces)


def _drape(rng: np.random.Generator, n: int) -> Case:
    """A sheet that falls over a pinned ball."""
    points, low = ball(rng, 1 if n > 60 else 0)
    side = max(2, round(np.sqrt(max(n - len(low), 2) / 2)) + 1)
    cloth, faces = sheet(side, 1.05, 2.5)
    cloth = cloth @ turn(rng).T if rng.random() < 0.1 else cloth
    start, faces = join([(points, low), (cloth + 0.02 * rng.normal(size=cloth.shape), faces)])
    end = start.copy()
    end[len(points) :, 2] -= power(rng, -1, 1)
    end[len(points) :] += 0.05 * rng.normal(size=cloth.shape)
    return _case(start, end, faces, pinned=np.arange(len(start)) < len(points))


def _pinch(rng: np.random.Generator, n: int) -> Case:
    """A sheet between two pinned plates that close to about the thickness that it needs."""
    side = max(2, round(np.sqrt(n / 6)) + 1)
    middle, faces = sheet(side)
    plates = [sheet(2, z, 2.0) for z in (-0.1, 0.1)]
    start, faces = join([*plates, (middle + 0.01 * rng.normal(size=middle.shape), faces)])
    thickness = power(rng, -6, -2)
    gap = thickness * rng.choice([4.0, 2.02, 2.0, 1.98, 1.0, 0.0, -1.0])
    end = start + 0.05 * rng.normal(size=start.shape)
    end[:8] = start[:8]
    end[:8, 2] = np.repeat((-0.5 * gap, 0.5 * gap), 4)
    pinned = np.arange(len(start)) < 8
    return _case(start, end, faces, pinned=pinned).change(thickness=thickness)


def _case(start: object, end: object, faces: object, **more: object) -> Case:
    """Return a case of arrays of any shape with the right number of entries."""
    start, end = (np.array(part, np.float64).reshape(-1, 3) for part in (start, end))
    faces = np.array(faces, np.int32).reshape(-1, 3)
    return Case(positions_t0=start, ends=(end,), faces=faces).change(**more)


FAMILIES: dict[str, Family] = {
    "soup": _soup,
    "layers": _layers,
    "tunnel": _tunnel,
    "fold": _fold,
    "in-plane": _in_plane,
    "slivers": _slivers,
    "needles": _needles,
    "grazing": _grazing,
    "balls": _balls,
    "cage": _cage,
    "swapped": _swapped,
    "turning": _turning,
    "fans": _fans,
    "few": _few,
    "collapse": _collapse,
    "touching": _touching,
    "drape": _drape,
    "pinch": _pinch,
}

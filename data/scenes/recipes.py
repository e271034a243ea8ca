"""The scenes, one function each. Needs numpy alone.

Each function draws from the generator that it is given and from nothing else, so the seed
in `SCENES` fixes the scene. They draw with `Generator.random` only, the simplest of its streams;
numpy 2.0.2 and 2.4.6 make the same files, and `make.py --check` shows whether another one does.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from data.scenes.shapes import (
    Body,
    Sequence,
    Step,
    assemble,
    cloth_masses,
    on_lattice,
    rectangle,
    sphere,
    tube,
    uneven,
)


class Recipe(NamedTuple):
    """How a scene is made."""

    make: Callable[[np.random.Generator], Step | Sequence]  # its docstring describes the scene
    seed: int
    thickness: float  # [m], with which its answer is recorded


def cloth_on_sphere(rng) -> Step:
    """A sheet of cloth falls onto a pinned sphere, and through it."""
    ball, ball_faces = sphere(15, 26, 0.15)
    sheet, sheet_faces = rectangle(30, 30, 0.5, 0.5)
    sheet = uneven(rng, sheet + (0.004, 0.007, 0.1555), 0.0006)
    x, y = sheet[:, 0], sheet[:, 1]
    end = sheet.copy()
    # the corners fall faster, and the cloth ripples
    end[:, 2] -= 0.02 + 1.6 * (x**2 + y**2) + 0.004 * np.sin(40.0 * x) * np.cos(34.0 * y)
    mass = cloth_masses(len(sheet), 0.25)
    return assemble(
        Body(ball, ball, ball_faces, 1.0, True), Body(sheet, end, sheet_faces, mass, False)
    )


def sheets(rng) -> Step:
    """Two uneven sheets move into each other in many places."""
    low, faces = rectangle(18, 18, 0.36, 0.36)
    high = uneven(rng, low + (0.0043, 0.0071, 0.006), 0.0012)
    low = uneven(rng, low, 0.0012)
    ends = []
    for sheet, towards in ((low, 1.0), (high, -1.0)):
        x, y = sheet[:, 0], sheet[:, 1]
        end = sheet + (0.01, 0.004 * towards, 0.0)
        bumps = np.maximum(np.sin(24.0 * x + 2.0) * np.sin(19.0 * y + 1.0), 0.0)
        end[:, 2] += towards * (0.0005 + 0.012 * bumps)
        ends.append(end)
    mass = cloth_masses(len(low), 0.13)
    return assemble(Body(low, ends[0], faces, mass, False), Body(high, ends[1], faces, mass, False))


def stack(rng) -> Step:
    """Four sheets fall through one another and through a pinned floor."""
    floor, floor_faces = rectangle(5, 5, 0.4, 0.4)
    sheet, faces = rectangle(12, 12, 0.24, 0.24)
    bodies = [Body(floor, floor, floor_faces, 1.0, True)]
    for layer in range(4):
        start = uneven(rng, sheet + (0.003 * layer, -0.002 * layer, 0.004 * (layer + 1)), 0.001)
        end = start.copy()
        # each layer falls farther than the one below it, through all of them and the floor
        end[:, 2] -= 0.004 * (layer + 1) + 0.0015 * (layer + 1) * rng.random(len(start)) + 0.001
        bodies.append(Body(start, end, faces, cloth_masses(len(start), 0.0576), False))
    return assemble(*bodies)


def crumple(rng) -> Step:
    """The folds of one sheet lean into each other: it collides with itself."""
    flat, faces = rectangle(43, 12, 1.0, 0.2)
    u, v = flat[:, 0], flat[:, 1]
    start = np.column_stack((0.2 * u, v, 0.045 * np.sin(6.0 * np.pi * u)))
    start = uneven(rng, start, 0.0008)
    end = start.copy()
    # neighbouring folds lean towards each other until they overlap
    end[:, 0] += 0.026 * np.sin(9.0 * np.pi * u + 1.0) + 0.012 * np.sin(30.0 * v)
    end[:, 0] += 0.020 * np.sin(6.0 * np.pi * u) * np.sin(25.0 * v + 8.0 * u)
    end[:, 2] *= 0.85
    return assemble(Body(start, end, faces, cloth_masses(len(start), 0.12), False))


def _jaws(gap, curvature=0.15):
    """Two pinned plates that close to `gap` [m] at their middle, and are `curvature` [1/m] bent."""
    plate, faces = rectangle(9, 9, 0.3, 0.3)
    bow = curvature * (plate[:, 0] ** 2 + plate[:, 1] ** 2)
    jaws = []
    for side in (-1.0, 1.0):
        start, end = plate.copy(), plate.copy()
        # shifted, so that no vertex of one plate lies above a vertex of the other
        start[:, :2] += side * np.array([0.0061, 0.0033])
        end[:, :2] = start[:, :2]
        start[:, 2] = side * (0.03 + bow)
        end[:, 2] = side * (0.5 * gap + bow)
        jaws.append(Body(start, end, faces, 1.0, True))
    return jaws


def _between(rng, amplitude, n=20, flatness=1.0):
    """A sheet that is to bulge out to both sides by `amplitude` [m]."""
    sheet, faces = rectangle(n, n, 0.24, 0.24)
    start = uneven(rng, sheet, 0.001) * (1.0, 1.0, flatness) + (0.002, 0.003, 0.0)
    end = start.copy()
    end[:, 2] += amplitude * np.sin(38.0 * start[:, 0] + 0.5) * np.cos(31.0 * start[:, 1])
    return Body(start, end, faces, cloth_masses(len(start), 0.0576), False)


def pinch_free(rng) -> Step:
    """Two pinned plates close on a sheet and leave enough room for it."""
    return assemble(*_jaws(0.006), _between(rng, 0.022))


def pinch_tight(rng) -> Step:
    """Two pinned plates leave less room than the thickness."""
    return assemble(*_jaws(0.0004, 0.02), _between(rng, 0.003, 16, 0.1))


def pinch_blocked(rng) -> Step:
    """Two pinned plates pass through each other."""
    return assemble(*_jaws(-0.004), _between(rng, 0.022, 13))


def moving_obstacle(rng) -> Step:
    """A pinned sphere moves through a hanging cloth with a pinned rim."""
    ball, ball_faces = sphere(10, 16, 0.07)
    ball = ball @ np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, -0.8, 0.6]])
    sheet, faces = rectangle(24, 24, 0.4, 0.4)
    # it hangs in the plane x = 0 from its pinned upper rim
    hanging = uneven(rng, sheet[:, [2, 1, 0]], 0.0008)
    end = hanging + (0.004, 0.0, 0.0) * np.sin(12.0 * hanging[:, 1:2])
    rim = np.arange(len(sheet)) // 24 == 23
    end[rim] = hanging[rim]
    away = np.array([-0.08, 0.013, -0.021])
    mass = cloth_masses(len(sheet), 0.16)
    return assemble(
        Body(ball + away, ball + away + (0.09, 0.0, 0.02), ball_faces, 1.0, True),
        Body(hanging, end, faces, mass, rim),
    )


def mass_ratios(rng) -> Step:
    """Three sheets whose vertex masses range over six decades."""
    sheet, faces = rectangle(14, 14, 0.28, 0.28)
    bodies = []
    for layer in range(3):
        start = uneven(rng, sheet + (0.004 * layer, 0.003 * layer, 0.005 * layer), 0.0008)
        end = start.copy()
        waves = np.sin(31.0 * start[:, 0] + 2.0 * layer) * np.cos(27.0 * start[:, 1])
        end[:, 2] += (1 - layer) * 0.003 * (0.4 + rng.random(len(start))) + 0.003 * waves
        masses = 10.0 ** np.rint(6.0 * rng.random(len(start)) - 3.0)
        bodies.append(Body(start, end, faces, masses, False))
    return assemble(*bodies)


def at_rest(rng) -> Step:
    """One ball hits a few of sixteen balls that rest close to each other."""
    ball, faces = sphere(6, 8, 0.05)
    bodies = []
    for i in range(4):
        for j in range(4):
            centre = np.array([0.104 * i + 0.052 * (j % 2), 0.092 * j, 0.0])
            resting = uneven(rng, ball, 0.001) + centre
            bodies.append(Body(resting, resting, faces, 0.002, False))
    thrown = uneven(rng, ball, 0.001) + (0.19, 0.14, 0.13)
    bodies.append(Body(thrown, thrown + (0.03, 0.02, -0.07), faces, 0.01, False))
    return assemble(*bodies)


def swapped(rng) -> Step:
    """Two regular sheets change places: both ends are free, the path is not."""
    low, faces = rectangle(11, 11, 0.15625, 0.15625)
    high = low + (2.0**-8, 0.0, 2.0**-6)
    up, down = (0.0, 0.0, 2.0**-5), (0.0, 0.0, -(2.0**-6))
    mass = cloth_masses(len(low), 0.0244)
    return assemble(
        Body(low, low + up, faces, mass, False), Body(high, high + down, faces, mass, False)
    )


def sleeve(rng) -> Sequence:
    """An animation: a sleeve bends too sharply for the arm inside it."""
    frames = 6
    arm, arm_faces = tube(25, 14, 0.5, 0.045)
    cuff, cuff_faces = tube(23, 20, 0.36, 0.051)
    angle = np.arctan2(cuff[:, 2], cuff[:, 1])
    cuff = uneven(rng, cuff, 0.0006)
    wrinkles = np.sin(70.0 * cuff[:, 0] + 1.3 * np.sin(3.0 * angle))
    cuff[:, 1:] *= 1.0 + 0.02 * (1.0 + wrinkles[:, None])
    positions = []
    for bend in np.linspace(0.0, np.radians(60.0), frames):
        bent_arm = _bend(arm, bend, 0.16)
        # the animator's sleeve bends at the elbow alone, too sharply for the arm
        bent_cuff = _bend(cuff, bend, 0.05)
        positions.append(np.concatenate((bent_arm, bent_cuff)))
    n = len(arm)
    masses = np.full(n + len(cuff), cloth_masses(len(cuff), 0.115))
    return Sequence(
        on_lattice(positions),
        np.concatenate((arm_faces, cuff_faces + n)).astype(np.int32),
        masses,
        np.arange(len(masses)) < n,
    )


def _bend(positions, angle, length):
    """Bend a tube around the x axis by an angle, evenly over a length [m] at its middle."""
    if angle == 0.0:
        return positions
    radius = length / angle
    x, y, z = positions.T
    inside = np.clip(x, -0.5 * length, 0.5 * length)
    turn = inside / radius
    beyond = x - inside
    along = (radius - z) * np.sin(turn) + beyond * np.cos(turn)
    up = radius - (radius - z) * np.cos(turn) + beyond * np.sin(turn)
    return np.column_stack((along, y, up))


SCENES = {
    "cloth-on-sphere": Recipe(cloth_on_sphere, 1, 0.0002),
    "sheets": Recipe(sheets, 2, 0.0001),
    "stack": Recipe(stack, 3, 0.0001),
    "crumple": Recipe(crumple, 4, 0.0001),
    "pinch-free": Recipe(pinch_free, 5, 0.0002),
    "pinch-tight": Recipe(pinch_tight, 6, 0.0005),
    "pinch-blocked": Recipe(pinch_blocked, 7, 0.0002),
    "moving-obstacle": Recipe(moving_obstacle, 8, 0.0002),
    "mass-ratios": Recipe(mass_ratios, 9, 0.0001),
    "at-rest": Recipe(at_rest, 10, 0.0001),
    "swapped": Recipe(swapped, 11, 0.0001),
    "sleeve": Recipe(sleeve, 12, 0.0002),
}

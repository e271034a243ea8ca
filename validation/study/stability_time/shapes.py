"""Steps that are made by recipes, with any number of triangles.

* `sheets`: grids above one another.
* `fan`: discs above one another, each with one vertex that all its triangles share.
* `soup`: separate triangles in a lattice of cells, each in its own cell.
* `weave`: layers of long separate triangles, along x in one layer and along y in the next.
* `hub`: one free triangle in the middle of a ball of small ones that move toward it.
* `balls`: balls that are pressed together.

Every start is free: the layers are flat to 0.3 gaps, and nothing leaves its layer or its cell.
"""

from __future__ import annotations

import math

import numpy as np

from izo_ref.base.arrays import AnyInts, Floats
from izo_ref.scene import Scene
from validation.scenes.balls import BALL_FACES, pressed_balls
from validation.scenes.sheets import grid_faces
from validation.study.stability_time.recipe import Recipe


def step_of(recipe: Recipe, n_triangles: int, seed: int) -> Scene:
    """Make a step.

    Args:
        recipe: How it is made.
        n_triangles: Triangles, about.
        seed: Seed of all that is random in it.
    """
    rng = np.random.default_rng([seed, n_triangles])
    if recipe.kind == "balls":
        return _changed_balls(recipe, rng, max(2, round(n_triangles / BALL_FACES)))
    if recipe.kind in ("soup", "hub"):
        return _loose(recipe, rng, n_triangles)
    layers = max(2, min(round(recipe.layers), n_triangles // 4))
    make = {"sheets": _grid, "fan": _fan, "weave": _needles}[recipe.kind]
    parts = [make(max(2, n_triangles // layers), recipe.aspect, k) for k in range(layers)]
    offsets = np.cumsum([0, *(len(points) for points, _ in parts)])
    start = np.zeros((offsets[-1], 3))
    layer = np.repeat(np.arange(layers), np.diff(offsets))
    start[:, :2] = np.concatenate([points for points, _ in parts])
    start[:, :2] += 0.137 * layer[:, None] * (1.0, 0.61)
    bumps = recipe.uneven * rng.uniform(-1.0, 1.0, len(start))
    start[:, 2] = recipe.gap * (layer + bumps)
    faces = np.concatenate([own + at for (_, own), at in zip(parts, offsets, strict=False)])
    end = start.copy()
    # each layer goes down by its height and more: those above go through all those below
    end[:, 2] -= recipe.depth * recipe.gap * layer * rng.uniform(0.8, 1.2, layers)[layer]
    turn = rng.uniform(0.0, 2.0 * math.pi, layers)[layer]
    end[:, :2] += recipe.slide * np.column_stack((np.cos(turn), np.sin(turn)))
    return _scene(recipe, rng, start, end, faces)


def _scene(
    recipe: Recipe, rng: np.random.Generator, start: Floats, end: Floats, faces: AnyInts
) -> Scene:
    """Return a step, with the noise, the masses and the pinned vertices of a recipe."""
    n = len(start)
    end = end + recipe.noise * rng.uniform(-1.0, 1.0, (n, 3))
    masses = recipe.mass_ratio ** rng.uniform(0.0, 1.0, n)
    pinned = np.zeros(n, bool)
    pinned[: int(recipe.pinned * n)] = True
    return Scene(start, np.where(pinned[:, None], start, end), faces, masses, pinned)


def _grid(n_triangles: int, aspect: float, layer: int) -> tuple[Floats, AnyInts]:
    """Return (k, 2) f8 and (m, 3): a square grid, longer along x by the aspect."""
    n = max(1, round(math.sqrt(n_triangles / 2.0))) + 1
    points = np.column_stack(np.divmod(np.arange(n * n), n)).astype(float)
    return points * (aspect, 1.0), grid_faces(n)


def _fan(n_triangles: int, aspect: float, layer: int) -> tuple[Floats, AnyInts]:
    """Return (k, 2) f8 and (m, 3): a disc of triangles around one vertex."""
    n = max(3, n_triangles)
    angle = 2.0 * math.pi * (np.arange(n) + 0.3 * layer) / n
    rim = max(1.0, math.sqrt(n)) * np.column_stack((np.cos(angle), np.sin(angle)))
    i = np.arange(n, dtype=np.int32)
    faces = np.column_stack((np.zeros(n, np.int32), 1 + i, 1 + (i + 1) % n))
    return np.concatenate((np.zeros((1, 2)), rim)) * (aspect, 1.0), faces


def _needles(n_triangles: int, aspect: float, layer: int) -> tuple[Floats, AnyInts]:
    """Return (k, 2) f8 and (m, 3): separate triangles that are as long as the layer is wide."""
    n = n_triangles
    y, half = np.arange(n) - 0.5 * n, 0.5 * n + 1.0
    width = 0.4 / aspect
    corners = np.empty((n, 3, 2))
    corners[:, 0] = np.column_stack((np.full(n, -half), y))
    corners[:, 1] = np.column_stack((np.full(n, half), y))
    corners[:, 2] = np.column_stack((np.full(n, half), y + width))
    points = corners.reshape(-1, 2)
    if layer % 2:
        points = points[:, ::-1].copy()
    return points, np.arange(3 * n, dtype=np.int32).reshape(-1, 3)


def _loose(recipe: Recipe, rng: np.random.Generator, n: int) -> Scene:
    """Return separate triangles, each in a cell of a lattice; those of a hub move to the middle."""
    side = math.ceil(n ** (1.0 / 3.0) - 1e-9)
    cells = np.stack(np.unravel_index(rng.permutation(side**3)[:n], (side,) * 3), axis=1)
    centres = cells - 0.5 * (side - 1)
    corners = rng.uniform(-0.45, 0.45, (n, 3, 3))
    corners[:, 1:, 0] = corners[:, :1, 0] + (corners[:, 1:, 0] - corners[:, :1, 0]) / recipe.aspect
    start = (centres[:, None] + corners).reshape(-1, 3)
    if recipe.kind == "hub":  # all come to the middle, where one triangle is
        moved = np.repeat(-min(recipe.depth, 1.0) * centres, 3, axis=0)
    else:
        way = rng.normal(size=(n, 3))
        way *= recipe.depth / np.linalg.norm(way, axis=1, keepdims=True)
        moved = np.repeat(way, 3, axis=0)
    return _scene(recipe, rng, start, start + moved, np.arange(3 * n).reshape(-1, 3))


def _changed_balls(recipe: Recipe, rng: np.random.Generator, n: int) -> Scene:
    """Return balls that are pressed together more or less, and thrown at random."""
    step = pressed_balls(rng, n)
    start, moved = step.positions_t0, step.positions_t1 - step.positions_t0
    edge = 0.004  # [m], of a triangle of a ball, about
    unit = recipe._replace(noise=recipe.noise * edge)
    return _scene(unit, rng, start, start + recipe.depth / 0.6 * moved, step.faces)


def thickness_of(recipe: Recipe, scene: Scene) -> float:
    """Return the thickness of a recipe in the unit of its step."""
    a, b = scene.edges.T
    lengths = np.linalg.norm(scene.positions_t0[a] - scene.positions_t0[b], axis=1)
    return recipe.thickness * float(np.median(lengths))

"""Small scenes whose traces have every kind of iteration."""

import numpy as np

from izo_ref import Options, Scene
from tests.helpers.seams import centres, crossing_cloths, cut, shuffled
from tests.helpers.shapes import falling_sheet, pinched_sheet, two_sheets

THICKNESS = 1e-3


def welded_scene(rng):
    """Return two sheets with a seam; the vertices are in any order."""
    mesh = crossing_cloths(rng, 4)
    mesh["masses"] = rng.uniform(0.1, 10.0, len(mesh["positions_t0"]))
    mesh["pinned"] = np.arange(len(mesh["masses"])) < 3
    return Scene(**shuffled(rng, cut(mesh, centres(mesh)[:, 0] > 0.5)), weld=0)


def scenes(rng):
    """Return small scenes by name, each with a thickness and options."""
    plain, spent = Options(), Options(max_iterations=1)
    return {
        "sheets": (two_sheets(rng, 4), THICKNESS, plain),
        "pinned": (two_sheets(rng, 4, pinned_below=True), THICKNESS, plain),
        "all": (two_sheets(rng, 4), THICKNESS, Options(selection="all", relinearize=2)),
        "deep": (falling_sheet(3, 20.0, n=2), THICKNESS, plain),
        "welded": (welded_scene(rng), THICKNESS, plain),
        "scaled back": (two_sheets(rng, 4), THICKNESS, spent),
        "blocked": (pinched_sheet(-0.01, bump=0.2, side=2), THICKNESS, plain),
        "tiny": (times(two_sheets(rng, 4), -400), THICKNESS * 2.0**-400, plain),
    }


NAMES = ["sheets", "pinned", "all", "deep", "welded", "scaled back", "blocked", "tiny"]


def times(scene, exponent):
    """Return a scene whose lengths are multiplied by a power of two."""
    ends = (np.ldexp(end, exponent) for end in (scene.positions_t0, scene.positions_t1))
    return Scene(*ends, scene.faces, scene.masses, scene.pinned)

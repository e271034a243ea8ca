"""Compile what the inputs need, so that no input is slow because it is the first of its kind."""

import numpy as np

import izo_ref
from izo_ref.base.options import CHOICES, LAGRANGIAN, PRESET_METHODS, SWEEPS

START = np.array([[-2.0, -2, 0], [2, -2, 0], [0, 3, 0], [0, 0, 0.5], [0.1, 0.1, 0.6]])
END = START - [0.0, 0, 1] * np.array([0.0, 0, 0, 1, 1])[:, None]


def warm_up() -> None:
    """Resolve a small step by every method, in every precision, and with every preset."""
    named = [{"method": method} for method in CHOICES["method"]]
    named += [{"method": m, "precision": "float32"} for m in (*LAGRANGIAN, *SWEEPS)]
    named += [{"preset": preset} for preset in PRESET_METHODS]
    named += [{"small_zone": 0}, {"plan": "everything"}, {"selection": "all"}]
    scene = izo_ref.Scene(START, END, [[0, 1, 2]], initial_intersections="ratchet")
    for given in named:
        izo_ref.resolve(scene, 0.01, options=izo_ref.Options(**given))
    izo_ref.Scene(START, END, [[0, 1, 2], [0, 1, 3]], weld=0.0, initial_intersections="exclude")
    crossing = np.concatenate((START[:3], [[0, 0, 1], [0, 0, -1], [0, 1, -1.0]]))
    mesh = crossing, crossing, [[0, 1, 2], [3, 4, 5]]
    izo_ref.resolve(izo_ref.Scene(*mesh, initial_intersections="ratchet"), 0.01)

"""Stiff zones: masses, constraints and weights far apart; the penalties are in `penalties.py`."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from izo_ref.zones.problem import ZoneProblem
from validation.ladders.judge_large import judge_large
from validation.ladders.judge_zone import judge_zone
from validation.ladders.ladder import Ladder, Outcome, Rung, worst
from validation.ladders.penalties import PENALTIES
from validation.oracles.slsqp import solve_raw, solve_scaled
from validation.scenes.piles import chain_zone, pinch_zone, stack_zone
from validation.scenes.stiff_zones import (
    cone_zone,
    copied_zone,
    edge_zone,
    lever_zone,
    slab_zone,
    wedge_zone,
)
from validation.scenes.zones import random_zone

FAMILY = "stiff"
DRAWS = 3  # zones of each rung, with seeds of their own
EXACT = "Rational numbers give the optimum."
METHODS = (
    "active-set",
    "interior-point",
    "pgs",
    "apgs",
    "gradient",
    "jacobi",
    "chebyshev",
    "cg",
    "lbfgs",
    "newton",
)
# A gap g bounds the relative error by sqrt(2 g). Methods that iterate are asked for this gap, and
# an answer of theirs is right up to this error.
ITERATED_GAP, ITERATED_ERROR, MOST_STEPS = 1e-12, 2e-6, 20_000
RATIOS = tuple(10.0**k for k in (*range(0, 28, 2), 27, 28, 29, 30, 31, 35, 50))
FEW_RATIOS = tuple(10.0**k for k in (0, 2, 4, 6, 8, 10, 12, 16, 20, 24, 30))
ANGLES = (
    *(10.0**-k for k in range(1, 6)),
    3e-6,
    2e-6,
    1e-6,
    3e-7,
    *(10.0**-k for k in range(7, 18)),
    0.0,
)
FEW_ANGLES = tuple(10.0**-k for k in (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16))
SLSQP = {"SLSQP": solve_raw, "SLSQP, scaled": solve_scaled}

Draw = Callable[[np.random.Generator, float], ZoneProblem]


def _run(draw: Draw, draws: int = DRAWS, **settings: Any) -> Callable[[Rung], list[Outcome]]:
    """Return a run that judges some zones of a rung, and returns the worst outcome of each program.

    Args:
        draw: Makes a zone from a generator and the rung.
        draws: Number of zones.
        settings: Further arguments of `judge_zone`.
    """

    def run(rung: Rung) -> list[Outcome]:
        value = float(rung)
        zones = (draw(np.random.default_rng(seed), value) for seed in range(draws))
        return worst(judge_zone(zone, **settings) for zone in zones)

    return run


def _ladder(
    name: str, sentence: str, unit: str, rungs: Sequence[float], draw: Draw, **more: Any
) -> Ladder:
    """Return a ladder of small zones; `more` has fields of `Ladder`, and arguments of `_run`."""
    fields = {key: more.pop(key) for key in ("quick", "wanted", "seconds") if key in more}
    return Ladder(FAMILY, name, f"{sentence} {EXACT}", unit, rungs, _run(draw, **more), **fields)


def _iterated(method: str) -> dict[str, Any]:
    """Return the arguments of `judge_zone` for a method that was asked for by name."""
    if method == "active-set":
        return {"method": method}
    steps = {} if method == "interior-point" else {"max_steps": MOST_STEPS}
    return {"method": method, "tolerance": ITERATED_ERROR, "gap": ITERATED_GAP, **steps}


def _masses() -> list[Ladder]:
    """Return ladders of mass ratios."""
    told = "The heaviest vertex of {} weighs so many times the lightest."
    common: dict[str, Any] = {"quick": (1e12,), "wanted": 1e12}
    unit = "mass ratio"
    return [
        _ladder(
            "masses, one impact", told.format("a zone of one impact"), unit, RATIOS,
            lambda rng, ratio: random_zone(rng, 1, ratio), others=SLSQP, **common,
        ),
        _ladder(
            "masses, 8 impacts", told.format("a random zone of 8 impacts"), unit, RATIOS,
            lambda rng, ratio: random_zone(rng, 8, ratio), others=SLSQP, wanted=1e12,
        ),
        _ladder(
            "masses, 60 impacts", told.format("a random zone of 60 impacts"), unit, RATIOS,
            lambda rng, ratio: random_zone(rng, 60, ratio), **common,
        ),
        _ladder(
            "masses, chain", told.format("a chain of 40 pairs of edges"), unit, RATIOS,
            lambda rng, ratio: chain_zone(rng, 40, ratio), **common,
        ),
        _ladder(
            "masses, stack", told.format("four small sheets on one another, the lowest pinned,"),
            unit, RATIOS, lambda rng, ratio: stack_zone(rng, 4, 5, ratio), **common,
        ),
        _ladder(
            "masses, pinch", told.format("12 vertices between faces that press on them"), unit,
            RATIOS, lambda rng, ratio: pinch_zone(rng, 24, ratio), **common,
        ),
        *(
            _ladder(
                f"masses, {method}",
                f"The method `{method}` solves a chain of 12 pairs of edges, whose heaviest vertex "
                "weighs so many times the lightest.",
                unit, FEW_RATIOS, lambda rng, ratio: chain_zone(rng, 12, ratio),
                quick=(1e2,), **_iterated(method),
            )
            for method in METHODS
        ),
    ]  # fmt: skip


def _dependent() -> list[Ladder]:
    """Return ladders of constraints that are nearly dependent."""
    told = (
        "Two half-spaces push a vertex out of a face, with this angle between their normals; with "
        "equal masses the condition number is (2 / angle)^2."
    )
    unit = "angle [rad]"
    return [
        _ladder(
            "angle, equal masses", told, unit, ANGLES, wedge_zone, others=SLSQP, wanted=2e-6,
            quick=(1e-3, 2e-6, 0.0),
        ),
        _ladder(
            "angle, mass ratio 1e12", told, unit, ANGLES,
            lambda rng, angle: wedge_zone(rng, angle, 1e12), quick=(1e-3,), wanted=2e-6,
        ),
        _ladder(
            "angle, 12 half-spaces",
            "12 half-spaces, of which three are independent, push a vertex out of a face, with "
            "normals at this angle to an axis.",
            unit, ANGLES, lambda rng, angle: cone_zone(rng, angle, 12), quick=(1e-3, 0.0),
        ),
        *(
            _ladder(f"angle, {method}", f"The method `{method}`: {told}", unit, FEW_ANGLES,
                    wedge_zone, quick=(1e-1,), **_iterated(method))
            for method in METHODS
        ),
    ]  # fmt: skip


def _copies(rung: Rung) -> list[Outcome]:
    draws = []
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        base = chain_zone(rng, 8, 1e3)
        copied = copied_zone(rng, base, int(rung))
        draws.append(judge_zone(copied, exact=base, tolerance=1e-9))
    return worst(draws)


def _singular() -> list[Ladder]:
    """Return ladders of copied and of opposed constraints, and of small weights."""
    widths = (1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0, -1e-15, -1e-12, -1e-10, -1e-9, -2e-9, -1e-8,
              -1e-6, -1e-3, -0.1, -1.0, -10.0)  # fmt: skip
    weights = (*(10.0**-k for k in (1, 2, 4, 6, 8, 10, 12, 15, 20, 30, 50, 100, 200, 300)), 0.0)
    slab = "A vertex between two {} has so much room, as a fraction of the thickness; {}."
    copied = (
        "Each impact of a chain of 8 occurs so many times; the optimum is that of the chain alone."
    )
    return [
        Ladder(
            FAMILY, "copies", f"{copied} {EXACT}", "copies",
            (1.0, 2.0, 4.0, 8.0, 16.0, 31.0, 32.0, 33.0, 64.0, 128.0, 256.0, 512.0, 1024.0),
            _copies, quick=(4.0, 33.0), wanted=1024.0,
        ),
        _ladder(
            "slab, pinned faces",
            slab.format("pinned faces", "with less than none, no positions satisfy both"),
            "room / thickness", widths, slab_zone, others=SLSQP, quick=(1e-9, 0.0, -1e-6),
            wanted=-10.0,
        ),
        _ladder(
            "slab, heavy faces",
            slab.format(
                "faces whose vertices weigh 1e12 times as much",
                "with less than none, the faces have to move",
            ),
            "room / thickness", widths, lambda rng, width: slab_zone(rng, width, 1e12),
            others=SLSQP, quick=(1e-9, -1e-3), wanted=-10.0,
        ),
        _ladder(
            "weight of a corner",
            "A vertex meets a face, and one corner of the face has this weight.", "weight",
            weights, lambda rng, weight: lever_zone(rng, weight, pinned=False), quick=(1e-12, 0.0),
            wanted=0.0,
        ),
        _ladder(
            "lever",
            "A pinned vertex meets a face, of which one corner alone is free. That corner has this "
            "weight, so it moves by the depth over the weight; with a weight of 0 there is no "
            "solution.",
            "weight", weights, lambda rng, weight: lever_zone(rng, weight, pinned=True),
            quick=(1e-4, 0.0),
        ),
        _ladder(
            "end of an edge",
            "Two edges cross at this fraction of the length of each.", "fraction of the length",
            weights, edge_zone, quick=(1e-12,), wanted=0.0,
        ),
    ]  # fmt: skip


def _large(draw: Draw) -> Callable[[Rung], list[Outcome]]:
    def run(rung: Rung) -> list[Outcome]:
        return [judge_large(draw(np.random.default_rng(0), float(rung)))]

    return run


def _large_zones() -> list[Ladder]:
    """Return ladders of zones that are too large for rational numbers."""
    told = (
        "The heaviest vertex of {} weighs so many times the lightest. The distance to the optimum "
        "is proved (`distance_bound`), and another solver at a tolerance of 1e-12 stands beside."
    )
    shapes: dict[str, tuple[str, Draw]] = {
        "chain": ("a chain of 1000 pairs of edges", lambda rng, m: chain_zone(rng, 1000, m)),
        "pinch": ("500 vertices between faces", lambda rng, m: pinch_zone(rng, 1000, m)),
        "stack": ("five sheets, 1568 impacts,", lambda rng, m: stack_zone(rng, 5, 16, m)),
        "random": ("a random zone of 1000 impacts", lambda rng, m: random_zone(rng, 1000, m)),
    }
    return [
        Ladder(
            FAMILY, f"masses, large {name}", told.format(words), "mass ratio", FEW_RATIOS,
            _large(draw), seconds=240.0, wanted=None if name == "random" else 1e12,
        )
        for name, (words, draw) in shapes.items()
    ]  # fmt: skip


LADDERS: list[Ladder] = [
    *_masses(),
    *_dependent(),
    *_singular(),
    *_large_zones(),
    *PENALTIES,
]

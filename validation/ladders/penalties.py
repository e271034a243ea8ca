"""Ladders of the penalty mu, and of the scalings of the three presets."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np

from izo_ref.solvers.presets import METHOD_PARAMETERS, PRESETS
from izo_ref.zones.problem import ZoneProblem
from validation.ladders.judge_zone import judge_zone
from validation.ladders.ladder import Ladder, Outcome, Rung, worst
from validation.scenes.piles import chain_zone

Zones: TypeAlias = Callable[[float], Iterable[ZoneProblem]]

FAMILY = "stiff"
DRAWS = 3
USUAL = 1e3  # penalty of the presets
# From the usual value to both sides, so that each ladder goes from mild to absurd.
SIDES = {
    "smaller": tuple(10.0**-k for k in range(7)),
    "larger": tuple(10.0**k for k in range(13)),
}
SIZES = {
    "smaller": tuple(10.0**-k for k in range(7)),
    "larger": tuple(10.0**k for k in range(7)),
}
RATIOS = tuple(10.0**k for k in (0, 1, 2, 3, 4, 6, 8, 10, 12, 16, 20))
# How the multipliers are updated, and whether the penalty grows.
UPDATES = {
    "each step": {"multiplier_update": "every-step"},
    "inner solves": {"multiplier_update": "inner-solve"},
    "growing": {"multiplier_update": "inner-solve", "penalty": "grown"},
}
# A gap g bounds the relative error by sqrt(2 g): this gap is asked for, and this error is right.
SETTINGS: dict[str, Any] = {"gap": 1e-12, "tolerance": 2e-6, "max_steps": 20_000}
GROWN = 1e8  # a penalty that grows does so up to this, or to where it begins
OURS = (
    "The penalty of `{}` is this, with multipliers updated {}; {}. Rational numbers give the "
    "optimum of a chain of 8 pairs of edges."
)
WORDS = {
    "each step": ("in each step", "users get one that suits the zone"),
    "inner solves": ("after inner solves", "users get 3, 30 or 1000, by the method"),
    "growing": ("after inner solves", "it grows when the violation does not fall enough"),
}
PRESET_ERROR = 0.01  # the presets stop where their systems do
PRESET = (
    "The preset `{}` solves a chain of 8 pairs of edges, {}. Rational numbers give the optimum, "
    "and an answer within 1 % of it is right. The preset stops after as many steps as its system "
    "does."
)


@contextmanager
def method_penalty(method: str, mu: float) -> Iterator[None]:
    """Give a method another penalty, which no option can do.

    Args:
        method: An augmented-Lagrangian method.
        mu: Its penalty, without unit.
    """
    kept = METHOD_PARAMETERS[method]
    METHOD_PARAMETERS[method] = kept._replace(
        mu_every_step=mu, mu_inner_solve=mu, mu_cap=max(mu, GROWN)
    )
    try:
        yield
    finally:
        METHOD_PARAMETERS[method] = kept


@contextmanager
def preset_penalty(preset: str, mu: float) -> Iterator[None]:
    """Give a preset another penalty, in the unit of its system."""
    kept = PRESETS[preset]
    PRESETS[preset] = kept._replace(mu=mu)
    try:
        yield
    finally:
        PRESETS[preset] = kept


def _zones(mass_ratio: float = 1.0, size: float = 1.0) -> Iterator[ZoneProblem]:
    """Yield the zones of a rung; with another size, all lengths are multiplied by it."""
    for seed in range(DRAWS):
        zone = chain_zone(np.random.default_rng(seed), 8, mass_ratio)
        parts = zone.nodes, zone.weights, zone.normals
        yield ZoneProblem(*parts, zone.proposed * size, zone.masses, zone.thickness * size)


def _method(method: str, update: str, side: str) -> Ladder:
    def run(rung: Rung) -> list[Outcome]:
        with method_penalty(method, float(rung)):
            return worst(
                judge_zone(zone, method=method, **UPDATES[update], **SETTINGS) for zone in _zones()
            )

    sentence = OURS.format(method, *WORDS[update])
    quick = (1.0,) if side == "larger" and method == "newton" else ()
    return Ladder(
        FAMILY, f"{side} penalty, {method}, {update}", sentence, "mu", SIDES[side], run, quick
    )


def _preset(preset: str, name: str, words: str, rungs: Sequence[float], zones: Zones) -> Ladder:
    def run(rung: Rung) -> list[Outcome]:
        return worst(_judge_preset(zone, preset) for zone in zones(float(rung)))

    unit = "mass ratio" if name == "masses" else "factor"
    return Ladder(FAMILY, f"{name}, {preset}", PRESET.format(preset, words), unit, rungs, run)


def _preset_penalty(preset: str, side: str) -> Ladder:
    def run(rung: Rung) -> list[Outcome]:
        with preset_penalty(preset, USUAL * float(rung)):
            return worst(_judge_preset(zone, preset) for zone in _zones())

    words = "with so many times the penalty of its system"
    sentence = PRESET.format(preset, words)
    return Ladder(FAMILY, f"{side} penalty, {preset}", sentence, "factor", SIDES[side], run)


def _judge_preset(zone: ZoneProblem, preset: str) -> list[Outcome]:
    return judge_zone(zone, preset=preset, tolerance=PRESET_ERROR)


PENALTIES: list[Ladder] = [
    *(
        _method(method, update, side)
        for method in METHOD_PARAMETERS
        for update in UPDATES
        for side in SIDES
    ),
    *(_preset_penalty(preset, side) for preset in PRESETS for side in SIDES),
    *(
        _preset(
            preset, "masses", "whose heaviest vertex weighs so many times the lightest", RATIOS,
            lambda ratio: _zones(mass_ratio=ratio),
        )
        for preset in PRESETS
    ),
    *(
        _preset(
            preset, f"{side} size", "with all lengths multiplied by this", rungs,
            lambda size: _zones(size=size),
        )
        for preset in PRESETS
        for side, rungs in SIZES.items()
    ),
]  # fmt: skip

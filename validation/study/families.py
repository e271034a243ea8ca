"""Families of zone problems on which studies compare solvers: random, structured and recorded."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from izo_ref.loop.resolve import resolve
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import zone_problem
from validation.scenes.piles import chain_zone, pinch_zone, stack_zone
from validation.scenes.zones import random_zone
from validation.study import steps

SEED = 20240607
STEP_THICKNESS_M = 1e-4


class Family(NamedTuple):
    """Zone problems of one kind.

    The families of a series differ only in size, and smaller ones come first.
    """

    name: str
    series: str
    size: int  # impacts of one problem, about
    says: str  # description on the page
    make: Callable[[int], ZoneProblem]  # makes the problem of a number
    count: int  # number of problems  # pyright: ignore[reportIncompatibleMethodOverride]

    def problems(self) -> list[ZoneProblem]:
        """Make the problems; they are the same ones each time."""
        return [self.make(number) for number in range(self.count)]


def _seeded(
    name: str,
    series: str,
    size: int,
    says: str,
    make: Callable[..., ZoneProblem],
    *arguments: Any,
    count: int = 5,
) -> Family:
    """Return a family whose problems are drawn with a seed of name and number."""

    def made(number: int) -> ZoneProblem:
        return make(np.random.default_rng([SEED, *name.encode(), number]), *arguments)

    return Family(name, series, size, says, made, count)


def synthetic() -> list[Family]:
    """Return the families that need no files."""
    families = [
        _seeded(
            f"random-{size}",
            "random",
            size,
            "impacts between random vertices, masses over three decades",
            random_zone,
            size,
            1e3,
            True,
            count=5 if size <= 1024 else 1,
        )
        for size in (1, 4, 16, 64, 256, 1024, 4096)
    ]
    says = "a ladder of edges, each impact shares vertices with its neighbours only"
    for size in (64, 1024):
        families.append(_seeded(f"chain-{size}", "chain", size, says, chain_zone, size))
    says = "small sheets of cloth pressed onto one another and onto a pinned one"
    families.append(_seeded("stack-500", "stack", 490, says, stack_zone, 6, 9))
    families.append(_seeded("stack-4700", "stack", 4704, says, stack_zone, 13, 16, count=2))
    says = "vertices between two faces each: opposed constraints"
    for size in (64, 256):
        families.append(_seeded(f"pinch-{size}", "pinch", size, says, pinch_zone, size))
    says = (
        "half of the constraints duplicate, nearly parallel, farther along or opposed; equal masses"
    )
    for size in (64, 256):
        families.append(
            _seeded(f"redundant-{size}", "redundant", size, says, random_zone, size, 1.0)
        )
    for ratio in (1.0, 1e3, 1e6, 1e12):
        says = f"impacts between random vertices, masses over a ratio of {ratio:.0e}"
        name = f"masses-{ratio:.0e}".replace("e+0", "e").replace("e+", "e")
        families.append(_seeded(name, "masses", 64, says, random_zone, 64, ratio, True))
    return families


RECORDED = {
    "armadillo-first": "a zone of a step of a soft body between rollers, with many redundant "
    "constraints",
    "armadillo-last": "the same zone at the end of the step, nearly twice as large",
    "end-sheets-10k": "the largest zones in which the step sheets-10k ends",
    "end-crumple-10k": "the largest zones in which the step crumple-10k ends",
}


def recorded() -> list[Family]:
    """Return the families of zones that occurred in steps; none if there are no step files."""
    families = []
    for name in ("armadillo-first", "armadillo-last"):
        file = f"zone-{name}"
        if (steps.FOLDER / f"{file}.npz").is_file():
            size = len(steps.load(file)["nodes"])

            def made(_number: int, file: str = file) -> ZoneProblem:
                return steps.load_zone(file)

            families.append(Family(name, "armadillo", size, RECORDED[name], made, 1))
    for step in ("sheets-10k", "crumple-10k"):
        if (steps.FOLDER / f"{step}.npz").is_file():
            families.append(step_family(step, RECORDED[f"end-{step}"]))
    return families


def step_family(step: str, says: str) -> Family:
    """Return the family of the largest zones of the last iteration of a step.

    Args:
        step: Name of the step.
        says: Description on the page.
    """
    name, problems = f"end-{step}", step_zones(step)
    size = int(np.median([len(problem.nodes) for problem in problems]))

    def made(number: int) -> ZoneProblem:  # a call may ask for more problems than there are
        return problems[number % len(problems)]

    return Family(name, name, size, says, made, len(problems))


def descriptions() -> dict[str, str]:
    """Return `{name: description}` of all families, whether there are step files or not."""
    return {family.name: family.says for family in synthetic()} | RECORDED


@cache
def step_zones(name: str, largest: int = 3) -> tuple[ZoneProblem, ...]:
    """Resolve a step and return the largest zones of its last iteration.

    Args:
        name: Name of the step.
        largest: Number of zones.
    """
    scene = steps.load_step(name)
    result = resolve(scene, STEP_THICKNESS_M)
    order = np.argsort(-np.diff(result.zones.impact_offsets), kind="stable")[:largest]
    return tuple(
        zone_problem(scene, result.impacts, result.zones, int(zone), STEP_THICKNESS_M)
        for zone in order
    )


QUICK = ("random-1", "random-16", "random-64", "random-256", "chain-64", "pinch-64")
QUICK += ("redundant-64", "masses-1e12")


def families(quick: bool) -> list[Family]:
    """Return all families, or a few that take little time."""
    if quick:
        return [family for family in synthetic() if family.name in QUICK]
    return synthetic() + recorded()

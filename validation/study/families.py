"""The families of zone problems on which solvers are compared."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

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
    """Problems of one kind. Those of a series differ in size only, smaller ones first."""

    name: str
    series: str
    size: int  # impacts a problem, about
    says: str  # what it is
    make: Callable  # (number) -> ZoneProblem
    count: int  # problems

    def problems(self) -> list[ZoneProblem]:
        """The problems; the same ones each time."""
        return [self.make(number) for number in range(self.count)]


def _seeded(name, series, size, says, make, *arguments, count=5):
    def made(number):
        return make(np.random.default_rng([SEED, *name.encode(), number]), *arguments)

    return Family(name, series, size, says, made, count)


def synthetic() -> list[Family]:
    """Families that need no files."""
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
    says = "vertices between two faces each: opposed rows"
    for size in (64, 256):
        families.append(_seeded(f"pinch-{size}", "pinch", size, says, pinch_zone, size))
    says = "half of the rows doubled, nearly parallel, farther along or opposed; equal masses"
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
    "armadillo-first": "of a step of a soft body between rollers, many rows redundant",
    "armadillo-last": "the same at the end of the step, nearly twice as large",
    "end-sheets-10k": "the largest zones in which the step sheets-10k ends",
    "end-crumple-10k": "the largest zones in which the step crumple-10k ends",
}


def recorded() -> list[Family]:
    """Families of the step files: zones that came up in steps; none without the files."""
    families = []
    for name in ("armadillo-first", "armadillo-last"):
        file = f"zone-{name}"
        if (steps.FOLDER / f"{file}.npz").is_file():
            size = len(steps.load(file)["nodes"])

            def made(_, file=file):
                return steps.load_zone(file)

            families.append(Family(name, "armadillo", size, RECORDED[name], made, 1))
    for step in ("sheets-10k", "crumple-10k"):
        if (steps.FOLDER / f"{step}.npz").is_file():
            families.append(step_family(step, RECORDED[f"end-{step}"]))
    return families


def step_family(step, says) -> Family:
    """The family of the largest zones in which a step ends."""
    name, problems = f"end-{step}", step_zones(step)
    size = int(np.median([len(problem.nodes) for problem in problems]))

    def made(number):  # a call may ask for more than there are
        return problems[number % len(problems)]

    return Family(name, name, size, says, made, len(problems))


def descriptions() -> dict[str, str]:
    """{name: what it is}, of all families, whether there are step files or not."""
    return {family.name: family.says for family in synthetic()} | RECORDED


@cache
def step_zones(name, largest=3) -> tuple[ZoneProblem, ...]:
    """The largest zones in which a step ends, resolved here."""
    scene = steps.load_step(name)
    result = resolve(scene, STEP_THICKNESS_M)
    order = np.argsort(-np.diff(result.zones.impact_offsets), kind="stable")[:largest]
    return tuple(
        zone_problem(scene, result.impacts, result.zones, int(zone), STEP_THICKNESS_M)
        for zone in order
    )


QUICK = ("random-1", "random-16", "random-64", "random-256", "chain-64", "pinch-64")
QUICK += ("redundant-64", "masses-1e12")


def families(quick) -> list[Family]:
    """All, or a few that take little time."""
    if quick:
        return [family for family in synthetic() if family.name in QUICK]
    return synthetic() + recorded()

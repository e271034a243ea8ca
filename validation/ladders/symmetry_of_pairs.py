"""Symmetries of one pair: exchanged roles, other corners first, and time that runs backward."""

import time
from collections.abc import Iterable, Iterator
from itertools import permutations, product
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.detection.formulas.advance import APART, advance
from izo_ref.porting.files import load_cases
from validation.ladders.ladder import RIGHT, WRONG, Ladder, Outcome, Rung
from validation.oracles import path

FAMILY = "symmetry"
CORNERS = tuple((0, *corners) for corners in permutations((1, 2, 3)))
EDGES = tuple(
    (a, 1 - a, 2 + b, 3 - b) if order else (2 + b, 3 - b, a, 1 - a)
    for a, b, order in product((0, 1), (0, 1), (True, False))
)


class Written(NamedTuple):
    """One of the ways to write a pair.

    Attributes:
        is_edge_edge: Kind of the pair.
        start: (4, 3) f8 [m].
        end: (4, 3) f8 [m].
    """

    is_edge_edge: bool
    start: Floats
    end: Floats


def pairs_of(word: str) -> list[Written]:
    """Return the pairs of the vectors of stage S2 whose id has a word."""
    found = []
    for case in load_cases(stages=["S2"]):
        if case.id.split("-", 1)[1].rpartition("-")[0] == word:
            points = [np.array(case.inputs[name], float).reshape(4, 3) for name in ("start", "end")]
            found.append(Written(bool(case.inputs["is_edge_edge"]), points[0], points[1]))
    return found


def ways(pair: Written) -> Iterator[Written]:
    """Yield a pair in all orders of its nodes that leave it the same."""
    for order in EDGES if pair.is_edge_edge else CORNERS:
        yield Written(pair.is_edge_edge, pair.start[list(order)], pair.end[list(order)])


def words() -> tuple[str, ...]:
    """Return the words in the ids of the vectors of stage S2: kinds of pairs."""
    cases = load_cases(stages=["S2"])
    return tuple(dict.fromkeys(case.id.split("-", 1)[1].rpartition("-")[0] for case in cases))


def proposed_time(pair: Written) -> float | None:
    """Return the time of impact that detection finds, or None."""
    relative = [[tuple(row) for row in p[1:] - p[0]] for p in (pair.start, pair.end)]
    with np.errstate(all="ignore"):  # compiled code does not warn, either
        status, toi, *_ = advance(pair.is_edge_edge, *relative[0], *relative[1])
    return None if status == APART else float(toi)


def judge_pairs(pairs: Iterable[Written]) -> list[Outcome]:
    """Ask for each pair in every order of its nodes, forward and backward in time.

    A pair that meets must be found in every order, and never after its exact time, which rational
    arithmetic knows. A pair that does not meet may be found where rounding cannot tell.
    """
    begin = time.perf_counter()
    missed = late = cautious = asked = 0
    spread = 0.0
    for own in pairs:
        for forward in (own, Written(own.is_edge_edge, own.end, own.start)):
            exact: Any = path.first_meeting(*forward)
            times = [proposed_time(written) for written in ways(forward)]
            asked += len(times)
            found = [t for t in times if t is not None]
            if exact is None:
                cautious += len(found)
                continue
            missed += len(times) - len(found)
            late += sum(t > exact[1] for t in found)
            spread = max(spread, max(found, default=0.0) - min(found, default=0.0))
    verdict = WRONG if missed or late else RIGHT
    note = (
        f"{asked} questions; {missed} missed, {late} late, {cautious} found although they stay "
        "apart by less than rounding can tell; the error is the largest difference of the times "
        "that are found for one pair, which may be early"
    )
    seconds = (time.perf_counter() - begin) / max(asked, 1)
    return [Outcome(verdict, "found", error=spread, seconds=seconds, note=note)]


def _run(rung: Rung) -> list[Outcome]:
    return judge_pairs(pairs_of(str(rung)))


LADDERS: list[Ladder] = [
    Ladder(
        FAMILY,
        "roles in a pair",
        "The pairs of the vectors of stage S2 with their nodes in every order that leaves the pair "
        "the same, and with time running backward. A pair that meets is found in every order, and "
        "never after its time, which rational arithmetic knows.",
        "kind",
        words(),
        _run,
        (),
        60.0,
        words()[-1],
    )
]

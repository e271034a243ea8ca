"""The rows of the ladders, put in order for the page and for the table of limits."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from validation.ladders.ladder import NO_ANSWER, OWN, RIGHT, WRONG, Border, Ladder, Outcome, border
from validation.ladders.rungs import ladders, rung_text
from validation.rows import Row, read
from validation.study.stability import FAMILIES

TITLES = {
    "stiff": "Stiff zones: masses, penalties, dependent constraints",
    "scale": "Scale and place: coordinates, distance from the origin, thickness",
    "geometry": "Geometry of the mesh",
    "motion": "Motion",
    "contact": "Contact: stacks, pinches, large zones",
    "precision": "Precision: what rounding does to the answer",
    "symmetry": "Symmetries: what must not change the answer",
}
FIELDS = Outcome._fields


class Measured(NamedTuple):
    """A ladder and what was measured on it.

    Attributes:
        ladder: The ladder.
        own: Our outcome of each rung that was measured, in the order of the ladder.
        others: `{solver: outcomes}` of other solvers, in the same order.
        runs: Ids of the runs that measured the rows.
        missing: Number of rungs that were not measured.
    """

    ladder: Ladder
    own: list[tuple[str, Outcome]]
    others: dict[str, list[tuple[str, Outcome]]]
    runs: set[int]
    missing: int

    @property
    def border(self) -> Border:
        """The border of our own outcomes."""
        return border(self.own)

    @property
    def named(self) -> bool:
        """Whether the rungs are names of kinds instead of numbers."""
        return isinstance(self.ladder.rungs[0], str)

    def count(self, verdict: str) -> int:
        """Return how many of our own outcomes have a verdict."""
        return sum(outcome.verdict == verdict for _, outcome in self.own)

    def worst(self, value: Callable[[Outcome], float | None], all_of: bool = False) -> float | None:
        """Return the largest value of our right outcomes, or of all; None if there is none."""
        found = [value(outcome) for _, outcome in self.own if all_of or outcome.verdict == RIGHT]
        return max((v for v in found if v is not None), default=None)


def measured(rows_folder: Path, family: str) -> list[Measured]:
    """Return the ladders of a family with what was measured; rows of other rungs are left out."""
    by_ladder: dict[str, list[Row]] = {}
    for row in read(rows_folder, family):
        by_ladder.setdefault(row["ladder"], []).append(row)
    return [measured_ladder(ladder, by_ladder.get(ladder.name, [])) for ladder in ladders(family)]


def all_measured(rows_folder: Path) -> dict[str, list[Measured]]:
    """Return the ladders of each family that was measured."""
    return {
        family: measured(rows_folder, family)
        for family in FAMILIES
        if (rows_folder / f"{family}.csv").is_file()
    }


def measured_ladder(ladder: Ladder, rows: Iterable[Row]) -> Measured:
    """Return a ladder with its rows; rows of other rungs are left out."""
    found = {(str(row["rung"]), row["by"]): row for row in rows}
    by: dict[str, list[tuple[str, Outcome]]] = {OWN: []}
    rungs = [rung_text(rung) for rung in ladder.rungs]
    runs = set()
    for solver in dict.fromkeys(solver for _, solver in found):
        for rung in rungs:
            row = found.get((rung, solver))
            if row is not None:
                by.setdefault(solver, []).append((rung, _outcome(row)))
                runs.add(row["run"])
    own = by.pop(OWN)
    return Measured(ladder, own, by, runs, len(rungs) - len(own))


def _outcome(row: Row) -> Outcome:
    values: Row = {name: row.get(name) for name in FIELDS}
    for name in ("verdict", "status", "by", "note"):
        values[name] = str(values[name] or "")
    return Outcome(**values)


def silent(found: dict[str, list[Measured]]) -> int:
    """Return how many cells are wrong without saying so."""
    return sum(m.count(WRONG) for part in found.values() for m in part)


def cells(found: dict[str, list[Measured]]) -> int:
    """Return how many cells were measured."""
    return sum(len(m.own) for part in found.values() for m in part)


def without_answer(found: dict[str, list[Measured]]) -> int:
    """Return how many cells had no answer within the limits."""
    return sum(m.count(NO_ANSWER) for part in found.values() for m in part)

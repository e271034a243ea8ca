"""The table of borders that were moved in the core, from the rows of both cores."""

from pathlib import Path
from typing import NamedTuple

from validation.ladders.ladder import NO_ANSWER, OWN, RIGHT, Outcome, border
from validation.report.stability_rows import Measured, all_measured, measured_ladder
from validation.report.tables import NOT_MEASURED, cell_text, table
from validation.rows import Columns, Row, read

HEADING = "## Borders that were moved"
INTRO = (
    "The same rungs on the core as it was at commit {}, with the ladders and judges of today, show "
    "what later changes of the core moved. Each line has the first rung that is right on one core "
    "only, and what both said there. A rung without an answer within the limits of time and memory "
    "decides nothing, since other work of the machine uses both."
)
UNKNOWN = "no change of the core is known to have moved it"
# What moved a border: the first words of ladders, and the change of the core with its commit.
_POLISHED = "The answer of the interior point is moved onto its active constraints (79c9a17)."
_KEEPS_A_PART = "What has too little room for the thickness keeps a part of it (5fd81d9)."
MOVED_BY = {
    "masses, large chain": _POLISHED,
    "masses, large pinch": _POLISHED,
    "masses, large stack": _POLISHED,
    "slab, heavy faces": "An answer may be farther where mass ratios are large (79c9a17).",
    "angle, interior-point": "A start that is the answer to rounding is taken (79c9a17).",
    "pinched layer": _KEEPS_A_PART,
    "cage": _KEEPS_A_PART,
}
LINES: Columns = {
    "ladder": "ladder",
    "rung": "unit",
    "right up to, before": "last_before",
    "right up to, now": "last_now",
    "at": "at",
    "before": "before",
    "now": "now",
    "more rungs that are right": "more",
    "what moved it": "by",
}


class Pair(NamedTuple):
    """A ladder that was measured on both cores.

    Attributes:
        measured: The ladder, with our outcomes on the core of today.
        before: Our outcome of each rung on the core as it was, in the order of the ladder.
    """

    measured: Measured
    before: list[tuple[str, Outcome]]

    @property
    def differing(self) -> str | None:
        """The first rung that is right on one core only, up to where both end; None without one."""
        now = dict(self.measured.own)
        for rung, outcome in self.before:
            verdicts = outcome.verdict, now[rung].verdict
            if NO_ANSWER in verdicts:
                continue
            if verdicts.count(RIGHT) == 1:
                return rung
            if not self.measured.named and RIGHT not in verdicts:
                return None
        return None


def section(rows_folder: Path) -> str:
    """Return the section of moved borders; Markdown.

    Args:
        rows_folder: Folder of the CSV files; `before.csv` has the rows of the core as it was.
    """
    rows = read(rows_folder, "before")
    pairs, n_missing = _pairs(rows_folder, rows)
    if not pairs:
        return f"{HEADING}\n\n{NOT_MEASURED}"
    moved = [pair for pair in pairs if pair.differing is not None]
    commits = dict.fromkeys(str(row["by"]).removeprefix(f"{OWN} ") for row in rows)
    said = [
        INTRO.format(", ".join(commits)),
        f"{len(pairs)} ladders were measured on both cores, and the border of "
        f"{len(pairs) - len(moved)} is where it was.",
    ]
    if n_missing:
        said.append(f"Ladders without all rungs of both cores: {n_missing}.")
    return f"{HEADING}\n\n{' '.join(said)}\n\n{table(LINES, [_line(pair) for pair in moved])}"


def _pairs(rows_folder: Path, rows: list[Row]) -> tuple[list[Pair], int]:
    """Return the ladders that both cores have every rung of, and the number of the others."""
    by_ladder: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        by_ladder.setdefault((row["family"], row["ladder"]), []).append({**row, "by": OWN})
    pairs, n_missing = [], 0
    for family, ladders in all_measured(rows_folder).items():
        for now in ladders:
            found = by_ladder.get((family, now.ladder.name))
            if found is None:
                continue
            before = measured_ladder(now.ladder, found)
            if now.missing or before.missing:
                n_missing += 1
            else:
                pairs.append(Pair(now, before.own))
    return pairs, n_missing


def _line(pair: Pair) -> Row:
    now, at = pair.measured, pair.differing
    assert at is not None
    before = Measured(now.ladder, pair.before, {}, set(), 0)
    return {
        "ladder": now.ladder.name,
        "unit": now.ladder.unit,
        "last_before": _last(before),
        "last_now": _last(now),
        "at": at,
        "before": _said(dict(pair.before)[at]),
        "now": _said(dict(now.own)[at]),
        "more": now.count(RIGHT) - before.count(RIGHT),
        "by": next(
            (by for name, by in MOVED_BY.items() if now.ladder.name.startswith(name)), UNKNOWN
        ),
    }


def _last(m: Measured) -> str:
    if m.named:
        return f"{m.count(RIGHT)} of {len(m.own)} kinds"
    last = border(m.own).last
    return "no rung" if last is None else str(last)


def _said(outcome: Outcome) -> str:
    error = "" if outcome.error is None else f", error {cell_text(outcome.error)}"
    return f"{outcome.status}{error}"

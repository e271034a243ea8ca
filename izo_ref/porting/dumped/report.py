"""What is said about a dump: one finding for each stage that was judged."""

from __future__ import annotations

from typing import Any, NamedTuple

from izo_ref.porting.reading import shown_lines, shown_page
from izo_ref.porting.stages import STAGE, Stage


class Problem(NamedTuple):
    """The first place in which a stage differs.

    Attributes:
        sentence: What is wrong.
        row: Row of the array, or None if this is not about a row.
        vertices: The vertices that it is about.
        expected: What the reference has there.
        got: What the dump has there.
        n_wrong: How many rows differ, with this one.
    """

    sentence: str
    row: int | None = None
    vertices: tuple[int, ...] = ()
    expected: str = ""
    got: str = ""
    n_wrong: int = 1


class Finding(NamedTuple):
    """What was found about one stage at one place of a dump.

    Attributes:
        stage: Name of the stage.
        place: The array, such as `iteration-0001/found/toi`.
        given: The input from which the reference started.
        judged: How many rows, zones or vertices were judged.
        problem: The first difference, or None.
        note: What was not judged, and why; empty if everything was.
    """

    stage: str
    place: str
    given: str
    judged: int
    problem: Problem | None = None
    note: str = ""


class DumpReport(NamedTuple):
    """The report of a dump.

    Attributes:
        dtype: `f8` or `f4`: the floats whose tolerances were taken.
        findings: One for each stage that was judged, in the order of the run.
        notes: What else there is to say, such as arrays that no stage takes.
    """

    dtype: str
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]

    @property
    def first(self) -> Finding | None:
        """The first finding with a difference, or None."""
        return next((finding for finding in self.findings if finding.problem), None)

    @property
    def agrees(self) -> bool:
        """Whether something was judged and nothing differs."""
        return bool(self.findings) and self.first is None

    def text(self) -> str:
        """Return the report for a terminal."""
        lines = [f"floats of the dump: {'float64' if self.dtype == 'f8' else 'float32'}", ""]
        lines += _table(self.findings)
        lines += [f"note: {note}" for note in self.notes]
        if self.first is not None:
            lines += ["", *_difference(self.first)]
        lines += ["", self.verdict()]
        return "\n".join(lines) + "\n"

    def verdict(self) -> str:
        """Return one sentence that says whether the dump agrees with the reference."""
        if not self.findings:
            return "The dump has a scene and nothing else, so nothing was judged."
        wrong = [finding for finding in self.findings if finding.problem]
        if not wrong:
            return f"All {len(self.findings)} arrays that were judged agree with the reference."
        return (
            f"{len(wrong)} of {len(self.findings)} arrays differ. Each was judged on what the port "
            "itself made before it, so the first difference does not cause the others."
        )

    def record(self) -> dict[str, Any]:
        """Return the report as JSON holds it."""
        first = self.first
        return {
            "dtype": self.dtype,
            "agrees": self.agrees,
            "verdict": self.verdict(),
            "first": None if first is None else _record(first) | _read(STAGE[first.stage]),
            "findings": [_record(finding) for finding in self.findings],
            "notes": list(self.notes),
        }


def _read(stage: Stage) -> dict[str, str]:
    return {
        "formula": stage.formula,
        "reference": shown_lines(stage),
        "method": shown_page(stage),
    }


def _record(finding: Finding) -> dict[str, Any]:
    problem = finding.problem
    return finding._asdict() | {"problem": None if problem is None else problem._asdict()}


def _table(findings: tuple[Finding, ...]) -> list[str]:
    """Return a line for each finding, in columns."""
    rows = [("array", "stage", "", "rows", "judged on")]
    for finding in findings:
        verdict = "DIFFERS" if finding.problem else "agrees"
        stage = f"{finding.stage} {STAGE[finding.stage].title}"
        rows.append((finding.place, stage, verdict, str(finding.judged), finding.given))
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    lines = []
    for row, finding in zip(rows, (None, *findings), strict=True):
        cells = [row[0].ljust(widths[0]), row[1].ljust(widths[1]), row[2].ljust(widths[2])]
        lines.append("  ".join([*cells, row[3].rjust(widths[3]), row[4]]).rstrip())
        if finding is not None and finding.note:
            lines.append(f"    {finding.note}")
    return lines


def _difference(finding: Finding) -> list[str]:
    """Return the lines about the first difference."""
    problem, stage = finding.problem, STAGE[finding.stage]
    assert problem is not None
    rows = [
        ("where", finding.place + ("" if problem.row is None else f", row {problem.row}")),
        ("vertices", " ".join(map(str, problem.vertices))),
        ("wrong", problem.sentence),
        ("expected", problem.expected),
        ("got", problem.got),
        ("judged on", finding.given),
        ("formula", stage.formula),
        ("read", f"{shown_lines(stage)}, {shown_page(stage)}"),
    ]
    lines = [f"First difference: {stage.name} {stage.title}"]
    lines += [f"  {name:<9}  {text}" for name, text in rows if text]
    if problem.n_wrong > 1:
        lines.append(f"  {problem.n_wrong - 1} more rows of this array may differ")
    return lines

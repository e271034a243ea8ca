"""The page of stability, from the rows of `study/stability.py`: maps, borders, every cell."""

from pathlib import Path

from izo_ref.app.files import replacing
from validation.ladders.ladder import RIGHT, SAYS_SO, VERDICTS, WRONG
from validation.report import stability_before, stability_parts
from validation.report.catalogue import Headline
from validation.report.stability_map import map_svg
from validation.report.stability_rows import (
    TITLES,
    Measured,
    all_measured,
    cells,
    silent,
    without_answer,
)
from validation.report.tables import NOT_MEASURED, cell_text, run_table, section, table, write_page
from validation.rows import Columns, Row, read, runs_of
from validation.study.stability import FAMILIES

INTRO = (
    "How far the method holds, where it ends, and what the program says beyond. Each ladder goes "
    "from mild to absurd, and the answer of each rung is known without our solver: from a formula, "
    "from exact arithmetic, or from a symmetry. A rung is **right** if the answer agrees with what "
    "is known. It is **not reached, and the program says so**, if the status or an error says that "
    "the answer is not what was asked for. It is **another answer** if it is certified free, as "
    "the status says, but is not what the same step in another form, or beside another one, gives; "
    "no page promises that. A path that the program calls free is checked anew by "
    "exact arithmetic. Measured by `python -m validation study stability`."
)
BORDERS: Columns = {
    "ladder": "ladder",
    "rung": "unit",
    "right up to": "last",
    "first beyond": "beyond",
    "what it says there": "said",
    "wanted": "wanted",
    "largest error where right": "error",
    "largest condition number": "condition",
    "longest [s]": "seconds",
}
CELLS: Columns = {
    "ladder": "ladder",
    "rung": "rung",
    "by": "by",
    "verdict": "verdict",
    "status": "status",
    "error": "error",
    "violation / thickness": "violation",
    "iterations": "iterations",
    "time [s]": "seconds",
    "condition number": "condition",
    "note": "note",
}
BOUNDS: Columns = {
    "bound": "bound",
    "derived in": "file",
    "largest error found / bound": "ratio",
    "inputs tried": "tried",
    "what it covers": "sentence",
}
BOUNDS_INTRO = (
    "A search that climbs from random inputs looks for the largest error of each derived bound, "
    "with exact arithmetic as the judge. Above 1 would refute the bound. Below 0.01, the bound "
    "would be wider than it has to be, or the search too weak."
)
OTHERS: Columns = {
    "solver": "solver",
    "ladder": "ladder",
    **{verdict: verdict for verdict in VERDICTS},
    "largest error that it calls a success": "error",
}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `README.md`, a map for each family, and a page with every cell of each family.

    Args:
        rows_folder: Folder of the CSV files, one for each family.
        output: Folder of the pages.

    Returns:
        Path of `README.md`.
    """
    found = all_measured(rows_folder)
    rows = [{"run": run} for part in found.values() for m in part for run in m.runs]
    rows += [*read(rows_folder, "bounds"), *read(rows_folder, "before")]
    rows += stability_parts.other_rows(rows_folder)
    sections = ["# Stability: how far the method holds", INTRO, _summary(found)]
    sections.append(run_table(runs_of(rows_folder, rows)))
    for family in FAMILIES:
        sections += [f"## {TITLES[family]}", *_family(family, found.get(family, []), output)]
    sections.append(stability_before.section(rows_folder))
    sections += ["## Other solvers on the same rungs", _others(found)]
    sections += stability_parts.sections(rows_folder)
    bounds = read(rows_folder, "bounds")
    sections.append(section("Derived bounds of rounding", BOUNDS_INTRO, BOUNDS, bounds))
    return write_page(output / "README.md", sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    found = all_measured(rows_folder)
    if not cells(found):
        return []
    right = sum(m.count(RIGHT) for part in found.values() for m in part)
    says = sum(m.count(SAYS_SO) for part in found.values() for m in part)
    steps = stability_parts.random_steps_total(rows_folder)
    return [
        Headline(
            "Stiff and extreme cases that are wrong without saying so",
            f"{silent(found)} of {cells(found):,}",
            f"{right:,} are right, {says:,} say that they are not, and {without_answer(found)} "
            "had no answer within the limits of time and memory.",
        ),
        Headline(
            "False claims on small random steps full of trouble",
            f"{steps['violations']} of {steps['steps']:,}",
            f"{steps['by_oracle']:,} of them were also judged pair by pair by a second exact "
            f"oracle; {steps['crashed']} ended the process, {steps['slow']} were too slow.",
        ),
    ]


def _summary(found: dict[str, list[Measured]]) -> str:
    if not cells(found):
        return NOT_MEASURED
    lines = [
        {"family": TITLES[family], "ladders": len(part)}
        | {verdict: sum(m.count(verdict) for m in part) for verdict in VERDICTS}
        for family, part in found.items()
    ]
    columns: Columns = {"family": "family", "ladders": "ladders"}
    return table(columns | {verdict: verdict for verdict in VERDICTS}, lines)


def _family(family: str, found: list[Measured], output: Path) -> list[str]:
    """Write the map and the cells of a family; return its sections of the page."""
    found = [m for m in found if m.own]
    if not found:
        return [NOT_MEASURED]
    title = TITLES[family]
    with replacing(_made(output / f"{family}.svg")) as file:
        file.write(map_svg(f"Map: {title}", found).encode())
    sentences = [f"* **{m.ladder.name}**: {m.ladder.sentence}" for m in found]
    _write_cells(family, found, output)
    missing = sum(m.missing for m in found)
    return [
        f"![Map: {title}]({family}.svg)",
        table(BORDERS, [_border_line(m) for m in found]),
        f"{missing} rungs were not measured yet." if missing else "",
        "\n".join(sentences),
        f"The command also writes every cell with its status, error, violation, iterations, time "
        f"and condition number into `{family}.md`.",
    ]


def _made(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _border_line(m: Measured) -> Row:
    border = m.border
    last, beyond = border.last, border.beyond
    if m.named:
        wrong = [rung for rung, outcome in m.own if outcome.verdict != RIGHT]
        last, beyond = f"{m.count(RIGHT)} of {len(m.own)} kinds", ", ".join(wrong)
    wanted = m.ladder.wanted
    return {
        "ladder": m.ladder.name,
        "unit": m.ladder.unit,
        "last": last,
        "beyond": beyond,
        "said": ", ".join(border.said),
        "wanted": None
        if wanted is None
        else f"{cell_text(wanted)} {'met' if _met(m) else 'MISSED'}",
        "error": m.worst(lambda o: o.error),
        "condition": m.worst(lambda o: o.condition, all_of=True),
        "seconds": m.worst(lambda o: o.seconds, all_of=True),
    }


def _met(m: Measured) -> bool:
    """Return whether every rung up to the wanted one is right."""
    rungs = list(m.ladder.rungs)
    up_to = rungs.index(m.ladder.wanted) + 1 if m.ladder.wanted in rungs else len(rungs)
    return all(outcome.verdict == RIGHT for _, outcome in m.own[:up_to])


def _write_cells(family: str, found: list[Measured], output: Path) -> None:
    lines = []
    for m in found:
        for by, outcomes in ({"izo_ref": m.own} | m.others).items():
            lines += [
                {"ladder": m.ladder.name, "rung": rung, **outcome._asdict(), "by": by}
                for rung, outcome in outcomes
            ]
    sections = (f"# {TITLES[family]}: every cell", table(CELLS, lines))
    write_page(output / f"{family}.md", sections)


def _others(found: dict[str, list[Measured]]) -> str:
    lines = []
    for m in (m for part in found.values() for m in part):
        for solver, outcomes in m.others.items():
            answers = [outcome for _, outcome in outcomes]
            wrong = [o.error for o in answers if o.verdict == WRONG and o.error is not None]
            counts = {v: sum(o.verdict == v for o in answers) for v in VERDICTS}
            lines.append(
                {
                    "solver": solver,
                    "ladder": m.ladder.name,
                    "error": max(wrong, default=None),
                    **counts,
                }
            )
    return table(OTHERS, lines) if lines else NOT_MEASURED

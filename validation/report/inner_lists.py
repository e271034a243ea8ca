"""The sections of the page of zones that list rows: variants, families, threads."""

from collections.abc import Callable

from validation.report import site
from validation.report.measured import ERROR, SMALL_ERROR, Family, Measured, duration, label
from validation.report.tables import scientific
from validation.rows import Columns, Row
from validation.study.cells import BATCH
from validation.study.families import descriptions

MS = 1e3  # milliseconds in a second


def ms(key: str) -> Callable[[Row], float | None]:
    """Return a function that gives the seconds in a column as milliseconds."""
    return lambda row: None if row[key] is None else row[key] * MS


def variants(measured: Measured) -> str:
    """Return a table of the rows with other updates, presets or single precision."""
    rows = [
        row
        for row in measured.rows
        if row["kind"] != "library"
        and (
            row["update"] == "inner-solve"
            or row["precision"] == "float32"
            or row["solver"].startswith("preset")
        )
    ]
    columns = _columns() | {"family": "family"}
    return site.data_table(columns, rows) if rows else site.NOT_MEASURED


def _columns() -> Columns:
    return {
        "solver": label,
        "asked": "tolerance",
        "outcome": "outcome",
        "reached": "reached",
        "zone [ms]": ms("seconds"),
        "gap": "gap",
        "violation": "violation",
        "distance": "error",
        "solved": lambda row: f"{row['solved']} of {row['problems']}" if row["problems"] else "",
        "steps": "steps",
        "message": "message",
    }


def all_families(measured: Measured) -> str:
    """Return a folded table for each family, and the fastest times to small errors."""
    says = descriptions()
    columns = _columns() | {
        "zones a call": lambda row: BATCH if row["mode"] == "batch" else 1,
        "threads": "threads",
    }
    parts = []
    for family in measured.families:
        rows = [row for row in measured.of(family) if row["kind"] != "lagrangian"]
        summary = f"{family}: {family.size} impacts; {says.get(family, '')}"
        body = site.data_table(columns, rows) + site.paragraph(_fastest(measured, family))
        parts.append(site.folded(summary, body))
    return "\n".join(parts)


def _fastest(measured: Measured, family: Family) -> str:
    sentences = []
    for tolerance in (ERROR, SMALL_ERROR):
        default = measured.own(family, tolerance, solver="auto")
        library = measured.library(family, tolerance)
        took = duration(default["seconds"]) if default else "not reached"
        others = "none"
        if library:
            others = f"{library['solver']}, {duration(library['seconds'])}"
        sentences.append(f"To {scientific(tolerance)}: default {took}, fastest library {others}.")
    return " ".join(sentences)


def threads_and_compiling(measured: Measured) -> str:
    """Return a table of the gain by two threads, and one of the times to compile."""
    rows = []
    for family in measured.families:
        one = measured.own(family, ERROR, solver="auto")
        two = measured.own(family, ERROR, solver="auto", threads=2)
        if one and two:
            rows.append({"family": str(family), "one": one["seconds"], "two": two["seconds"]})
    columns: Columns = {
        "family": "family",
        "one thread [ms]": ms("one"),
        "two threads [ms]": ms("two"),
        "times as fast": lambda row: row["one"] / row["two"],
    }
    body = site.data_table(columns, rows, "The default, time of a zone") if rows else ""
    first = {label(row): row for row in reversed(measured.rows) if row["compile_s"] is not None}
    compiling = sorted(
        ({"solver": name, "compile_s": row["compile_s"]} for name, row in first.items()),
        key=lambda row: -row["compile_s"],
    )
    return body + site.data_table(
        {"solver": "solver", "first call less a later one [s]": "compile_s"},
        compiling,
        "Time to compile, or to load what was compiled before; no other time of this page has it",
    )

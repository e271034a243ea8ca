"""The page of zones: error against run time of our solvers and of libraries, with every cell."""

from collections.abc import Callable
from pathlib import Path

from validation.report import site
from validation.report.catalogue import Headline
from validation.report.cells_table import cells_table, counts
from validation.report.inner_lists import MS, all_families, ms, threads_and_compiling, variants
from validation.report.inner_plots import MEASURES, Contestants, work_precision
from validation.report.measured import (
    ERROR,
    Measured,
    default_rows,
)
from validation.report.tables import scientific
from validation.rows import Columns, Row, runs
from validation.study.cells import BATCH, BATCH_IMPACTS, LARGE_IMPACTS
from validation.study.contestants import DENSE_IMPACTS, PIQP_DENSE_IMPACTS, SLSQP_IMPACTS
from validation.study.families import descriptions
from validation.study.own import DIRECTIONS
from validation.study.truth import PROVED_IMPACTS

LINES = {
    "library": "Dark lines are our solvers; grey lines with open markers are libraries.",
    "lagrangian": "Each direction is shown with the line search that came closest.",
}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `inner.html`.

    Args:
        rows_folder: Folder of `inner.csv`.
        output: Folder of the pages.

    Returns:
        Path of the page.
    """
    measured = Measured(rows_folder)
    path = output / "inner.html"
    sections = [("Rows", site.NOT_MEASURED)]
    if measured.rows:
        compared = default_rows(measured)
        sections = [
            ("The default against the fastest library", _against_libraries(compared)),
            ("Error against time: dual methods and libraries", _plots(measured, "library")),
            ("The default against every fixed method", _against_fixed(measured, compared)),
            ("Every direction and line search in every family", _cells(measured)),
            ("Error against time: augmented Lagrangian", _plots(measured, "lagrangian")),
            ("Updates, penalties, presets, single precision", variants(measured)),
            ("Families, and the times of each", all_families(measured)),
            ("Threads and compile time", threads_and_compiling(measured)),
        ]
    site.write_page(
        path,
        "Zones: error against run time",
        "How long each solver takes to reach an error, on zones of each kind. An error counts as "
        "reached if the residuals, which are computed outside of the solver, confirm it for all "
        "problems of a family.",
        sections,
        _limits(measured),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this page; an empty list if it was not measured."""
    measured = Measured(rows_folder)
    if not measured.rows:
        return []
    rows = [row for row in default_rows(measured) if row["target"] and row["ratio"]]
    found = []
    if rows:
        met, met_many = sum(row["met"] for row in rows), sum(row["met_many"] for row in rows)
        faster = [1 / row["ratio_many"] for row in rows]
        ratios = ", ".join(
            f"{row['impacts']}: {gain:.2g}" for row, gain in zip(rows, faster, strict=True)
        )
        found.append(
            Headline(
                "The default against the fastest library",
                f"{min(faster):.2g} to {max(faster):.2g} times as fast",
                f"At a gap of {scientific(ERROR)}; by impacts of a zone ({ratios}); with "
                f"{max(row['threads'] for row in rows)} threads where zones are many or large; "
                f"libraries solve one zone a call on one thread. {met_many} of {len(rows)} targets "
                f"are met, {met} on one thread.",
            )
        )
    count = counts(measured)
    least = min(count.asked, default=1e-6)
    found.append(
        Headline(
            f"Combinations of direction, line search and family that reach {scientific(least)}",
            f"{count.reached.get(least, 0)} of {count.cells}",
            "This is the smallest error asked for, and the steps are bounded. "
            f"{count.missing} combinations are missing, {count.failed} failed.",
        )
    )
    return found


def _yes(key: str) -> Callable[[Row], str]:
    return lambda row: {None: "", True: "yes", False: "no"}[row[key]]


def _against_libraries(compared: list[Row]) -> str:
    known = [row for row in compared if row["met"] is not None]
    columns: Columns = {
        "family": "family",
        "impacts": "impacts",
        "default [ms]": ms("default"),
        "library": "library",
        "its time [ms]": ms("library_s"),
        "ratio": "ratio",
        "target": "target",
        "met": _yes("met"),
        "threads": "threads",
        "ratio on these": "ratio_many",
        "met on these": _yes("met_many"),
        "ratio to 1e-12": "ratio_12",
        "met to 1e-12": _yes("met_12"),
        "one zone a call [ms]": ms("alone"),
        "ratio of one zone a call": "ratio_alone",
    }
    intro = (
        "Times are medians for one zone, on one thread unless a number of threads is given. A step "
        f"solves zones of at most {BATCH_IMPACTS} impacts many at a time, so the default is timed "
        f"on {BATCH} zones in a call, and also on one zone. A library solves one zone a call; it "
        "is called directly, and its matrices are made before. The ratio is the default's time to "
        "1e-9, or to 1e-12, over the time of the fastest library that reached 1e-9 with any of its "
        "settings (PIQP where the target names it). "
    )
    if known:
        met, many = sum(row["met"] for row in known), sum(row["met_many"] for row in known)
        intro += f"{met} of {len(known)} targets are met on one thread, {many} on all threads."
    return site.paragraph(intro) + site.data_table(columns, compared)


def _plots(measured: Measured, contestants: Contestants) -> str:
    parts = []
    for measure, says in MEASURES.items():
        caption = (
            f"{says[0].upper()}{says[1:]}, the largest of a family's problems, against the median "
            "time of a zone on one thread. Each point is a tolerance that was asked for. "
            f"{LINES[contestants]}"
        )
        svg = work_precision(measured, measure, contestants)
        figure = site.figure(svg, caption, site.run_ids(measured.rows))
        parts.append(figure if not parts else site.folded(f"The same with the {says}", figure))
    return "\n".join(parts)


def _against_fixed(measured: Measured, compared: list[Row]) -> str:
    columns: Columns = {
        "family": "family",
        "default [ms]": ms("default"),
        "fastest fixed method": "fixed",
        "its time [ms]": ms("fixed_s"),
        "default over it": "against_fixed",
        "fastest library [ms]": ms("library_s"),
        "within 20 % of the fastest": _yes("among_fastest"),
    }
    known = [row for row in compared if row["among_fastest"] is not None]
    held = sum(row["among_fastest"] for row in known)
    intro = (
        "Times to a gap and a violation of 1e-9 on one thread. In "
        f"{held} of {len(known)} families the default is within 20 % of the fastest of all fixed "
        "methods and libraries."
    )
    return (
        site.paragraph(intro)
        + site.data_table(columns, compared)
        + site.folded(
            "Every fixed method; a cell is empty where 1e-9 was not reached. Directions are shown "
            "with the fastest of their line searches, one zone a call.",
            _every_method(measured),
        )
    )


def _every_method(measured: Measured) -> str:
    fixed = {family: measured.fixed(family, ERROR) for family in measured.families}
    lines = [
        {"family": str(family), "auto": measured.own(family, ERROR, solver="auto"), **found}
        for family, found in fixed.items()
    ]
    columns: Columns = {"family": "family"}
    for name in ("auto", *next(iter(fixed.values()))):
        columns[f"{name} [ms]"] = lambda row, name=name: row[name] and row[name]["seconds"] * MS
    return site.data_table(columns, lines)


def _cells(measured: Measured) -> str:
    count = counts(measured)
    asked = ", ".join(map(scientific, count.asked))
    intro = (
        f"There are {count.cells} cells; {count.missing} are missing and {count.failed} failed. A "
        "cell shows the smallest tolerance that gap and violation reached within the steps "
        "allowed, and the time of a zone; darker means more accurate. "
        f"{count.reached[1e-3]} cells reach 1e-3, {count.reached[1e-6]} reach 1e-6 and "
        f"{count.reached[1e-9]} reach 1e-9. The tolerances asked for were {asked}. Multipliers are "
        "updated every step, mu is fixed, and the precision is float64."
    )
    return site.paragraph(intro) + cells_table(measured)


def _limits(measured: Measured) -> list[str]:
    present = {str(family) for family in measured.families}
    absent = [name for name in descriptions() if name not in present]
    out = sum((row["message"] or "").startswith("left out") for row in measured.rows)
    limits = [
        f"{out} of {len(measured.rows)} rows were left out, and say why: the solver took too long "
        "at a smaller size, or did not reach a looser tolerance within its steps.",
        "For methods that count their steps, steps times impacts is bounded, so few steps are "
        "allowed on large zones. Their cells say not converged; more steps might converge.",
        f"Libraries with dense matrices get zones of at most {DENSE_IMPACTS} impacts, PIQP's dense "
        f"solver {PIQP_DENSE_IMPACTS}, SLSQP {SLSQP_IMPACTS}.",
        "quadprog and NNLS have no tolerance, so each has one point. The tolerance of a library "
        "applies to its own residuals in scaled variables; this page judges by our residuals.",
        "Up to 64 impacts the distance is that to the exact optimum. Above, it is an upper bound: "
        "the distance to our answer at 1e-12, plus the proved error of that answer. Where "
        "constraints are redundant, that proof is good to some 1e-7. Above "
        f"{PROVED_IMPACTS} impacts, the error is not proved: it is what the duality gap says.",
        "A library's time is that of one zone a call from Python; from C it would be less on "
        "zones of a few impacts.",
        "Times are medians of five calls or more if these fit into the budget of a cell; a call "
        "that takes seconds is made once.",
        "The number of threads is Numba's; threads that libraries and BLAS start by themselves are "
        "not limited.",
        f"Two threads are timed on many small zones, and on zones of {LARGE_IMPACTS} impacts or "
        f"more. {', '.join(DIRECTIONS)} are timed with one zone a call on one thread.",
        "Random zones couple vertices at random, so their factors fill in more than those of "
        "meshes.",
    ]
    if absent:
        limits.append(f"Not measured in this run: {', '.join(absent)}.")
    return limits

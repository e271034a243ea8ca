"""The page of zones: error against time, ours and libraries, every cell."""

from pathlib import Path

from validation.report import site
from validation.report.cells_table import cells_table, counts
from validation.report.inner_plots import MEASURES, work_precision
from validation.report.measured import Measured, default_rows, duration, label
from validation.rows import runs
from validation.study.cells import BATCH, BATCH_IMPACTS, LARGE_IMPACTS
from validation.study.contestants import DENSE_IMPACTS, PIQP_DENSE_IMPACTS, SLSQP_IMPACTS
from validation.study.families import descriptions
from validation.study.own import DIRECTIONS
from validation.study.truth import PROVED_IMPACTS

MS = 1e3  # milliseconds in a second


def page(rows_folder, output) -> Path:
    """Write the page; returns where it is.

    Args:
        rows_folder: where `inner.csv` is.
        output: folder of the pages.
    """
    measured = Measured(rows_folder)
    path = Path(output) / "inner.html"
    sections = [("Not measured", site.NOT_MEASURED)]
    if measured.rows:
        compared = default_rows(measured)
        sections = [
            ("The default against the fastest library", _against_libraries(compared)),
            ("Error against time: dual methods and libraries", _plots(measured, "library")),
            ("The default against every fixed choice", _against_fixed(measured, compared)),
            ("Every direction and line search in every family", _cells(measured)),
            ("Error against time: augmented Lagrangian", _plots(measured, "lagrangian")),
            ("Updates, penalties, presets, single precision", _variants(measured)),
            ("Families, and the times of each", _families(measured)),
            ("Threads, and compiling", _threads(measured)),
        ]
    site.write_page(
        path,
        "Zones: error against time",
        "How long each solver takes to an error, on zones of each kind. An error counts as "
        "reached when residuals computed outside the solver say so, for all problems of a family.",
        sections,
        _limits(measured),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder) -> list[tuple[str, str, str]]:
    """(label, figure, sentence) for the start page."""
    measured = Measured(rows_folder)
    if not measured.rows:
        return []
    rows = [row for row in default_rows(measured) if row["target"] and row["ratio"]]
    found = []
    if rows:
        met, met_many = sum(row["met"] for row in rows), sum(row["met_many"] for row in rows)
        ratios = ", ".join(f"{row['impacts']}: {1 / row['ratio_many']:.2g}" for row in rows)
        fastest = max(1 / row["ratio_many"] for row in rows)
        slowest = min(1 / row["ratio_many"] for row in rows)
        threads = max(row["threads"] for row in rows)
        found.append(
            (
                "The default against the fastest library",
                f"{slowest:.2g} to {fastest:.2g} times as fast",
                f"At a gap of 1e-9, by impacts of a zone ({ratios}), with {threads} threads where "
                f"zones are many or large; libraries take one zone and one thread. "
                f"{met_many} of {len(rows)} targets met, {met} on one thread.",
            )
        )
    count = counts(measured)
    least = min(count["asked"], default=1e-6)
    found.append(
        (
            "Directions, line searches, families",
            f"{count['reached'].get(least, 0)} of {count['cells']}",
            f"cells come to {least:.0e}, the least asked for, within their steps; "
            f"{count['missing']} missing, {count['failed']} failed.",
        )
    )
    return found


def _ms(key):
    return lambda row: None if row[key] is None else row[key] * MS


def _against_libraries(compared):
    known = [row for row in compared if row["met"] is not None]
    met = sum(row["met"] for row in known)
    columns = {
        "family": "family",
        "impacts": "impacts",
        "default [ms]": _ms("default"),
        "library": "library",
        "its time [ms]": _ms("library_s"),
        "ratio": "ratio",
        "target": "target",
        "met": _yes("met"),
        "threads": "threads",
        "ratio on these": "ratio_many",
        "met on these": _yes("met_many"),
        "ratio to 1e-12": "ratio_12",
        "met to 1e-12": _yes("met_12"),
        "one zone a call [ms]": _ms("alone"),
        "ratio so": "ratio_alone",
    }
    said = (
        "Medians of a zone, on one thread where no number is given. Zones of at most "
        f"{BATCH_IMPACTS} impacts come many at a time, so the default is timed on {BATCH} in a "
        "call, and beside it on one; a library "
        "takes one, called directly, its matrices made before. The ratio is the default's time "
        "to 1e-9, or to 1e-12, over that of the fastest library that reached 1e-9 at any of its "
        "settings (PIQP where the target names it). "
    )
    if known:
        many = sum(row["met_many"] for row in known)
        said += f"{met} of {len(known)} targets are met on one thread, {many} on all of them."
    return site.paragraph(said) + site.data_table(columns, compared)


def _yes(key):
    return lambda row: {None: "", True: "yes", False: "no"}[row[key]]


def _plots(measured, against):
    who = {
        "library": "Dark lines are ours, grey ones with open markers libraries.",
        "lagrangian": "Each direction with the line search that came farthest.",
    }[against]
    parts = []
    for measure, says in MEASURES.items():
        caption = (
            f"{says[0].upper()}{says[1:]}, the largest of a family's problems, against the median "
            f"time of a zone on one thread; a point a tolerance asked for. {who}"
        )
        svg = work_precision(measured, measure, against)
        figure = site.figure(svg, caption, site.run_ids(measured.rows))
        parts.append(figure if not parts else site.folded(f"The same with the {says}", figure))
    return "\n".join(parts)


def _against_fixed(measured, compared):
    columns = {
        "family": "family",
        "default [ms]": _ms("default"),
        "fastest fixed choice": "fixed",
        "its time [ms]": _ms("fixed_s"),
        "default over it": "against_fixed",
        "fastest library [ms]": _ms("library_s"),
        "within 20 % of the fastest": _yes("on_front"),
    }
    front = [row for row in compared if row["on_front"] is not None]
    held = sum(row["on_front"] for row in front)
    fixed = {family: measured.fixed(family, 1e-9) for family in measured.families}
    names = list(next(iter(fixed.values())))
    lines = [
        {"family": str(family), "auto": measured.own(family, 1e-9, solver="auto"), **found}
        for family, found in fixed.items()
    ]
    every = {"family": "family"} | {
        f"{name} [ms]": lambda row, name=name: row[name] and row[name]["seconds"] * MS
        for name in ("auto", *names)
    }
    return (
        site.paragraph(
            "Times to a gap and a violation of 1e-9, one thread. In "
            f"{held} of {len(front)} families the default is within 20 % of the fastest of all "
            "fixed choices and libraries."
        )
        + site.data_table(columns, compared)
        + site.folded(
            "Every fixed choice; empty where 1e-9 was not reached. Directions with the fastest of "
            "their line searches, one zone a call.",
            site.data_table(every, lines),
        )
    )


def _cells(measured):
    count = counts(measured)
    said = (
        f"{count['cells']} cells, {count['missing']} missing. The smallest tolerance that gap "
        "and violation reached within the steps allowed, and the time of a zone; darker is "
        f"closer. {count['reached'][1e-3]} cells come to 1e-3, {count['reached'][1e-6]} to 1e-6, "
        f"{count['reached'][1e-9]} to 1e-9; {count['failed']} failed. Asked for were "
        f"{', '.join(f'{t:.0e}' for t in count['asked'])}. Multipliers are updated every step, mu "
        "is fixed, float64."
    )
    return site.paragraph(said) + cells_table(measured)


def _variants(measured):
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
    return site.data_table(_columns() | {"family": "family"}, rows) if rows else site.NOT_MEASURED


def _columns():
    return {
        "solver": label,
        "asked": "tolerance",
        "outcome": "outcome",
        "reached": "reached",
        "zone [ms]": _ms("seconds"),
        "gap": "gap",
        "violation": "violation",
        "distance": "error",
        "solved": lambda row: f"{row['solved']} of {row['problems']}" if row["problems"] else "",
        "steps": "steps",
        "says": "message",
    }


def _families(measured):
    says = descriptions()
    parts = []
    for family in measured.families:
        rows = [row for row in measured.of(family) if row["kind"] != "lagrangian"]
        columns = _columns() | {"zones a call": lambda row: BATCH if row["mode"] == "batch" else 1}
        parts.append(
            site.folded(
                f"{family}: {family.size} impacts; {says.get(family, '')}",
                site.data_table(columns | {"threads": "threads"}, rows)
                + _fastest(measured, family),
            )
        )
    return "\n".join(parts)


def _fastest(measured, family):
    lines = []
    for tolerance in (1e-9, 1e-12):
        default = measured.own(family, tolerance, solver="auto")
        library = measured.library(family, tolerance)
        of = f"library {library['solver']}, {duration(library['seconds'])}" if library else "none"
        took = duration(default["seconds"]) if default else "not reached"
        lines.append(f"To {tolerance:.0e}: default {took}, fastest {of}.".replace("e-0", "e-"))
    return site.paragraph(" ".join(lines))


def _threads(measured):
    rows = []
    for family in measured.families:
        one = measured.own(family, 1e-9, solver="auto")
        two = measured.own(family, 1e-9, solver="auto", threads=2)
        if one and two:
            gain = one["seconds"] / two["seconds"]
            rows.append({"family": str(family), "one": one, "two": two, "gain": gain})
    columns = {
        "family": "family",
        "one thread [ms]": lambda row: row["one"]["seconds"] * MS,
        "two threads [ms]": lambda row: row["two"]["seconds"] * MS,
        "times as fast": "gain",
    }
    body = site.data_table(columns, rows, "The default, a zone") if rows else ""
    first = {(label(row)): row for row in reversed(measured.rows) if row["compile_s"] is not None}
    compiling = sorted(
        ({"solver": name, "compile_s": row["compile_s"]} for name, row in first.items()),
        key=lambda row: -row["compile_s"],
    )
    return body + site.data_table(
        {"solver": "solver", "first call beyond a later one [s]": "compile_s"},
        compiling,
        "Compiling, or loading what was compiled before; not in any other time of this page",
    )


def _limits(measured):
    present = {str(family) for family in measured.families}
    absent = [name for name in descriptions() if name not in present]
    out = sum((row["message"] or "").startswith("left out") for row in measured.rows)
    limits = [
        f"{out} of {len(measured.rows)} rows were left out, and say why: what took too long at a "
        "smaller size, or did not come to a looser tolerance within its steps.",
        "The steps of methods that count them are bounded by steps times impacts, so on large "
        "zones few are allowed; those cells say not converged, not that they never would.",
        f"Libraries with dense matrices get zones of at most {DENSE_IMPACTS} impacts, PIQP's dense "
        f"solver {PIQP_DENSE_IMPACTS}, SLSQP {SLSQP_IMPACTS}.",
        "quadprog and NNLS have no tolerance: one point each. A tolerance of a library is of its "
        "own residuals in scaled variables; what counts here is what ours say.",
        "The distance is to the exact optimum up to 64 impacts; above, an upper bound: the "
        "distance to our answer at 1e-12 and the proved error of that; where rows are redundant "
        f"the proof is worth some 1e-7. Above {PROVED_IMPACTS} impacts that error is what the "
        "duality gap says, not proved.",
        "A library's time is that of one zone a call from Python; from C it would be less on "
        "zones of a few impacts.",
        "Times are medians of five calls or more where these fit into the budget of a cell; a call "
        "of seconds is made once.",
        "Threads are Numba's; what libraries and BLAS start by themselves is not held back.",
        f"Two threads are timed on many small zones, and on zones of {LARGE_IMPACTS} impacts or "
        f"more. {', '.join(DIRECTIONS)} are timed one zone a call on one thread.",
        "Random zones couple vertices at random, which fills factorisations more than meshes do.",
    ]
    if absent:
        limits.append(f"Not measured in this run: {', '.join(absent)}.")
    return limits

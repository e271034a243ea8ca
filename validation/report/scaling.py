"""The page of sizes: time and memory against triangles and against impacts of one zone."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from validation.report import plots, site
from validation.report.catalogue import Headline
from validation.rows import Columns, Row, read, runs

FITTED_OVER = 10.0  # exponents are fitted over the upper decade of sizes
WIDTH, HEIGHT = 5.0, 4.2
STAGES = {
    "whole step": "total_s",
    "detecting": "detect_s",
    "solving zones": "solve_s",
    "certifying": "certify_s",
    "checking the start": "door_s",
}
FAMILIES = {
    "chain": "chain: an impact shares vertices with its neighbours only",
    "pinch": "pinch: a vertex between each two of many faces",
    "random": "random: an impact may have any vertices",
    "zone-armadillo-first": "armadillo, first iteration (recorded)",
    "zone-armadillo-last": "armadillo, last iteration (recorded)",
}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `scaling.html`.

    Args:
        rows_folder: Folder of `scaling.csv`.
        output: Folder of the pages.

    Returns:
        Path of the page.
    """
    rows = read(rows_folder, "scaling")
    path = output / "scaling.html"
    sections = [("Rows", site.NOT_MEASURED)]
    if rows:
        sheets, zones = sheet_rows(rows), _zone_rows(rows)
        sections = [
            ("Against triangles", _sheets_figure(sheets)),
            ("Against impacts of one zone", _zones_figure(zones)),
            ("Fitted exponents", _exponents(sheets, zones)),
            ("Every row", _table(rows)),
        ]
    site.write_page(
        path,
        "Scaling",
        "How time and memory grow: for a whole step with its triangles, and for one zone with its "
        "impacts. The steps are two sheets that meet in a hundredth of their vertices, with a "
        "thickness of 1e-4 m. The default method solves the zones to a gap and a violation of "
        "1e-9.",
        sections,
        _limits(rows),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figure that stands for this page; an empty list if it was not measured."""
    sheets = sheet_rows(read(rows_folder, "scaling"))
    if not sheets:
        return []
    last = sheets[-1]
    fit = exponent(sheets, "triangles", "total_s")
    growth = f" Time grows with triangles to the power {fit[0]:.2f}, {fit[1]}." if fit else ""
    return [
        Headline(
            f"A step of {last['triangles']:,} triangles",
            f"{last['total_s']:.3g} s",
            f"Resolved and certified on one thread; {last['memory_mib']:,.0f} MiB above the import."
            f"{growth}",
        )
    ]


def exponent(rows: Iterable[Row], size: str, value: str) -> tuple[float, str] | None:
    """Fit log value against log size by least squares over the upper decade.

    Args:
        rows: The rows to fit.
        size: Column of the sizes.
        value: Column of the values.

    Returns:
        The exponent, and the range of the fit in words; None if there are fewer than two sizes.
    """
    points = [(row[size], row[value]) for row in rows if row.get(size) and row.get(value)]
    points = [point for point in points if point[1] > 0.0]
    largest = max((point[0] for point in points), default=0.0)
    # a little more than a decade, because sizes are rounded to those that grids can have
    points = [point for point in points if point[0] >= 0.9 * largest / FITTED_OVER]
    if len({point[0] for point in points}) < 2:
        return None
    sizes, values = np.log(np.array(points)).T
    slope = float(np.polyfit(sizes, values, 1)[0])
    smallest = min(point[0] for point in points)
    return slope, f"over {smallest:,} to {largest:,}"


def _measured(rows: Iterable[Row]) -> list[Row]:
    """Return the rows with a time, by size, with their memory above the import and a small case."""
    found = []
    for row in rows:
        if row["outcome"] != "failed":
            memory = row["peak_mib"] - row["import_mib"]
            above = row["peak_mib"] - row["warm_mib"]
            found.append(row | {"memory_mib": memory, "above_mib": above if above > 1.0 else None})
    return sorted(found, key=lambda row: row["size"])


def sheet_rows(rows: Iterable[Row]) -> list[Row]:
    """Return the rows of whole steps, by size."""
    return _measured(row for row in rows if row["family"] == "sheets")


def _zone_rows(rows: list[Row]) -> dict[str, list[Row]]:
    """Return the rows of zones by family, and by size in each."""
    families = [name for name in FAMILIES if any(row["family"] == name for row in rows)]
    return {name: _measured(row for row in rows if row["family"] == name) for name in families}


def _sheets_figure(sheets: list[Row]) -> str:
    time, time_ax = plots.new(WIDTH, HEIGHT)
    for i, (name, column) in enumerate(STAGES.items()):
        _line(time_ax, sheets, "triangles", column, name, i)
    memory, memory_ax = plots.new(WIDTH, HEIGHT)
    _line(memory_ax, sheets, "triangles", "memory_mib", "above a process that only imports", 0)
    _line(memory_ax, sheets, "triangles", "above_mib", "above the same after a small step", 1)
    time_ax.set(xlabel="triangles", ylabel="time [s]", title="Time")
    memory_ax.set(xlabel="triangles", ylabel="memory [MiB]", title="Memory")
    caption = (
        "Time: seconds of a step by stage on one thread, the least of up to five runs, without "
        "compiling. Checking the start (that the start positions are free of intersections) comes "
        "before the step. Memory: the peak resident memory of the process above the import, and "
        "above a small step, which has loaded the compiled code; differences of less than 1 MiB "
        "are left out."
    )
    return _side_by_side((time, time_ax), (memory, memory_ax), caption, sheets, 3)


def _zones_figure(zones: dict[str, list[Row]]) -> str:
    time, time_ax = plots.new(WIDTH, HEIGHT)
    memory, memory_ax = plots.new(WIDTH, HEIGHT)
    for name, rows in zones.items():
        i = list(FAMILIES).index(name)
        _line(time_ax, rows, "impacts", "solve_s", FAMILIES[name], i)
        _line(memory_ax, rows, "impacts", "above_mib", FAMILIES[name], i)
    time_ax.set(xlabel="impacts of the zone", ylabel="time [s]", title="Time")
    memory_ax.set(xlabel="impacts of the zone", ylabel="memory [MiB]", title="Memory")
    caption = (
        "Time: seconds to solve one zone by the default method on one thread, the least of up to "
        "five runs. Memory: the peak above the same process after small zones; differences of less "
        "than 1 MiB are left out."
    )
    rows = [row for own in zones.values() for row in own]
    return _side_by_side((time, time_ax), (memory, memory_ax), caption, rows, 1)


def _side_by_side(
    time: tuple[Any, Any], memory: tuple[Any, Any], caption: str, rows: list[Row], ncols: int
) -> str:
    """Return a figure of two plots, each given as its figure and axes."""
    drawings = []
    for figure, ax in (time, memory):
        plots.logarithmic(ax)
        plots.legend_below(figure, [ax], ncols if figure is time[0] else 1)
        drawings.append(plots.svg(figure))
    body = site.panels(drawings, ["Time", "Memory"], least_px=420)
    return site.figure(body, caption, site.run_ids(rows))


def _line(ax: Any, rows: list[Row], x: str, y: str, label: str, i: int) -> None:
    points = [(row[x], row[y]) for row in rows if row.get(y)]
    if points:
        ax.plot(*zip(*points, strict=True), label=label, **plots.style(i))


def _exponents(sheets: list[Row], zones: dict[str, list[Row]]) -> str:
    wanted = [("step", name, sheets, "triangles", column) for name, column in STAGES.items()]
    wanted.append(("step", "memory without code", sheets, "triangles", "above_mib"))
    for name, rows in zones.items():
        wanted.append((name, "solving", rows, "impacts", "solve_s"))
        wanted.append((name, "memory without code", rows, "impacts", "above_mib"))
    lines = []
    for case, what, rows, size, column in wanted:
        fit = exponent(rows, size, column)
        if fit:
            line = {"case": case, "what": what, "exponent": fit[0], "range": f"{fit[1]} {size}"}
            lines.append(line)
    columns: Columns = {
        "case": "case",
        "what grows": "what",
        "exponent": "exponent",
        "fitted": "range",
    }
    caption = "Exponents, fitted by least squares of the logarithms over the upper decade"
    return site.data_table(columns, lines, caption)


def _table(rows: list[Row]) -> str:
    columns: Columns = {
        "family": "family",
        "size": "size",
        "triangles": "triangles",
        "impacts": "impacts",
        "zones": "zones",
        "largest zone": "largest_zone",
        "method": "method",
        "time [s]": "total_s",
        "detecting [s]": "detect_s",
        "solving [s]": "solve_s",
        "certifying [s]": "certify_s",
        "peak above import [MiB]": lambda row: _difference(row, "peak_mib", "import_mib"),
        "peak above a small case [MiB]": lambda row: _difference(row, "peak_mib", "warm_mib"),
        "outcome": "outcome",
        "message": "message",
    }
    return site.data_table(columns, rows, "Every size that was asked for")


def _difference(row: Row, a: str, b: str) -> float | None:
    return None if row.get(a) is None else row[a] - row[b]


def _limits(rows: list[Row]) -> list[str]:
    limits = [
        "Everything, BLAS included, runs on one thread, so that the exponents describe the work "
        "and not the load of the machine.",
        "Sheets that meet in few places mostly cost detection; the steps on the page Outer have "
        "denser contact.",
        "Memory is the peak of a process that solves one size after another, each larger than the "
        "one before. A size that needs less memory than the one before shows the peak of that one.",
        "Random zones have a dense graph, so the time to factor them grows with the third power of "
        "the impacts. They end at 4,096 impacts; contacts between surfaces do not look like them.",
    ]
    sizes = [row["triangles"] for row in sheet_rows(rows)]
    if sizes and max(sizes) < 9e5:
        limits.append(
            f"The largest step here has {max(sizes):,} triangles; a million takes minutes, and "
            "only the full report has it."
        )
    if rows and not any(row["family"].startswith("zone-") for row in rows):
        limits.append(
            "Recorded zones were left out: the report is quick, or there are no step files "
            "(IZO_DATA)."
        )
    failed = [
        f"{row['family']} {row['size']} ({row['message']})"
        for row in rows
        if row["outcome"] == "failed"
    ]
    if failed:
        limits.append("Failed: " + "; ".join(failed) + ".")
    return limits

"""The page of sizes: time and memory against triangles and against impacts of one zone."""

from pathlib import Path

import numpy as np

from validation.report import plots, site
from validation.rows import read, runs

FITTED_OVER = 10.0  # the upper decade of sizes
WIDTH, HEIGHT = 5.0, 4.2
STAGES = {
    "whole step": "total_s",
    "detecting": "detect_s",
    "solving zones": "solve_s",
    "certifying": "certify_s",
    "checking the start": "door_s",
}
FAMILIES = {
    "chain": "chain: an impact touches its neighbours only",
    "pinch": "pinch: a vertex between each two of many faces",
    "random": "random: any vertex with any other",
    "zone-armadillo-first": "armadillo, first iteration (recorded)",
    "zone-armadillo-last": "armadillo, last iteration (recorded)",
}


def page(rows_folder, output) -> Path:
    """Write the page; returns where it is.

    Args:
        rows_folder: where `scaling.csv` is.
        output: folder of the pages.
    """
    rows = read(rows_folder, "scaling")
    path = Path(output) / "scaling.html"
    sections = [("Rows", site.NOT_MEASURED)]
    if rows:
        sheets, zones = _sheets(rows), _zones(rows)
        sections = [
            ("Against triangles", _sheets_figure(sheets)),
            ("Against impacts of one zone", _zones_figure(zones)),
            ("Fitted exponents", _exponents(sheets, zones)),
            ("Every row", _table(rows)),
        ]
    site.write_page(
        path,
        "Scaling",
        "How time and memory grow: of a step with its triangles, of one zone with its impacts. "
        "The steps are two sheets that meet in a hundredth of their vertices, thickness 1e-4 m; "
        "the zones are solved by the default to a gap and a violation of 1e-9.",
        sections,
        _limits(rows),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder) -> list[tuple[str, str, str]]:
    """(label, figure, sentence) for the start page."""
    sheets = _sheets(read(rows_folder, "scaling"))
    if not sheets:
        return []
    last = sheets[-1]
    fit = exponent(sheets, "triangles", "total_s")
    grown = f"Time grows with triangles to the power {fit[0]:.2f}, {fit[1]}. " if fit else ""
    return [
        (
            f"A step of {last['triangles']:,} triangles",
            f"{last['total_s']:.3g} s",
            f"One thread, certified; {last['memory_mib']:,.0f} MiB above the import. {grown}",
        )
    ]


def exponent(rows, size, value):
    """Least squares of log value against log size over the upper decade.

    Returns:
        The exponent, and the range in words; None with fewer than two sizes there.
    """
    points = [(row[size], row[value]) for row in rows if row.get(size) and row.get(value)]
    points = [point for point in points if point[1] > 0.0]
    largest = max((point[0] for point in points), default=0.0)
    # sizes are rounded to what grids can have: a decade and a little
    points = [point for point in points if point[0] >= 0.9 * largest / FITTED_OVER]
    if len({point[0] for point in points}) < 2:
        return None
    slope = float(np.polyfit(*np.log(np.array(points)).T, 1)[0])
    smallest = min(point[0] for point in points)
    return slope, f"over {smallest:,} to {largest:,}"


def _measured(rows):
    """Rows with a time, and what the peak is above that of the import, and of a small case."""
    found = []
    for row in rows:
        if row["outcome"] != "failed":
            memory = row["peak_mib"] - row["import_mib"]
            above = row["peak_mib"] - row["warm_mib"]
            found.append(row | {"memory_mib": memory, "above_mib": above if above > 1.0 else None})
    return sorted(found, key=lambda row: row["size"])


def _sheets(rows):
    return _measured(row for row in rows if row["family"] == "sheets")


def _zones(rows):
    families = [name for name in FAMILIES if any(row["family"] == name for row in rows)]
    return {name: _measured(row for row in rows if row["family"] == name) for name in families}


def _sheets_figure(sheets):
    time, time_ax = plots.new(WIDTH, HEIGHT)
    for i, (name, column) in enumerate(STAGES.items()):
        _line(time_ax, sheets, "triangles", column, name, i)
    memory, memory_ax = plots.new(WIDTH, HEIGHT)
    _line(memory_ax, sheets, "triangles", "memory_mib", "above a process that only imports", 0)
    _line(memory_ax, sheets, "triangles", "above_mib", "above the same after a small step", 1)
    time_ax.set(xlabel="triangles", ylabel="time [s]", title="Time")
    memory_ax.set(xlabel="triangles", ylabel="memory [MiB]", title="Memory")
    caption = (
        "Seconds of a step by stage, one thread, the quickest of up to five runs; compiling is "
        "not in it. Checking the start (that Q0 is free of intersections) comes before the step. "
        "Peak resident memory of the process: above the import, and without compiled code, which "
        "is loaded once; of the latter, differences under 1 MiB are left out."
    )
    return _side_by_side((time, time_ax), (memory, memory_ax), caption, sheets, 3)


def _zones_figure(zones):
    time, time_ax = plots.new(WIDTH, HEIGHT)
    memory, memory_ax = plots.new(WIDTH, HEIGHT)
    for name, rows in zones.items():
        i = list(FAMILIES).index(name)
        _line(time_ax, rows, "impacts", "solve_s", FAMILIES[name], i)
        _line(memory_ax, rows, "impacts", "above_mib", FAMILIES[name], i)
    time_ax.set(xlabel="impacts of the zone", ylabel="time [s]", title="Time")
    memory_ax.set(xlabel="impacts of the zone", ylabel="memory [MiB]", title="Memory")
    caption = (
        "Seconds to solve one zone by the default method, one thread, the quickest of up to five "
        "runs, and the peak of memory above the same process after small zones; differences under "
        "1 MiB are left out."
    )
    rows = [row for own in zones.values() for row in own]
    return _side_by_side((time, time_ax), (memory, memory_ax), caption, rows, 1)


def _side_by_side(time, memory, caption, rows, ncols):
    drawings = []
    for figure, ax in (time, memory):
        plots.logarithmic(ax)
        plots.legend_below(figure, [ax], ncols if figure is time[0] else 1)
        drawings.append(plots.svg(figure))
    body = site.panels(drawings, ["Time", "Memory"], least_px=420)
    return site.figure(body, caption, site.run_ids(rows))


def _line(ax, rows, x, y, label, i):
    points = [(row[x], row[y]) for row in rows if row.get(y)]
    if points:
        ax.plot(*zip(*points, strict=True), label=label, **plots.style(i))


def _exponents(sheets, zones):
    wanted = [("step", name, sheets, "triangles", column) for name, column in STAGES.items()]
    wanted.append(("step", "memory without code", sheets, "triangles", "above_mib"))
    for name, rows in zones.items():
        wanted.append((name, "solving", rows, "impacts", "solve_s"))
        wanted.append((name, "memory without code", rows, "impacts", "above_mib"))
    lines = []
    for of, what, rows, size, column in wanted:
        fit = exponent(rows, size, column)
        if fit:
            lines.append({"of": of, "what": what, "exponent": fit[0], "range": f"{fit[1]} {size}"})
    columns = {"of": "of", "what grows": "what", "exponent": "exponent", "fitted": "range"}
    return site.data_table(columns, lines, "Least squares in log-log over the upper decade")


def _table(rows):
    columns = {
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
        "peak over import [MiB]": lambda row: _difference(row, "peak_mib", "import_mib"),
        "over warm [MiB]": lambda row: _difference(row, "peak_mib", "warm_mib"),
        "outcome": "outcome",
        "message": "message",
    }
    return site.data_table(columns, rows, "Every size that was asked for")


def _difference(row, a, b):
    return None if row.get(a) is None else row[a] - row[b]


def _limits(rows):
    limits = [
        "One thread for all, BLAS included: exponents are of the work, not of the machine's load.",
        "Sheets that meet in few places cost mostly detection; the steps on the page Outer "
        "have denser contact.",
        "Memory is the peak of a process that solves rising sizes, so a size that needs less than "
        "one before it would show that one's.",
        "Random zones have a dense graph, whose factorisation takes the third power of the "
        "impacts: they end at 4,096, which no contact of surfaces looks like.",
    ]
    sizes = [row["triangles"] for row in _sheets(rows)]
    if sizes and max(sizes) < 9e5:
        limits.append(
            f"The largest step here has {max(sizes):,} triangles; a million takes minutes and is "
            "in the full report only."
        )
    if rows and not any(row["family"].startswith("zone-") for row in rows):
        limits.append("Recorded zones were left out: quick, or no step files (IZO_DATA).")
    failed = [
        f"{row['family']} {row['size']} ({row['message']})"
        for row in rows
        if row["outcome"] == "failed"
    ]
    if failed:
        limits.append("Failed: " + "; ".join(failed) + ".")
    return limits

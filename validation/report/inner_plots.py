"""Work-precision diagrams of zones: error against time, a panel a family."""

from validation.report import plots
from validation.report.measured import own_mode
from validation.study.cells import LIBRARY
from validation.study.own import DIRECTIONS, DUAL

NCOLS = 3
LEAST = 1e-16  # what is smaller is drawn here
MEASURES = {
    "error": "distance to the optimum, relative",
    "gap": "relative duality gap",
    "violation": "violation over thickness",
}
# Ours are dark lines with full markers, libraries grey ones with open markers.
GREYS = ("#555555", "#8a8a8a", "#6f6f6f", "#a0a0a0")


def work_precision(measured, measure, against="library") -> str:
    """Small multiples as SVG.

    Args:
        measured: `Measured`.
        measure: one of MEASURES.
        against: "library": the dual methods and the libraries; "lagrangian": the default
            and each direction with the line search that came farthest.
    """
    families = measured.families
    nrows = -(-len(families) // NCOLS)
    fig, axes = plots.new(11.0, 2.6 * nrows + 1.2, NCOLS, nrows, squeeze=False, sharey=True)
    panels = axes.ravel()
    lines = _library_lines if against == "library" else _lagrangian_lines
    for ax, family in zip(panels, families, strict=False):
        for name, rows, look in lines(measured, family):
            _line(ax, name, rows, measure, look)
        plots.logarithmic(ax)
        ax.set_title(family)
    for ax in panels[len(families) :]:
        ax.set_axis_off()
    panels[0].set_ylim(0.3 * LEAST, 30.0)
    for row in axes:
        row[0].set_ylabel(MEASURES[measure].replace(", ", ",\n"))
    for ax in panels[max(0, len(families) - NCOLS) : len(families)]:
        ax.set_xlabel("time of a zone [s]")
    plots.legend_below(fig, panels[: len(families)], 5)
    return plots.svg(fig)


def _line(ax, name, rows, measure, look):
    points = sorted(
        (row["seconds"], max(row[measure], LEAST))
        for row in rows
        if row["seconds"] is not None and row[measure] is not None and row[measure] < 1e3
    )
    if points:
        ax.plot(*zip(*points, strict=True), label=name, **look)


def _library_lines(measured, family):
    for i, method in enumerate(DUAL):
        look = plots.style(i) | {"color": plots.COLORS[i % 4], "markersize": 6}
        rows = measured.of(family, solver=method, precision="float64", threads=1)
        alone = [row for row in rows if row["mode"] == "alone"]
        yield method, alone, look | {"linewidth": 2.4 if method == "auto" else 1.4}
        if method == "auto" and own_mode(family) == "batch":
            many = [row for row in rows if row["mode"] == "batch"]
            yield "auto, 256 zones a call", many, look | {"marker": "*", "markersize": 11}
    for i, name in enumerate(LIBRARY):
        look = plots.style(i + 5) | {"color": GREYS[i % 4], "markerfacecolor": "white"}
        yield name, measured.of(family, solver=name), look | {"linewidth": 1.0}


def _lagrangian_lines(measured, family):
    auto = measured.of(family, solver="auto", mode="alone", threads=1, precision="float64")
    yield "auto", auto, plots.style(0) | {"linewidth": 2.4}
    for i, direction in enumerate(DIRECTIONS, 1):
        rows = [
            row
            for row in measured.of(family, solver=direction, precision="float64")
            if row["update"] == "every-step" and row["penalty"] == "fixed"
        ]
        yield direction, _farthest(rows), plots.style(i)


def _farthest(rows):
    """Those of the line search that came to the smallest tolerance, or first to it."""
    reached = [row for row in rows if row["reached"] is not None]
    if not reached:
        return [row for row in rows if row["line_search"] == "backtracking"]
    best = min(reached, key=lambda row: (row["reached"], row["seconds"]))
    return [row for row in rows if row["line_search"] == best["line_search"]]

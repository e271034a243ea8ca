"""Work-precision diagrams of zones: error against time, one small plot for each family."""

from collections.abc import Iterator
from typing import Any, Literal, TypeAlias

from validation.report import plots
from validation.report.measured import Family, Measured, own_mode
from validation.rows import Row
from validation.study.cells import LIBRARY
from validation.study.own import DIRECTIONS, DUAL

# Lines of a plot: the dual methods and the libraries, or the augmented Lagrangian.
Contestants: TypeAlias = Literal["library", "lagrangian"]
Line: TypeAlias = tuple[str, list[Row], dict[str, Any]]  # name, points, style

NCOLS = 3
LEAST = 1e-16  # smaller values are drawn here
MEASURES = {
    "error": "distance to the optimum, relative",
    "gap": "relative duality gap",
    "violation": "violation over thickness",
}
# Our solvers are dark lines with full markers, libraries grey lines with open markers.
GREYS = ("#555555", "#8a8a8a", "#6f6f6f", "#a0a0a0")


def work_precision(measured: Measured, measure: str, contestants: Contestants = "library") -> str:
    """Return the plots of all families as one SVG.

    Args:
        measured: The rows.
        measure: The vertical axis, one of MEASURES.
        contestants: "library" draws the dual methods and the libraries; "lagrangian" draws the
            default, and each direction with the line search that came closest.
    """
    families = measured.families
    nrows = -(-len(families) // NCOLS)
    fig, axes = plots.new(11.0, 2.6 * nrows + 1.2, NCOLS, nrows, squeeze=False, sharey=True)
    panels = axes.ravel()
    lines = _library_lines if contestants == "library" else _lagrangian_lines
    for ax, family in zip(panels, families, strict=False):
        for name, rows, look in lines(measured, family):
            _draw_line(ax, name, rows, measure, look)
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


def _draw_line(ax: Any, name: str, rows: list[Row], measure: str, look: dict[str, Any]) -> None:
    points = sorted(
        (row["seconds"], max(row[measure], LEAST))
        for row in rows
        if row["seconds"] is not None and row[measure] is not None and row[measure] < 1e3
    )
    if points:
        ax.plot(*zip(*points, strict=True), label=name, **look)


def _library_lines(measured: Measured, family: Family) -> Iterator[Line]:
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


def _lagrangian_lines(measured: Measured, family: Family) -> Iterator[Line]:
    auto = measured.of(family, solver="auto", mode="alone", threads=1, precision="float64")
    yield "auto", auto, plots.style(0) | {"linewidth": 2.4}
    for i, direction in enumerate(DIRECTIONS, 1):
        rows = [
            row
            for row in measured.of(family, solver=direction, precision="float64")
            if row["update"] == "every-step" and row["penalty"] == "fixed"
        ]
        yield direction, _closest(rows), plots.style(i)


def _closest(rows: list[Row]) -> list[Row]:
    """Return the rows of the line search that reached the smallest tolerance, or did so first."""
    reached = [row for row in rows if row["reached"] is not None]
    if not reached:
        return [row for row in rows if row["line_search"] == "backtracking"]
    best = min(reached, key=lambda row: (row["reached"], row["seconds"]))
    return [row for row in rows if row["line_search"] == best["line_search"]]

"""Plots of the page of whole steps: a small plot for each step, and one legend."""

from collections.abc import Callable, Sequence
from typing import Any

from validation.report import plots, site
from validation.rows import Row
from validation.study.outer import DEFAULT, MOST_ROUNDS, PEER, ROUNDS, SELECTIONS, THICKNESSES_M

# Smaller excesses are drawn here: the best known has an excess of zero, which has no logarithm.
FLOOR = 1e-6
WIDTH, HEIGHT = 3.5, 2.9
SMALLEST, LARGEST = 4.0, 9.0  # markers [pt]


def rounds_figure(rows: list[Row]) -> str:
    """Return plots with a line for each selection, through its rounds; loose tolerances hollow."""
    at = [row for row in _drawn(rows) if row["thickness"] == DEFAULT.thickness]
    caption = (
        "Excess of the objective over the best known against CPU time, at a thickness of "
        f"{1e3 * DEFAULT.thickness:g} mm. A line joins 0 to {MOST_ROUNDS} rounds of new normals at "
        "a tolerance of 1e-9; the markers grow with the rounds. A hollow marker shows "
        f"{MOST_ROUNDS} rounds at a tolerance of 1e-6, an asterisk {PEER}, which was recorded "
        f"elsewhere. Values at or below {FLOOR:g} are drawn at {FLOOR:g}. Down and left is better."
    )
    return _figure(at, _rounds_panel, caption)


def thickness_figure(rows: list[Row]) -> str:
    """Return plots with a line for each selection, through its thicknesses."""
    at = [
        row
        for row in _drawn(rows)
        if row["tolerance"] == DEFAULT.tolerance and row["relinearize"] == DEFAULT.relinearize
    ]
    several = {row["step"] for row in at if row["thickness"] != DEFAULT.thickness}
    values = sorted({row["thickness"] for row in at})
    shown = ", ".join(f"{1e3 * value:g}" for value in values)
    caption = (
        "Excess of the objective over the best known at the same thickness, against CPU time. A "
        f"line joins the thicknesses {shown} mm, from small to large markers, with 3 rounds and a "
        f"tolerance of 1e-9. Values at or below {FLOOR:g} are drawn at {FLOOR:g}."
    )
    return _figure([row for row in at if row["step"] in several], _thickness_panel, caption)


def _drawn(rows: list[Row]) -> list[Row]:
    return [row for row in rows if row["excess"] is not None]


def _figure(rows: list[Row], panel: Callable[[Any, list[Row]], None], caption: str) -> str:
    if not rows:
        return site.NOT_MEASURED
    names = list(dict.fromkeys(row["step"] for row in rows))
    drawings = []
    for name in names:
        own = [row for row in rows if row["step"] == name]
        figure, ax = plots.new(WIDTH, HEIGHT)
        panel(ax, own)
        plots.logarithmic(ax)
        _set_limits(ax, own)
        ax.set_title(str(name), loc="left", fontsize=10)
        ax.set(xlabel="CPU time [s]", ylabel="excess")
        drawings.append(plots.svg(figure))
    labels = [f"{name}: excess of the objective against CPU time" for name in names]
    body = site.panels([_legend(rows)], ["Legend"]) + site.panels(drawings, labels)
    return site.figure(body, caption, site.run_ids(rows))


def _rounds_panel(ax: Any, rows: list[Row]) -> None:
    for i, selection in enumerate(SELECTIONS):
        own = [row for row in rows if row["selection"] == selection]
        tight = [row for row in own if row["tolerance"] == DEFAULT.tolerance]
        _line(ax, tight, i, "relinearize", ROUNDS)
        loose = [row for row in own if row["tolerance"] != DEFAULT.tolerance]
        style = plots.style(i) | {"linestyle": "none", "markerfacecolor": "white", "markersize": 8}
        ax.plot(*_points(loose), **style)
    peer = [row for row in rows if row["selection"] == PEER]
    ax.plot(*_points(peer), **_peer_style())


def _thickness_panel(ax: Any, rows: list[Row]) -> None:
    for i, selection in enumerate(SELECTIONS):
        own = [row for row in rows if row["selection"] == selection]
        _line(ax, own, i, "thickness", THICKNESSES_M)


def _line(ax: Any, rows: list[Row], i: int, key: str, values: Sequence[float]) -> None:
    """Draw a line whose markers grow with a column, from the first of its values to the last."""
    rows = sorted(rows, key=lambda row: row[key])
    style = plots.style(i)
    ax.plot(*_points(rows), color=style["color"], linestyle=style["linestyle"])
    for row in rows:
        share = values.index(row[key]) / (len(values) - 1)
        size = SMALLEST + (LARGEST - SMALLEST) * share
        ax.plot(*_points([row]), **style | {"linestyle": "none", "markersize": size})


def _points(rows: list[Row]) -> tuple[list[float], list[float]]:
    return [row["cpu_s"] for row in rows], [max(row["excess"], FLOOR) for row in rows]


def _peer_style() -> dict[str, Any]:
    return {"color": plots.INK, "marker": (8, 2, 0), "linestyle": "none", "markersize": 10}


def _set_limits(ax: Any, rows: list[Row]) -> None:
    """Let both axes cover a decade at least: tick labels stay apart, and noise looks small."""
    times, excesses = _points(rows)
    middle = (min(times) * max(times)) ** 0.5
    half = max((max(times) / min(times)) ** 0.5 * 1.3, 3.5)
    ax.set_xlim(middle / half, middle * half)
    ax.set_ylim(FLOOR / 2.0, max(10.0 * FLOOR, 2.0 * max(excesses)))


def _legend(rows: list[Row]) -> str:
    """Return a drawing of the legend alone."""
    figure, ax = plots.new(WIDTH, 0.9)
    ax.set_axis_off()
    for i, selection in enumerate(SELECTIONS):
        ax.plot([], [], label=selection, **plots.style(i))
    if any(row["selection"] == PEER for row in rows):
        ax.plot([], [], label=f"{PEER} (recorded elsewhere)", **_peer_style())
    ax.legend(loc="upper left", borderaxespad=0.0, borderpad=0.0)
    return plots.svg(figure)

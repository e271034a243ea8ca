"""Plots of the page of steps: a small one for each step, and one legend."""

from validation.report import plots, site
from validation.study.outer import DEFAULT, PEER, ROUNDS, SELECTIONS, THICKNESSES_M

# Excesses below are drawn here: the best known has none, and a logarithm has no zero.
FLOOR = 1e-6
WIDTH, HEIGHT = 3.5, 2.9
SMALLEST, LARGEST = 4.0, 9.0  # markers [pt]


def rounds_figure(rows):
    """Selections as lines through the rounds; the looser tolerance hollow."""
    at = [row for row in _drawn(rows) if row["thickness"] == DEFAULT.thickness]
    caption = (
        "Excess of the objective over the best known against CPU time, thickness "
        f"{1e3 * DEFAULT.thickness:g} mm. A line joins 0 to 3 rounds of new normals, from small "
        "to large markers, tolerance 1e-9; hollow: 3 rounds, tolerance 1e-6; asterisk: "
        f"{PEER}, recorded elsewhere. At or below {FLOOR:g} is drawn at {FLOOR:g}. Down and left "
        "is better."
    )
    return _figure(at, _rounds_panel, caption)


def thickness_figure(rows):
    """Selections as lines through the thicknesses."""
    at = [
        row
        for row in _drawn(rows)
        if row["tolerance"] == DEFAULT.tolerance and row["relinearize"] == DEFAULT.relinearize
    ]
    several = {row["step"] for row in at if row["thickness"] != DEFAULT.thickness}
    values = sorted({row["thickness"] for row in at})
    shown = ", ".join(f"{1e3 * value:g}" for value in values)
    caption = (
        "Excess of the objective over the best known at the same thickness, against CPU time: "
        f"{shown} mm, from small to large markers; 3 rounds, tolerance 1e-9. At or below {FLOOR:g} "
        f"is drawn at {FLOOR:g}."
    )
    return _figure([row for row in at if row["step"] in several], _thickness_panel, caption)


def _drawn(rows):
    return [row for row in rows if row["excess"] is not None]


def _figure(rows, panel, caption):
    if not rows:
        return site.NOT_MEASURED
    names = list(dict.fromkeys(row["step"] for row in rows))
    drawings = []
    for name in names:
        own = [row for row in rows if row["step"] == name]
        figure, ax = plots.new(WIDTH, HEIGHT)
        panel(ax, own)
        plots.logarithmic(ax)
        _room(ax, own)
        ax.set_title(f"{name}", loc="left", fontsize=10)
        ax.set(xlabel="CPU time [s]", ylabel="excess")
        drawings.append(plots.svg(figure))
    labels = [f"{name}: excess of the objective against CPU time" for name in names]
    body = site.panels([_legend(rows)], ["Legend"]) + site.panels(drawings, labels)
    return site.figure(body, caption, site.run_ids(rows))


def _rounds_panel(ax, rows):
    for i, selection in enumerate(SELECTIONS):
        own = [row for row in rows if row["selection"] == selection]
        tight = [row for row in own if row["tolerance"] == DEFAULT.tolerance]
        _line(ax, tight, i, "relinearize", ROUNDS)
        loose = [row for row in own if row["tolerance"] != DEFAULT.tolerance]
        style = plots.style(i) | {"linestyle": "none", "markerfacecolor": "white", "markersize": 8}
        ax.plot(*_points(loose), **style)
    peer = [row for row in rows if row["selection"] == PEER]
    ax.plot(*_points(peer), **_peer_style())


def _thickness_panel(ax, rows):
    for i, selection in enumerate(SELECTIONS):
        own = [row for row in rows if row["selection"] == selection]
        _line(ax, own, i, "thickness", THICKNESSES_M)


def _line(ax, rows, i, key, values):
    """A line whose markers grow with a column, from the first of its values to the last."""
    rows = sorted(rows, key=lambda row: row[key])
    style = plots.style(i)
    ax.plot(*_points(rows), color=style["color"], linestyle=style["linestyle"])
    for row in rows:
        share = values.index(row[key]) / (len(values) - 1)
        size = SMALLEST + (LARGEST - SMALLEST) * share
        ax.plot(*_points([row]), **style | {"linestyle": "none", "markersize": size})


def _points(rows):
    return [row["cpu_s"] for row in rows], [max(row["excess"], FLOOR) for row in rows]


def _peer_style():
    return {"color": plots.INK, "marker": (8, 2, 0), "linestyle": "none", "markersize": 10}


def _room(ax, rows):
    """Both axes over a decade at least: tick labels stay apart, and noise looks like noise."""
    times, excesses = _points(rows)
    middle = (min(times) * max(times)) ** 0.5
    half = max((max(times) / min(times)) ** 0.5 * 1.3, 3.5)
    ax.set_xlim(middle / half, middle * half)
    ax.set_ylim(FLOOR / 2.0, max(10.0 * FLOOR, 2.0 * max(excesses)))


def _legend(rows):
    """A drawing of the legend alone."""
    figure, ax = plots.new(WIDTH, 0.9)
    ax.set_axis_off()
    for i, selection in enumerate(SELECTIONS):
        ax.plot([], [], label=selection, **plots.style(i))
    if any(row["selection"] == PEER for row in rows):
        ax.plot([], [], label=f"{PEER} (recorded elsewhere)", **_peer_style())
    ax.legend(loc="upper left", borderaxespad=0.0, borderpad=0.0)
    return plots.svg(figure)

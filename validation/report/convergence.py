"""The page of convergence: zones step by step, whole steps detection by detection."""

from itertools import pairwise
from pathlib import Path

from validation.report import plots, site
from validation.rows import read, runs
from validation.study.convergence import KEYS, POINTS
from validation.study.own import DIRECTIONS, FIRST_ORDER, LINE_SEARCHES

LEAST = 1e-16  # what is smaller is drawn here
WHEN = {"every-step": "every step", "inner-solve": "after an inner solve"}


def page(rows_folder, output) -> Path:
    """Write the page; returns where it is.

    Args:
        rows_folder: where `convergence.csv` is.
        output: folder of the pages.
    """
    rows = _rows(rows_folder)
    path = Path(output) / "convergence.html"
    zones = [row for row in rows if row["part"] == "zone"]
    steps = [row for row in rows if row["part"] == "step"]
    sections = [
        (f"One zone, every direction and line search: {name}", _zone(zones, name))
        for name in _names(zones)
    ]
    sections.append(("Whole steps, detection by detection", _steps(steps)))
    site.write_page(
        path,
        "Convergence",
        "How the objective and the largest violation of a zone come to those of its optimum, "
        "step by step, for every direction and line search on the same zone; and how whole steps "
        "come to a free path.",
        sections,
        _limits(),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder) -> list[tuple[str, str, str]]:
    """(label, figure, sentence) for the start page."""
    rows = _rows(rows_folder)
    zones = [row for row in rows if row["part"] == "zone"]
    if not zones:
        return []
    name = _names(zones)[0]
    curves = [
        points
        for (method, *_), points in _curves(zones, name).items()
        if method in DIRECTIONS and points[-1].get("error") is not None
    ]
    close = [points for points in curves if points[-1]["error"] < 1e-6]
    if not close:
        return []
    best = min(close, key=lambda points: points[-1]["steps"])[-1]
    return [
        (
            "Fewest steps of a direction",
            f"{best['steps']}",
            f"{best['method']} with {best['line_search']} line search, multipliers updated "
            f"{WHEN[best['update']]}, on {name}, to a distance of {best['error']:.1e} from the "
            f"optimum; {len(close)} of {len(curves)} curves come within 1e-6.",
        )
    ]


def _rows(folder):
    """The last row of each key."""
    return list({tuple(row[k] for k in KEYS): row for row in read(folder, "convergence")}.values())


def _names(rows):
    return list(dict.fromkeys(row["name"] for row in rows))


def _curves(zones, name):
    """{(method, line search, update): points by step}, of one zone."""
    curves = {}
    for row in sorted(zones, key=lambda row: row["step"]):
        if row["name"] == name:
            curves.setdefault(tuple(row[k] for k in KEYS[2:5]), []).append(row)
    return curves


def _zone(zones, name):
    curves = _curves(zones, name)
    panels = {search: [] for search in LINE_SEARCHES} | {"others": []}
    for (method, search, update), points in curves.items():
        plain = method in DIRECTIONS and update == "every-step"
        panels[search if plain else "others"].append((method, points))
    ends = [points[-1] for points in curves.values()]
    caption = (
        f"{name}: above, the objective's distance to that of the optimum, relative; below, the "
        "largest violation over the thickness; by steps. A violated point can lie below the "
        "optimum: absolute values are drawn. Others: directions with an inner solve between "
        "updates of the multipliers (exact line search), and projected Gauss-Seidel. "
        f"Of each curve at most {POINTS} points are kept; the last mark is where it ends."
    )
    columns = {
        "method": "method",
        "line search": "line_search",
        "multipliers": "update",
        "outcome": "outcome",
        "steps": "steps",
        "relative distance": "error",
        "relative gap": "gap",
        "seconds": "seconds",
        "says": "message",
    }
    return site.figure(_zone_plot(panels), caption, site.run_ids(ends)) + site.folded(
        "Where the curves end", site.data_table(columns, ends)
    )


def _zone_plot(panels):
    fig, axes = plots.new(11.0, 6.4, len(panels), 2, sharex="col", sharey="row")
    names = (*DIRECTIONS, *FIRST_ORDER)
    for (title, curves), (above, below) in zip(panels.items(), axes.T, strict=True):
        for method, points in curves:
            number = names.index(method)
            look = plots.style(number) | {"markersize": 5}
            for ax, column in ((above, "excess"), (below, "violation")):
                drawn = [row for row in points if row.get(column) is not None and row["step"] > 0]
                if drawn:
                    ax.plot(
                        [row["step"] for row in drawn],
                        [max(abs(row[column]), LEAST) for row in drawn],
                        label=method,
                        # each elsewhere: some curves lie on one another
                        markevery=[*range(9 * number, len(drawn) - 1, 60), len(drawn) - 1],
                        **look,
                    )
        for ax in (above, below):
            plots.logarithmic(ax)
        above.set_title(title)
        below.set_xlabel("steps")
    axes[0, 0].set_ylabel("objective from the\noptimum's, relative")
    axes[1, 0].set_ylabel("violation over thickness")
    axes[0, 0].set_ylim(0.3 * LEAST, 30.0)
    axes[1, 0].set_ylim(0.3 * LEAST, None)
    plots.legend_below(fig, axes.ravel(), 8)
    return plots.svg(fig)


def _steps(rows):
    if not rows:
        return site.NOT_MEASURED
    by_name = {
        name: sorted((r for r in rows if r["name"] == name), key=lambda row: row["step"])
        for name in _names(rows)
    }
    caption = (
        "Above, the objective after each detection; below, how many impacts the path had, and how "
        "many of these entered the zones. The path is free where none is found (drawn at 0.5); "
        "dashed lines are where the normals were taken again and the solve began anew."
    )
    columns = {
        "step": "name",
        "detection": "step",
        "round": "round",
        "objective [m²]": "objective",
        "impacts of the path": "found",
        "new in the zones": "added",
        "in the zones": "impacts",
        "zones": "zones",
    }
    return site.figure(_step_plot(by_name), caption, site.run_ids(rows)) + site.folded(
        "Every detection", site.data_table(columns, [r for part in by_name.values() for r in part])
    )


def _step_plot(by_name):
    fig, axes = plots.new(11.0, 5.6, len(by_name), 2, sharex="col", squeeze=False)
    for (name, rows), (above, below) in zip(by_name.items(), axes.T, strict=True):
        at = [row["step"] + 1 for row in rows]
        above.plot(at, [row["objective"] * 1e6 for row in rows], **_small(0))
        for i, (column, label) in enumerate((("found", "of the path"), ("added", "new in zones"))):
            below.plot(at, [max(row[column], 0.5) for row in rows], label=label, **_small(i + 1))
        plots.logarithmic(below, x=False)
        for before, after in pairwise(rows):
            if before["round"] != after["round"]:
                for ax in (above, below):
                    ax.axvline(after["step"] + 0.5, color="#888888", linestyle="--", linewidth=0.9)
        above.set_title(name)
        below.set_xlabel("detection")
    axes[0, 0].set_ylabel("objective [mm²]")
    axes[1, 0].set_ylabel("impacts")
    plots.legend_below(fig, axes[1])
    return plots.svg(fig)


def _small(i):
    return plots.style(i) | {"markersize": 3.5}


def _limits():
    return [
        "Steps are no measure of time: one of newton factors a matrix, one of gradient does not.",
        "The steps of a curve are bounded by steps times impacts, so curves of large zones end "
        "early.",
        "active-set and interior-point solve in few steps that are not steps of descent, and give "
        "no curve.",
        "A whole step keeps no largest violation: what is left to do is told by the impacts that "
        "its path still has.",
        "The objective of a whole step rises from that of no impacts: each detection adds "
        "constraints, and none is taken out but where the normals are taken again.",
    ]

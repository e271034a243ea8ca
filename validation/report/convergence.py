"""The page of convergence: one zone step by step, and whole steps detection by detection."""

from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias

from validation.report import plots, site
from validation.report.catalogue import Headline
from validation.report.tables import scientific
from validation.rows import Columns, Row, read, runs
from validation.study.convergence import KEYS, POINTS
from validation.study.own import DIRECTIONS, FIRST_ORDER, LINE_SEARCHES

LEAST = 1e-16  # smaller values are drawn here
CLOSE = 1e-6  # distance to the optimum at which a curve counts as close
WHEN = {"every-step": "every step", "inner-solve": "after an inner solve"}

LIMITS = [
    "Steps do not measure time: a step of newton factors a matrix, a step of gradient does not.",
    "For each curve, steps times impacts is bounded, so curves of large zones end early.",
    "active-set and interior-point solve in few steps that are not steps of descent, so they have "
    "no curve.",
    "A whole step does not record its largest violation: the impacts that its path still has show "
    "how much is left to do.",
    "The objective of a whole step rises from zero: each detection adds constraints, and none is "
    "removed unless the normals are computed again.",
]

# The points of a curve by step, of a method, line search and update of the multipliers.
Curves: TypeAlias = dict[tuple[str, str, str], list[Row]]


def page(rows_folder: Path, output: Path) -> Path:
    """Write `convergence.html`.

    Args:
        rows_folder: Folder of `convergence.csv`.
        output: Folder of the pages.

    Returns:
        Path of the page.
    """
    rows = _rows(rows_folder)
    path = output / "convergence.html"
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
        "How the objective and the largest violation of a zone approach those of its optimum, step "
        "by step, for every direction and line search on the same zone; and how whole steps reach "
        "a free path.",
        sections,
        LIMITS,
        runs(rows_folder),
    )
    return path


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figure that stands for this page; an empty list if it was not measured."""
    rows = _rows(rows_folder)
    zones = [row for row in rows if row["part"] == "zone"]
    if not zones:
        return []
    name = _names(zones)[0]
    ends = [
        points[-1]
        for (method, *_), points in _curves(zones, name).items()
        if method in DIRECTIONS and points[-1].get("error") is not None
    ]
    close = [end for end in ends if end["error"] < CLOSE]
    if not close:
        return []
    best = min(close, key=lambda end: end["steps"])
    return [
        Headline(
            "Fewest steps of a direction",
            f"{best['steps']}",
            f"{best['method']} with {best['line_search']} line search and multipliers updated "
            f"{WHEN[best['update']]}, on {name}, to a distance of {best['error']:.1e} from the "
            f"optimum; {len(close)} of {len(ends)} curves come within {scientific(CLOSE)}.",
        )
    ]


def _rows(folder: Path) -> list[Row]:
    """Return the last row of each key."""
    return list({tuple(row[k] for k in KEYS): row for row in read(folder, "convergence")}.values())


def _names(rows: list[Row]) -> list[str]:
    return list(dict.fromkeys(row["name"] for row in rows))


def _curves(zones: list[Row], name: str) -> Curves:
    """Return the curves of one zone."""
    curves: Curves = {}
    for row in sorted(zones, key=lambda row: row["step"]):
        if row["name"] == name:
            key = row["method"], row["line_search"], row["update"]
            curves.setdefault(key, []).append(row)
    return curves


def _zone(zones: list[Row], name: str) -> str:
    curves = _curves(zones, name)
    panels: dict[str, list[tuple[str, list[Row]]]] = {search: [] for search in LINE_SEARCHES}
    panels["others"] = []
    for (method, search, update), points in curves.items():
        plain = method in DIRECTIONS and update == "every-step"
        panels[search if plain else "others"].append((method, points))
    ends = [points[-1] for points in curves.values()]
    caption = (
        f"{name}, by steps. Above: the distance of the objective to that of the optimum, relative. "
        "Below: the largest violation over the thickness. The objective of a violated point can "
        "lie below that of the optimum, so absolute values are drawn. Others are directions with "
        "an inner solve between updates of the multipliers (exact line search), and projected "
        f"Gauss-Seidel. Each curve keeps at most {POINTS} points; the last mark is its end."
    )
    columns: Columns = {
        "method": "method",
        "line search": "line_search",
        "multipliers": "update",
        "outcome": "outcome",
        "steps": "steps",
        "relative distance": "error",
        "relative gap": "gap",
        "seconds": "seconds",
        "message": "message",
    }
    return site.figure(_zone_plot(panels), caption, site.run_ids(ends)) + site.folded(
        "Where the curves end", site.data_table(columns, ends)
    )


def _zone_plot(panels: dict[str, list[tuple[str, list[Row]]]]) -> str:
    fig, axes = plots.new(11.0, 6.4, len(panels), 2, sharex="col", sharey="row")
    names = (*DIRECTIONS, *FIRST_ORDER)
    for (title, curves), (above, below) in zip(panels.items(), axes.T, strict=True):
        for method, points in curves:
            for ax, column in ((above, "excess"), (below, "violation")):
                _draw_curve(ax, method, names.index(method), points, column)
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


def _draw_curve(ax: Any, method: str, number: int, points: list[Row], column: str) -> None:
    drawn = [row for row in points if row.get(column) is not None and row["step"] > 0]
    if drawn:
        ax.plot(
            [row["step"] for row in drawn],
            [max(abs(row[column]), LEAST) for row in drawn],
            label=method,
            # curves that lie on each other have their marks at different points
            markevery=[*range(9 * number, len(drawn) - 1, 60), len(drawn) - 1],
            **plots.style(number) | {"markersize": 5},
        )


def _steps(rows: list[Row]) -> str:
    if not rows:
        return site.NOT_MEASURED
    by_name = {
        name: sorted((r for r in rows if r["name"] == name), key=lambda row: row["step"])
        for name in _names(rows)
    }
    caption = (
        "Above: the objective after each detection. Below: how many impacts the path had, and how "
        "many of these entered the zones. The path is free where no impact is found, which is "
        "drawn at 0.5. At a dashed line, the normals were computed again and the solve started "
        "again."
    )
    columns: Columns = {
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
        "Every detection",
        site.data_table(columns, [row for own in by_name.values() for row in own]),
    )


def _step_plot(by_name: dict[str, list[Row]]) -> str:
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


def _small(i: int) -> dict[str, Any]:
    return plots.style(i) | {"markersize": 3.5}

"""The page of whole steps: objective against CPU time."""

import math
from collections.abc import Iterable
from pathlib import Path

from validation.report import site
from validation.report.catalogue import Headline
from validation.report.outer_plots import rounds_figure, thickness_figure
from validation.rows import Columns, Row, read, runs
from validation.study.outer import DEFAULT, LONG_S, PEER, Setting


def page(rows_folder: Path, output: Path) -> Path:
    """Write `outer.html`.

    Args:
        rows_folder: Folder of `outer.csv`.
        output: Folder of the pages.

    Returns:
        Path of the page.
    """
    rows = compared(read(rows_folder, "outer"))
    path = output / "outer.html"
    sections = [("Rows", site.NOT_MEASURED)]
    if rows:
        sections = [
            ("What each setting costs and gains", _summary(rows)),
            ("Selection, rounds and tolerance, by step", rounds_figure(rows)),
            ("Thickness, by step", thickness_figure(rows)),
            (f"The default and {PEER}", _peer_table(rows)),
            ("Every row", _table(rows)),
        ]
    site.write_page(
        path,
        "Steps: objective against CPU time",
        "What a whole step costs, and how close its answer stays to the proposed positions, for "
        "each selection of impacts, number of rounds with new normals, tolerance and thickness. "
        "The objective is sum m |x - y|² / sum m over unpinned vertices. It is shown as the excess "
        "over the best objective known for the step at that thickness, which is the least of all "
        f"rows here whose path is certified free, and of {PEER}.",
        sections,
        _limits(rows),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this page; an empty list if it was not measured."""
    rows = compared(read(rows_folder, "outer"))
    default = [row for row in rows if setting(row) == DEFAULT and row["outcome"] != "failed"]
    if not default:
        return []
    found = []
    pairs = peer_pairs(rows)
    if pairs:
        objectives = geometric_mean(own["objective"] / peer["objective"] for own, peer in pairs)
        found.append(
            Headline(
                f"Objective over {PEER}'s",
                f"{objectives:.3f}",
                f"Geometric mean over {len(pairs)} steps at 1e-4 m, each certified free.",
            )
        )
    free = sum(row["outcome"] == "converged" for row in default)
    excess = geometric_mean(1.0 + row["excess"] for row in default if row["excess"] is not None)
    found.append(
        Headline(
            "Steps resolved by default",
            f"{free} of {len(default)}",
            "Their paths are certified free and every zone is solved; the objectives are "
            f"{100 * (excess - 1.0):.2g} % above the best known in the mean. The other results say "
            "themselves that they are not free.",
        )
    )
    return found


def setting(row: Row) -> Setting:
    """Return the setting of a row."""
    return Setting(*(row[name] for name in Setting._fields))


def compared(rows: list[Row]) -> list[Row]:
    """Return the rows with a further column `excess`.

    The excess is the objective over the best known for the step and the thickness, less 1. It is
    None where there is no free result to compare.
    """
    best: dict[tuple[str, float], float] = {}
    for row in rows:
        if row["outcome"] == "converged" and row["objective"] > 0.0:
            key = row["step"], row["thickness"]
            best[key] = min(best.get(key, math.inf), row["objective"])
    found = []
    for row in rows:
        known = best.get((row["step"], row["thickness"]))
        excess = None
        if row["outcome"] == "converged" and known is not None:
            excess = row["objective"] / known - 1.0
        found.append(row | {"excess": excess})
    return found


def peer_pairs(rows: list[Row]) -> list[tuple[Row, Row]]:
    """Return the row of the default and that of the peer, for each step where both are free."""
    free = [row for row in rows if row["outcome"] == "converged"]
    peers = {row["step"]: row for row in free if row["selection"] == PEER}
    return [(r, peers[r["step"]]) for r in free if setting(r) == DEFAULT and r["step"] in peers]


def geometric_mean(values: Iterable[float]) -> float:
    """Return the geometric mean; 1 if there are no values."""
    logs = [math.log(value) for value in values]
    return math.exp(sum(logs) / len(logs)) if logs else 1.0


def _summary(rows: list[Row]) -> str:
    """Return a table of each setting next to the default, over the steps that both resolved."""
    default = {row["step"]: row for row in rows if setting(row) == DEFAULT}
    default = {step: row for step, row in default.items() if row["excess"] is not None}
    groups: dict[Setting, list[Row]] = {}
    for row in rows:
        if row["selection"] != PEER and row["excess"] is not None:
            groups.setdefault(setting(row), []).append(row)
    lines = []
    for key, group in groups.items():
        both = [(row, default[row["step"]]) for row in group if row["step"] in default]
        if both:
            lines.append(
                key._asdict()
                | {
                    "steps": len(both),
                    "excess": 100 * (geometric_mean(1 + row["excess"] for row, _ in both) - 1),
                    "worst": 100 * max(row["excess"] for row, _ in both),
                    "time": geometric_mean(row["cpu_s"] / own["cpu_s"] for row, own in both),
                }
            )
    columns: Columns = {
        "selection": "selection",
        "thickness [m]": "thickness",
        "tolerance": "tolerance",
        "rounds": "relinearize",
        "steps": "steps",
        "objective above best [%]": "excess",
        "worst [%]": "worst",
        "CPU time over default": "time",
    }
    intro = (
        "The figures are geometric means over the steps that both the setting and the default "
        "resolved. The default is: independent, 1e-4 m, 1e-9, up to 3 rounds. Each thickness has "
        "its own best known objective."
    )
    return site.paragraph(intro) + site.data_table(columns, lines, "Settings, next to the default")


def _peer_table(rows: list[Row]) -> str:
    lines = [
        {
            "step": own["step"],
            "triangles": own["triangles"],
            "objective": own["objective"] / peer["objective"],
            "own_s": own["cpu_s"],
            "peer_s": peer["cpu_s"],
        }
        for own, peer in peer_pairs(rows)
    ]
    if not lines:
        return site.paragraph(f"No step here has a recorded result of {PEER}.")
    columns: Columns = {
        "step": "step",
        "triangles": "triangles",
        f"our objective over {PEER}'s": "objective",
        "our CPU time [s]": "own_s",
        f"{PEER}'s, recorded elsewhere [s]": "peer_s",
    }
    intro = (
        f"The times of {PEER} were recorded on one thread of another machine, so there is no "
        "ratio of times here. The report on speed has one that is scaled by the speed of machines."
    )
    return site.paragraph(intro) + site.data_table(columns, lines, f"The default and {PEER}")


def _table(rows: list[Row]) -> str:
    columns: Columns = {
        "step": "step",
        "triangles": "triangles",
        "selection": "selection",
        "thickness [m]": "thickness",
        "tolerance": "tolerance",
        "rounds": "relinearize",
        "CPU [s]": "cpu_s",
        "wall [s]": "wall_s",
        "objective [m²]": "objective",
        "above best [%]": lambda row: None if row["excess"] is None else 100.0 * row["excess"],
        "iterations": "iterations",
        "impacts": "impacts",
        "zones": "zones",
        "largest zone": "largest_zone",
        "outcome": "outcome",
        "message": "message",
    }
    return site.folded(f"{len(rows)} rows", site.data_table(columns, rows, "Every row"))


def _limits(rows: list[Row]) -> list[str]:
    limits = [
        "Steps run on one thread. The CPU time is that of the process with all its threads, and "
        "the least of up to three runs; it does not include compiling.",
        f"{PEER} was run elsewhere. Where it moved an obstacle, it solved another problem and is "
        "not compared.",
        "The best known objective is not a proved optimum, because the problem has many local "
        "optima. Where only one setting was run at a thickness, it is its own best known.",
    ]
    if any(str(row["step"]).startswith("generated") for row in rows):
        limits.append(
            f"There are no step files (IZO_DATA) here: the steps are generated, without {PEER}."
        )
    few = sorted(
        {row["step"] for row in rows if setting(row) == DEFAULT and (row["cpu_s"] or 0.0) > LONG_S}
    )
    if few:
        limits.append(
            f"Steps that take more than {LONG_S:g} s by default were run with fewer settings, "
            f"which differ in the selection only: {', '.join(few)}."
        )
    for row in rows:
        if row["outcome"] == "failed":
            limits.append(f"{row['step']} failed: {row['message']}.")
    blocked = sorted({row["step"] for row in rows if row["message"] == "BLOCKED"})
    if blocked:
        limits.append(
            f"Not free, as the result says itself, and so not in the plots: {', '.join(blocked)}."
        )
    stopped = [row for row in rows if str(row["message"]).startswith("stopped")]
    limits += [f"{row['step']}, {row['selection']}: {row['message']}." for row in stopped]
    return limits

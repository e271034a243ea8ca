"""The page of steps: objective against CPU time."""

import math
from pathlib import Path

from validation.report import site
from validation.report.outer_plots import rounds_figure, thickness_figure
from validation.rows import read, runs
from validation.study.outer import DEFAULT, LONG_S, PEER, Setting


def page(rows_folder, output) -> Path:
    """Write the page; returns where it is.

    Args:
        rows_folder: where `outer.csv` is.
        output: folder of the pages.
    """
    rows = compared(read(rows_folder, "outer"))
    path = Path(output) / "outer.html"
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
        "What a whole step costs, and how close its answer stays to what was proposed, for each "
        "selection of impacts, rounds of new normals, tolerance and thickness. The objective is "
        "sum m |x - y|² / sum m over free vertices; it is shown as the excess over the best known "
        "for the step at that thickness, of all rows here whose path is certified free and of "
        f"{PEER}.",
        sections,
        _limits(rows),
        runs(rows_folder),
    )
    return path


def headlines(rows_folder) -> list[tuple[str, str, str]]:
    """(label, figure, sentence) for the start page."""
    rows = compared(read(rows_folder, "outer"))
    own = [row for row in rows if setting(row) == DEFAULT and row["outcome"] != "failed"]
    if not own:
        return []
    found = []
    pairs = peer_pairs(rows)
    if pairs:
        objectives = geometric_mean(own["objective"] / peer["objective"] for own, peer in pairs)
        times = geometric_mean(own["cpu_s"] / peer["cpu_s"] for own, peer in pairs)
        found.append(
            (
                f"Objective over {PEER}'s",
                f"{objectives:.3f}",
                f"Geometric mean over {len(pairs)} steps at 1e-4 m, each certified free. CPU time "
                f"over its own, recorded on another machine: {times:.2g}.",
            )
        )
    free = sum(row["outcome"] == "converged" for row in own)
    excess = geometric_mean(1.0 + row["excess"] for row in own if row["excess"] is not None) - 1.0
    found.append(
        (
            "Steps resolved by default",
            f"{free} of {len(own)}",
            f"certified free with every zone solved; objectives {100 * excess:.2g} % above the "
            "best known in the mean. The others say themselves that they are not free.",
        )
    )
    return found


def setting(row) -> Setting:
    return Setting(*(row[name] for name in Setting._fields))


def compared(rows) -> list[dict]:
    """Rows with `excess`: objective over the best known for step and thickness, less 1.

    None where there is no free result to compare.
    """
    best = {}
    for row in rows:
        if row["outcome"] == "converged" and row["objective"] > 0.0:
            key = row["step"], row["thickness"]
            best[key] = min(best.get(key, math.inf), row["objective"])
    found = []
    for row in rows:
        known = best.get((row["step"], row["thickness"]))
        free = row["outcome"] == "converged" and known is not None
        found.append(row | {"excess": row["objective"] / known - 1.0 if free else None})
    return found


def peer_pairs(rows) -> list[tuple[dict, dict]]:
    """The default's row and the peer's, of each step where both are free."""
    free = [row for row in rows if row["outcome"] == "converged"]
    peers = {row["step"]: row for row in free if row["selection"] == PEER}
    return [(r, peers[r["step"]]) for r in free if setting(r) == DEFAULT and r["step"] in peers]


def geometric_mean(values) -> float:
    """1 for none."""
    logs = [math.log(value) for value in values]
    return math.exp(sum(logs) / len(logs)) if logs else 1.0


def _summary(rows):
    """Each setting next to the default, over the steps that both resolved."""
    default = {row["step"]: row for row in rows if setting(row) == DEFAULT}
    groups = {}
    for row in rows:
        if row["selection"] != PEER and row["excess"] is not None:
            groups.setdefault(setting(row), []).append(row)
    lines = []
    for key, group in groups.items():
        both = [
            (row, default[row["step"]])
            for row in group
            if default.get(row["step"], {}).get("excess") is not None
        ]
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
    columns = {
        "selection": "selection",
        "thickness [m]": "thickness",
        "tolerance": "tolerance",
        "rounds": "relinearize",
        "steps": "steps",
        "objective above best [%]": "excess",
        "worst [%]": "worst",
        "CPU time over default": "time",
    }
    said = (
        "Geometric means over the steps that a setting and the default both resolved. The "
        "default: independent, 1e-4 m, 1e-9, up to 3 rounds. Each thickness has a best known of "
        "its own."
    )
    return site.paragraph(said) + site.data_table(columns, lines, "Settings, against the default")


def _peer_table(rows):
    lines = [
        {
            "step": own["step"],
            "triangles": own["triangles"],
            "objective": own["objective"] / peer["objective"],
            "own_s": own["cpu_s"],
            "peer_s": peer["cpu_s"],
            "time": own["cpu_s"] / peer["cpu_s"],
        }
        for own, peer in peer_pairs(rows)
    ]
    if not lines:
        return site.paragraph(f"No step here has a recorded point of {PEER}.")
    columns = {
        "step": "step",
        "triangles": "triangles",
        "objective, ours over its": "objective",
        "CPU time, ours [s]": "own_s",
        "its, recorded elsewhere [s]": "peer_s",
        "ours over its": "time",
    }
    said = (
        "Its times were recorded elsewhere, on one thread of another machine: the ratio of times "
        "is for orientation."
    )
    return site.paragraph(said) + site.data_table(columns, lines, f"Default against {PEER}")


def _table(rows):
    columns = {
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


def _limits(rows):
    limits = [
        "One thread; CPU time of the process (all its threads), the quickest of up to three runs; "
        "compiling is not in it.",
        f"{PEER} was run elsewhere; where it moved an obstacle it solved another problem and is "
        "not compared.",
        "The best known is no proved optimum: the problem has many local ones. Where one setting "
        "alone was run at a thickness, it is its own best known.",
    ]
    if any(str(row["step"]).startswith("generated") for row in rows):
        limits.append("No step files (IZO_DATA) here: the steps are generated, and without a peer.")
    few = sorted(
        {row["step"] for row in rows if setting(row) == DEFAULT and (row["cpu_s"] or 0.0) > LONG_S}
    )
    if few:
        limits.append(
            f"Steps that take over {LONG_S:g} s by default were run with fewer settings, the "
            f"selections only: {', '.join(few)}."
        )
    for row in rows:
        if row["outcome"] == "failed":
            limits.append(f"{row['step']} failed: {row['message']}.")
    blocked = sorted({row["step"] for row in rows if row["message"] == "BLOCKED"})
    if blocked:
        limits.append(f"Not free, and said so, so not in the plots: {', '.join(blocked)}.")
    stopped = [row for row in rows if str(row["message"]).startswith("stopped")]
    limits += [f"{row['step']}, {row['selection']}: {row['message']}." for row in stopped]
    return limits

"""Sections of the page of speed: detection, whole steps beside a peer, deep contact, next step."""

import numpy as np

from validation.report.catalogue import Headline
from validation.report.tables import met, section
from validation.rows import Columns, Row
from validation.study.speed_detection import BOTH, LBVH, LBVH_THEN_S, OWN, THEN_THREADS
from validation.study.speed_steps import AFTER, AFTER_RESOLVED, NEW, NEW_RESOLVED, STAGES

PEER = "ARCSim 0.2.1"
# What is wanted: ratios to others, the first on one thread by step and 1 elsewhere.
LBVH_RATIOS = {"armadillo-rollers": 0.7, "stack-6k": 1.3, "cloth-funnel-clean": 0.8}
BOTH_RATIO, CPU_RATIO, MOST_CPU_RATIO, OBJECTIVE_RATIO = 0.15, 0.1, 0.25, 0.985
RELINEARIZE_SHARE = 0.3  # of the time of a step of deep contact
ROUNDS = range(4)  # numbers of rounds with new normals


def headlines(rows: list[Row]) -> list[Headline]:
    """Return the figure of whole steps; an empty list if none has a time that can be compared."""
    ratios = [row["cpu_ratio"] for row in compared(rows) if row["cpu_ratio"] is not None]
    if not ratios:
        return []
    return [
        Headline(
            f"CPU time of a whole step over {PEER}'s",
            f"{_geometric_mean(ratios):.3g}",
            f"Geometric mean over {len(ratios)} steps on one thread, from {min(ratios):.2g} to "
            f"{max(ratios):.2g}. {PEER}'s times were recorded on another machine and are "
            f"multiplied by {_scales(rows)}, which is what LBVH of ipctk takes here over what it "
            "took there.",
        )
    ]


def detection(rows: list[Row]) -> str:
    """Return the section of detection, from the rows of `detection`."""
    by_key = {(row["step"], row["what"], row["threads"]): row for row in rows}
    lines = []
    for step, count in dict.fromkeys((row["step"], row["threads"]) for row in rows):
        own, lbvh, both = (by_key.get((step, what, count)) for what in (OWN, LBVH, BOTH))
        if own is None or lbvh is None:
            continue
        ratio = own["median_s"] / lbvh["median_s"]
        wanted = LBVH_RATIOS.get(step, 1.0)
        lines.append(
            {
                "step": step,
                "threads": count,
                "own": own["median_s"],
                "lbvh": lbvh["median_s"],
                "both": both and both["median_s"],
                "over_lbvh": met(ratio, wanted) if count == 1 else ratio,
                "wanted": wanted if count == 1 else None,
                "over_both": both and met(own["median_s"] / both["median_s"], BOTH_RATIO),
                "impacts": own["found"],
                "candidates": lbvh["found"],
            }
        )
    columns: Columns = {
        "step": "step",
        "threads": "threads",
        "all impacts, izo_ref [s]": "own",
        "LBVH candidates, ipctk [s]": "lbvh",
        "with step size [s]": "both",
        "over LBVH": "over_lbvh",
        "wanted": "wanted",
        f"over both (wanted {BOTH_RATIO:g})": "over_both",
        "impacts": "impacts",
        "LBVH candidates": "candidates",
    }
    intro = (
        "izo_ref finds all impacts of a step: it builds trees, finds pairs and computes their "
        "frames. ipctk lists its candidate pairs with LBVH, on the same number of threads; with "
        "step size, it also computes one step size by Tight Inclusion, on all threads."
    )
    return section("Detection", intro, columns, sorted(lines, key=lambda line: line["threads"]))


def compared(rows: list[Row]) -> list[Row]:
    """Return the steps on one thread, each with its ratios to the peer.

    `raw_ratio` is to the CPU time that was recorded on another machine, `cpu_ratio` to that time
    multiplied by `arcsim_scale`. Both are None if there is no scale.
    """
    lines = []
    for row in rows:
        if row["threads"] == 1:
            scale, moved = row["arcsim_scale"], row["obstacle_moved"]
            raw = row["cpu_s"] / row["arcsim_cpu_s"] if scale else None
            ratios = {
                "raw_ratio": raw,
                "cpu_ratio": raw and raw / scale,
                "objective_ratio": None if moved else row["objective"] / row["arcsim_objective"],
            }
            lines.append(row | ratios)
    return lines


def whole_steps(rows: list[Row]) -> str:
    """Return the section of whole steps beside the peer, from the rows of `resolve`."""
    lines = compared(rows)
    columns: Columns = {
        "step": "step",
        "triangles": "triangles",
        "izo_ref [CPU s]": "cpu_s",
        "ARCSim, recorded [CPU s]": "arcsim_cpu_s",
        "raw ratio": "raw_ratio",
        "scale": "arcsim_scale",
        f"scaled ratio (wanted {MOST_CPU_RATIO:g} at most)": lambda row: met(
            row["cpu_ratio"], MOST_CPU_RATIO
        ),
        "objective over ARCSim's": "objective_ratio",
        "status": "status",
        "runs": "repeats",
    }
    intro = f"All times are on one thread. {_about_scale(rows)} Where ARCSim moved an obstacle, "
    intro += "its objective belongs to another problem and is not compared."
    means = []
    for name, key, wanted in (
        ("raw CPU", "raw_ratio", None),
        ("scaled CPU", "cpu_ratio", CPU_RATIO),
        ("objective", "objective_ratio", OBJECTIVE_RATIO),
    ):
        values = [row[key] for row in lines if row[key] is not None]
        if values:
            mean = _geometric_mean(values)
            said = f"{met(mean, wanted)} (wanted {wanted:g})" if wanted else f"{mean:.3g}"
            means.append(f"{name} {said}")
    intro += f" Geometric means: {', '.join(means)}." if means else ""
    return section("Whole steps", intro, columns, lines)


def _about_scale(rows: list[Row]) -> str:
    """Return what the scale of the peer's times is, and why there is one."""
    said = (
        f"The CPU time of {PEER} was recorded on another machine, which may be slower or faster "
        "than this one, so a raw ratio also compares the machines. "
    )
    scaled = [row for row in rows if row["arcsim_scale"]]
    if not scaled:
        return f"{said}LBVH was not timed here as it was there, so there is no ratio."
    ratios = (f"{scaled[-1][f'lbvh_{step}']:.3g} ({step})" for step in LBVH_THEN_S)
    return (
        f"{said}LBVH of ipctk was timed on both, on {THEN_THREADS} threads; the scale is its time "
        "here over its time there, the geometric mean over three steps, and the scaled ratio is to "
        f"{PEER}'s time multiplied by it. LBVH takes {', '.join(ratios)} of its time there. It had "
        f"{scaled[-1]['lbvh_cores']:.2g} cores while it was timed; were another process holding "
        "one, the scale would be too large."
    )


def _scales(rows: list[Row]) -> str:
    """Return the scales of some rows; it is one if all were measured in one run."""
    return " or ".join(dict.fromkeys(f"{row['arcsim_scale']:.3g}" for row in rows))


def deep(rows: list[Row]) -> str:
    """Return the section of deep contact, from the rows of `deep`."""
    columns: Columns = {
        "family": "family",
        "triangles": "triangles",
        "threads": "threads",
        "whole [s]": "median_s",
        "main loop": "main_s",
        "re-linearising": "relinearize_s",
        f"its share (wanted {RELINEARIZE_SHARE:g})": lambda row: met(
            _share(row), RELINEARIZE_SHARE
        ),
        "in the loops: detecting": "detect_s",
        "in the loops: solving": "solve_s",
        "detections": "iterations",
        "objective [m^2]": "objective",
        "status": "status",
        "runs": "repeats",
    }
    intro = (
        "Balls are pressed together so that neighbours overlap by up to 0.8 of their radius, and "
        "five layers of a garment are pressed through one another and onto a body. The whole is "
        "the median; stages are those of the last run."
    )
    return section("Deep contact", intro, columns, rows)


def _share(row: Row) -> float:
    """Return the share of re-linearising in the time of all stages."""
    return row["relinearize_s"] / sum(row[f"{name}_s"] for name in STAGES)


def rounds(whole: list[Row], deep_rows: list[Row]) -> str:
    """Return what each round with new normals gains and costs, on one thread."""
    named = [row | {"name": row["step"]} for row in whole]
    named += [row | {"name": f"{row['family']} {row['size']:,}"} for row in deep_rows]
    lines = [row for row in named if row["threads"] == 1 and row["rounds_0_s"]]
    columns: Columns = {"step": "name", "share of re-linearising": _share}
    for number in ROUNDS[1:]:
        columns[f"objective after {number}"] = lambda row, k=number: _over_none(
            row, f"objective_{k}", "objective_0"
        )
    for number in ROUNDS[1:]:
        columns[f"time after {number}"] = lambda row, k=number: _over_none(
            row, f"rounds_{k}_s", "rounds_0_s"
        )
    intro = (
        "Objective and time of all iterations after 1, 2 and 3 rounds with new normals, over those "
        "without a round. A cell is empty if the round was not run, because the one before it "
        "gained too little; the last round is taken back if it gained nothing."
    )
    return section("What each round with new normals gains", intro, columns, lines)


def _over_none(row: Row, key: str, without: str) -> float | None:
    """Return a value after some rounds over that without a round; None if it does not exist."""
    return row[key] / row[without] if row[key] is not None and row[without] else None


def next_step(rows: list[Row]) -> str:
    """Return the section of the next step of a simulation, from the rows of `next`."""
    times: dict[tuple[str, float, int], dict[str, float]] = {}
    for row in rows:
        times.setdefault((row["step"], row["motion"], row["threads"]), {})[row["what"]] = row[
            "median_s"
        ]
    lines = []
    for (step, motion, count), own in times.items():
        new, new_resolved, after, after_resolved = (
            own[what] for what in (NEW, NEW_RESOLVED, AFTER, AFTER_RESOLVED)
        )
        lines.append(
            {
                "step": step,
                "motion": motion,
                "threads": count,
                "new": new,
                "new_resolved": new_resolved,
                "share": new / new_resolved,
                "after": after,
                "after_resolved": after_resolved,
                "ratio": after_resolved / new_resolved,
            }
        )
    columns: Columns = {
        "step": "step",
        "motion": "motion",
        "threads": "threads",
        "a new Scene [s]": "new",
        "with resolve": "new_resolved",
        "share of the new Scene": "share",
        "scene.after [s]": "after",
        "with resolve, after": "after_resolved",
        "after over new": "ratio",
    }
    intro = (
        "The vertices are proposed to move on as they did in the step before, or by a part of that "
        "motion. A new Scene checks its start and sorts its elements for the trees; `scene.after` "
        "needs neither. The positions are the same, bit for bit."
    )
    return section("The next step", intro, columns, lines)


def _geometric_mean(values: list[float]) -> float:
    return float(np.exp(np.mean(np.log(values))))

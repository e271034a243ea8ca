"""The page of speed, from the rows of `study/speed.py`."""

from pathlib import Path
from typing import Any

import numpy as np

from validation.report.catalogue import Headline
from validation.report.speed_notes import NOTES
from validation.report.tables import NOT_MEASURED, run_table, table, write_page
from validation.rows import Columns, Row, read, runs_of
from validation.study.speed import BOTH, LBVH, OWN

PARTS = ("detection", "resolve", "ablation", "cold", "scale")
PEER = "ARCSim 0.2.1"
MEBIBYTE_KB = 1048.576  # kB in a MiB
# What is wanted: ratios to others, and the exponent of time against triangles.
LBVH_RATIO, BOTH_RATIO, CPU_RATIO, OBJECTIVE_RATIO, EXPONENT = 1.0, 0.15, 0.1, 0.985, 1.1
INTRO = (
    "Measured by `python -m validation study speed`. Seconds are of a wall clock unless a heading "
    "says CPU. Each is the median of five runs, after one run that does not count; a row says if "
    "it has fewer runs. Both sides of a ratio were measured in turn in one run of the study. Times "
    "do not include compiling, except under Cold start."
)


def page(rows_folder: Path, output: Path) -> Path:
    """Write `README.md`.

    Args:
        rows_folder: Folder of the CSV files, one for each of PARTS.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    rows = {name: read(rows_folder, name) for name in PARTS}
    made = runs_of(rows_folder, (row for part in rows.values() for row in part))
    sections = (
        "# Speed, and what a scene does not need",
        INTRO,
        run_table(made),
        _detection(rows["detection"]),
        _whole_steps(rows["resolve"]),
        _threads(rows["detection"], rows["resolve"]),
        _stages(rows["resolve"]),
        _ablation(rows["ablation"], [row["step"] for row in rows["resolve"]]),
        _cold_start(rows["cold"]),
        _sizes(rows["scale"]),
        NOTES,
    )
    return write_page(output / "README.md", sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    found = []
    compared = _compared(read(rows_folder, "resolve"))
    if compared:
        ratios = [row["cpu_ratio"] for row in compared]
        found.append(
            Headline(
                f"CPU time of a whole step over {PEER}'s",
                f"{_geometric_mean(ratios):.3g}",
                f"Geometric mean over {len(ratios)} steps on one thread, from {min(ratios):.2g} to "
                f"{max(ratios):.2g}. {PEER}'s times were recorded before, on a machine of the same "
                "kind.",
            )
        )
    sizes = _finished(read(rows_folder, "scale"))
    if sizes:
        largest = max(sizes, key=lambda row: (row["triangles"], row["threads"]))
        found.append(
            Headline(
                f"A step of {largest['triangles']:,} triangles",
                f"{largest['total_s']:.2g} s",
                f"Resolved and certified on {largest['threads']} threads; with checking the start "
                f"{largest['with_door_s']:.2g} s. Memory above the import: "
                f"{largest['memory_mib']:,.0f} MiB.",
            )
        )
    return found


def _met(value: float, limit: float) -> str:
    """Return a value, and whether it is as low as wanted."""
    return f"{value:.3g} {'met' if value <= limit else 'MISSED'}"


def _geometric_mean(values: list[float]) -> float:
    return float(np.exp(np.mean(np.log(values))))


def _section(heading: str, intro: str, columns: Columns, rows: list[Row]) -> str:
    """Return a section with one table; if there are no rows, it says so."""
    if not rows:
        return f"## {heading}\n\n{NOT_MEASURED}"
    return f"## {heading}\n\n{intro}\n\n{table(columns, rows)}"


def _detection(rows: list[Row]) -> str:
    by_key = {(row["step"], row["what"], row["threads"]): row for row in rows}
    lines = []
    for step in dict.fromkeys(row["step"] for row in rows):
        most = max(row["threads"] for row in rows if row["step"] == step)
        own, lbvh, both = (by_key[step, what, most] for what in (OWN, LBVH, BOTH))
        lines.append(
            {
                "step": step,
                "threads": most,
                "own": own["median_s"],
                "lbvh": lbvh["median_s"],
                "both": both["median_s"],
                "over_lbvh": _met(own["median_s"] / lbvh["median_s"], LBVH_RATIO),
                "over_both": _met(own["median_s"] / both["median_s"], BOTH_RATIO),
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
        f"over LBVH (wanted {LBVH_RATIO:g})": "over_lbvh",
        f"over both (wanted {BOTH_RATIO:g})": "over_both",
        "impacts": "impacts",
        "LBVH candidates": "candidates",
    }
    intro = (
        "izo_ref finds all impacts of a step: it builds trees, finds pairs and computes their "
        "frames. ipctk lists its candidate pairs with LBVH; with step size, it also computes one "
        "step size by Tight Inclusion."
    )
    return _section("Detection", intro, columns, lines)


def _compared(rows: list[Row]) -> list[Row]:
    """Return the steps on one thread, each with its ratios to the peer."""
    return [
        row
        | {
            "cpu_ratio": row["cpu_s"] / row["arcsim_cpu_s"],
            "objective_ratio": None
            if row["obstacle_moved"]
            else row["objective"] / row["arcsim_objective"],
        }
        for row in rows
        if row["threads"] == 1
    ]


def _whole_steps(rows: list[Row]) -> str:
    lines = _compared(rows)
    columns: Columns = {
        "step": "step",
        "triangles": "triangles",
        "izo_ref [CPU s]": "cpu_s",
        "ARCSim, recorded [CPU s]": "arcsim_cpu_s",
        f"ratio (wanted {CPU_RATIO:g})": lambda row: _met(row["cpu_ratio"], CPU_RATIO),
        "objective over ARCSim's": "objective_ratio",
        "status": "status",
        "runs": "repeats",
    }
    intro = ""
    if lines:
        cpu = _geometric_mean([row["cpu_ratio"] for row in lines])
        ratios = [row["objective_ratio"] for row in lines if row["objective_ratio"] is not None]
        objective = _met(_geometric_mean(ratios), OBJECTIVE_RATIO)
        intro = (
            f"All times are on one thread. The CPU time of {PEER} was not measured in this run: it "
            "was recorded before, on a machine of the same kind. Where ARCSim moved an obstacle, "
            "its objective belongs to another problem and is not compared. Geometric means: CPU "
            f"{cpu:.3g}, objective {objective} (wanted {OBJECTIVE_RATIO:g})."
        )
    return _section("Whole steps", intro, columns, lines)


def _threads(detection: list[Row], whole: list[Row]) -> str:
    lines = []
    for what, rows in (("detection", detection), ("whole step", whole)):
        own = [row for row in rows if row.get("what", OWN) == OWN]
        times = {(row["step"], row["threads"]): row["median_s"] for row in own}
        for step in dict.fromkeys(row["step"] for row in own):
            if (step, 1) in times and (step, 2) in times:
                lines.append({"step": step, "what": what, "gain": times[step, 1] / times[step, 2]})
    columns: Columns = {"step": "step", "what": "what", "two threads are faster by": "gain"}
    intro = "Wanted: a factor of 1.7 on steps with more than 50k triangles."
    return _section("Two threads", intro, columns, lines)


def _stages(rows: list[Row]) -> str:
    columns: Columns = {
        "step": "step",
        "threads": "threads",
        "whole [s]": "median_s",
        "main loop": "main_s",
        "re-linearising": "relinearize_s",
        "scaling back": "scale_back_s",
        "certifying": "certify_s",
        "judging": "judge_s",
        "in the loops: detecting": "detect_s",
        "in the loops: solving": "solve_s",
        "detections": "iterations",
    }
    intro = "Seconds of each stage of a whole step."
    return _section("Where the time goes", intro, columns, rows)


def _ablation(rows: list[Row], steps: list[str]) -> str:
    if not rows:
        return f"## What each rule saves\n\n{NOT_MEASURED}"
    rules = list(dict.fromkeys(row["left_out"] for row in rows))
    by_key = {(row["step"], row["left_out"]): row for row in rows}
    found = list(dict.fromkeys(row["step"] for row in rows))
    columns: Columns = {"step": "step"} | {rule: rule for rule in rules}

    def grid(column: str) -> str:
        """Return a table with a line for each step and a column for each rule."""
        lines: list[dict[str, Any]] = [
            {"step": step} | {rule: by_key[step, rule][column] for rule in rules} for step in found
        ]
        return table(columns, lines)

    repeats = [row["repeats"] for row in rows]
    missing = [step for step in dict.fromkeys(steps) if step not in found]
    sections = (
        "## What each rule saves",
        "Each rule was switched off on its own, and then all of them. Every rule but `closed-form` "
        "leaves the answer the same, bit for bit. The first table shows the time over that with "
        f"all rules, from {min(repeats)} to {max(repeats)} runs each. Its first column is 1 by "
        "definition; differences of a few hundredths are noise.",
        grid("ratio"),
        "Peak of the arrays that Python allocates [MiB]:",
        grid("arrays_mib"),
        "Pairs that were examined in all detections:",
        grid("pairs"),
        *(f"Not measured yet: {step}." for step in missing),
    )
    return "\n\n".join(section.strip() for section in sections)


def _cold_start(rows: list[Row]) -> str:
    columns: Columns = {
        "what": "what",
        "median [s]": "median_s",
        "least": "least_s",
        "runs": "repeats",
    }
    intro = (
        "Each run is a new process; the bytecode is on the disk. Wanted: 0.3 s above an empty "
        "Python for the import, 20 s for the first step, 1.5 s for a step after it."
    )
    return _section("Cold start", intro, columns, rows)


def _finished(rows: list[Row]) -> list[Row]:
    """Return the sizes that were resolved, each with its memory above the import."""
    found = []
    for row in rows:
        if row["outcome"] != "failed":
            memory_mib = row["peak_mib"] - row["import_mib"]
            found.append(
                row
                | {
                    "with_door_s": row["total_s"] + row["door_s"],
                    "memory_mib": memory_mib,
                    "kb_a_triangle": memory_mib * MEBIBYTE_KB / row["triangles"],
                }
            )
    return found


def _sizes(rows: list[Row]) -> str:
    lines = _finished(rows)
    exponents = []
    for count in dict.fromkeys(row["threads"] for row in lines):
        own = [row for row in lines if row["threads"] == count]
        triangles = np.log([row["triangles"] for row in own])
        slope = np.polyfit(triangles, np.log([row["total_s"] for row in own]), 1)[0]
        exponents.append(f"{_met(float(slope), EXPONENT)} on {count} threads")
    columns: Columns = {
        "triangles": "triangles",
        "threads": "threads",
        "resolved and certified [s]": "total_s",
        "with checking the start": "with_door_s",
        "memory above the import [MiB]": "memory_mib",
        "kB a triangle": "kb_a_triangle",
        "outcome": "outcome",
    }
    intro = (
        "The scene is two sheets that meet in a hundredth of their vertices. Wanted: a million "
        f"triangles in 60 s and 3 GB, an exponent of {EXPONENT:g}, 1.5 kB a triangle. Exponent of "
        f"time over all sizes (wanted {EXPONENT:g}): {', '.join(exponents)}."
    )
    return _section("Size", intro, columns, lines)

"""The page of speed, from the rows of `study/speed.py`."""

from pathlib import Path
from typing import Any

import numpy as np

from validation.report import speed_steps
from validation.report.catalogue import Headline
from validation.report.speed_notes import NOTES
from validation.report.tables import NOT_MEASURED, met, run_table, section, table, write_page
from validation.rows import Columns, Row, read, runs_of
from validation.study.speed_detection import OWN

PARTS = ("detection", "resolve", "deep", "next", "ablation", "cold", "scale")
MEBIBYTE_KB = 1048.576  # kB in a MiB
EXPONENT = 1.1  # of time against triangles, which is wanted
INTRO = (
    "Measured by `python -m validation study speed`. Seconds are of a wall clock unless a heading "
    "says CPU. Each is the median of five runs, after one run that does not count; a row says if "
    "it has fewer runs. Both sides of a ratio were measured in turn in one run of the study; the "
    "times of ARCSim were not, and are scaled. Times do not include compiling, except under Cold "
    "start."
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
        speed_steps.detection(rows["detection"]),
        speed_steps.whole_steps(rows["resolve"]),
        _threads(rows["detection"], rows["resolve"]),
        _stages(rows["resolve"]),
        speed_steps.deep(rows["deep"]),
        speed_steps.rounds(rows["resolve"], rows["deep"]),
        speed_steps.next_step(rows["next"]),
        _ablation(rows["ablation"], [row["step"] for row in rows["resolve"]]),
        _cold_start(rows["cold"]),
        _sizes(rows["scale"]),
        NOTES,
    )
    return write_page(output / "README.md", sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    found = speed_steps.headlines(read(rows_folder, "resolve"))
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


def _threads(detection: list[Row], whole: list[Row]) -> str:
    lines = []
    for what, rows in (("detection", detection), ("whole step", whole)):
        own = [row for row in rows if row.get("what", OWN) == OWN]
        times = {(row["step"], row["threads"]): row["median_s"] for row in own}
        for step in dict.fromkeys(row["step"] for row in own):
            if (step, 1) in times and (step, 2) in times:
                lines.append({"step": step, "what": what, "gain": times[step, 1] / times[step, 2]})
    columns: Columns = {"step": "step", "what": "what", "two threads are faster by": "gain"}
    intro = (
        "Wanted: a factor of 1.8 for detection and 1.6 for whole steps, on steps with more than 5k "
        "triangles."
    )
    return section("Two threads", intro, columns, lines)


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
    return section("Where the time goes", intro, columns, rows)


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
    return section("Cold start", intro, columns, rows)


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
        exponents.append(f"{met(float(slope), EXPONENT)} on {count} threads")
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
    return section("Size", intro, columns, lines)

"""Rows of `study.speed` to `reports/speed/README.md`."""

import numpy as np

from validation.report.tables import table, write
from validation.rows import read, runs
from validation.study.speed import BOTH, LBVH, OWN


def speed_report(folder, command):
    """Write the page.

    Args:
        folder: `Path`, of the page; rows are in `rows/` there.
        command: that made it.
    """
    rows = {
        name: read(folder / "rows", name)
        for name in ("detection", "resolve", "ablation", "cold", "scale")
    }
    used = {row["run"] for part in rows.values() for row in part}
    made = [run for run in runs(folder / "rows") if run["run"] in used]
    parts = [
        "# Speed, and what a scene does not need",
        f"Made by `{command}`. Seconds are of a wall clock unless CPU is said; medians of five "
        "runs after one that does not count, fewer where a row says so; both sides of a ratio in "
        "turn, in one run; compiling is not in them but under Cold start.",
        table({"run": "run", "commit": "commit", "machine": "machine", "begun": "started"}, made),
        _detection(rows["detection"]),
        _whole(rows["resolve"]),
        _threads(rows["detection"], rows["resolve"]),
        _stages(rows["resolve"]),
        _ablation(rows["ablation"], [row["step"] for row in rows["resolve"]]),
        _cold(rows["cold"]),
        _scale(rows["scale"]),
        NOTES,
    ]
    write(folder / "README.md", "\n\n".join(part.strip() for part in parts) + "\n")


def _met(value, limit):
    return f"{value:.3g} {'met' if value <= limit else 'MISSED'}"


def _detection(rows):
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
                "over_lbvh": _met(own["median_s"] / lbvh["median_s"], 1.0),
                "over_both": _met(own["median_s"] / both["median_s"], 0.15),
                "impacts": own["found"],
                "candidates": lbvh["found"],
            }
        )
    columns = {
        "step": "step",
        "threads": "threads",
        "all impacts, izo_ref [s]": "own",
        "LBVH candidates, ipctk [s]": "lbvh",
        "with step size [s]": "both",
        "over LBVH (1)": "over_lbvh",
        "over both (0.15)": "over_both",
        "impacts": "impacts",
        "LBVH candidates": "candidates",
    }
    text = (
        "## Detection\n\nAll impacts of a step, from trees to frames, against what ipctk takes "
        "to list its candidates, and with Tight Inclusion for one step size.\n\n"
    )
    return text + (table(columns, lines) if lines else "Not measured yet.")


def _whole(rows):
    alone = [row for row in rows if row["threads"] == 1]
    lines = [
        row
        | {
            "cpu_ratio": row["cpu_s"] / row["arcsim_cpu_s"],
            "objective_ratio": None
            if row["obstacle_moved"]
            else row["objective"] / row["arcsim_objective"],
        }
        for row in alone
    ]
    columns = {
        "step": "step",
        "triangles": "triangles",
        "izo_ref [CPU s]": "cpu_s",
        "ARCSim, recorded [CPU s]": "arcsim_cpu_s",
        "ratio (0.1)": lambda row: _met(row["cpu_ratio"], 0.1),
        "objective over ARCSim's": "objective_ratio",
        "status": "status",
        "runs": "repeats",
    }
    if not lines:
        return "## Whole steps\n\nNot measured yet."
    free = [row["objective_ratio"] for row in lines if row["objective_ratio"] is not None]
    cpu = float(np.exp(np.mean([np.log(row["cpu_ratio"]) for row in lines])))
    objective = float(np.exp(np.mean(np.log(free))))
    return (
        "## Whole steps\n\nOne thread. ARCSim 0.2.1's CPU time was recorded before, on a machine "
        "of the same kind, not in this run; where it moved an obstacle its objective is of "
        f"another problem. Geometric means: CPU {cpu:.3g}, objective {_met(objective, 0.985)} "
        "(0.985).\n\n" + table(columns, lines)
    )


def _threads(detection, whole):
    lines = []
    for what, rows in (("detection", detection), ("whole step", whole)):
        own = [row for row in rows if row.get("what", OWN) == OWN]
        times = {(row["step"], row["threads"]): row["median_s"] for row in own}
        for step in dict.fromkeys(row["step"] for row in own):
            if (step, 1) in times and (step, 2) in times:
                lines.append({"step": step, "what": what, "gain": times[step, 1] / times[step, 2]})
    if not lines:
        return "## Two threads\n\nNot measured yet."
    columns = {"step": "step", "what": "what", "two threads are faster by": "gain"}
    return "## Two threads\n\nWanted: 1.7 on steps above 50k triangles.\n\n" + table(columns, lines)


def _stages(rows):
    columns = {
        "step": "step",
        "threads": "threads",
        "whole [s]": "median_s",
        "main loop": "main_s",
        "re-linearising": "relinearize_s",
        "scaling back": "scale_back_s",
        "certifying": "certify_s",
        "judging": "judge_s",
        "of the loops: detecting": "detect_s",
        "solving": "solve_s",
        "detections": "iterations",
    }
    return "## Where the time goes\n\n" + (table(columns, rows) if rows else "Not measured yet.")


def _ablation(rows, steps):
    if not rows:
        return "## What each rule saves\n\nNot measured yet."
    names = list(dict.fromkeys(row["left_out"] for row in rows))
    by_key = {(row["step"], row["left_out"]): row for row in rows}
    found = list(dict.fromkeys(row["step"] for row in rows))

    def cells(column):
        return [{"step": step} | {n: by_key[step, n][column] for n in names} for step in found]

    columns = {"step": "step"} | {name: name for name in names}
    missing = [step for step in dict.fromkeys(steps) if step not in found]
    return (
        "## What each rule saves\n\nEach rule switched off on its own, then all of them; the "
        "answer is the same, bit for bit but for `closed-form`. Time over that with all rules "
        f"(runs each: {min(r['repeats'] for r in rows)} to {max(r['repeats'] for r in rows)}; "
        "the first column is 1 by definition, and a few hundredths are noise):\n\n"
        + table(columns, cells("ratio"))
        + "\nPeak of the arrays that Python allocates [MiB]:\n\n"
        + table(columns, cells("arrays_mib"))
        + "\nPairs looked at in all detections:\n\n"
        + table(columns, cells("pairs"))
        + "".join(f"\nNot measured yet: {step}.\n" for step in missing)
    )


def _cold(rows):
    columns = {"what": "what", "median [s]": "median_s", "least": "least_s", "runs": "repeats"}
    return (
        "## Cold start\n\nNew processes, bytecode on the disk. Wanted: 0.3 s above an empty "
        "Python for the import, 20 s for the first step, 1.5 s for one after it.\n\n"
        + (table(columns, rows) if rows else "Not measured yet.")
    )


def _scale(rows):
    done = [row for row in rows if row["outcome"] != "failed"]
    lines = [
        row
        | {
            "with_door_s": row["total_s"] + row["door_s"],
            "memory_mib": row["peak_mib"] - row["import_mib"],
            "kb_a_triangle": (row["peak_mib"] - row["import_mib"]) * 1048.576 / row["triangles"],
        }
        for row in done
    ]
    if not lines:
        return "## Size\n\nNot measured yet."
    fits = []
    for count in dict.fromkeys(row["threads"] for row in lines):
        own = [row for row in lines if row["threads"] == count]
        slope = np.polyfit(
            np.log([r["triangles"] for r in own]), np.log([r["total_s"] for r in own]), 1
        )[0]
        fits.append(f"{_met(float(slope), 1.1)} on {count} threads")
    columns = {
        "triangles": "triangles",
        "threads": "threads",
        "resolved and certified [s]": "total_s",
        "with checking the start": "with_door_s",
        "memory above the import [MiB]": "memory_mib",
        "kB a triangle": "kb_a_triangle",
        "outcome": "outcome",
    }
    return (
        "## Size\n\nTwo sheets that meet in a hundredth of their vertices. Wanted: a million "
        "triangles in 60 s and 3 GB, an exponent of 1.1, 1.5 kB a triangle. Exponent of time "
        f"over all sizes (1.1): {', '.join(fits)}.\n\n" + table(columns, lines)
    )


NOTES = """## What was tried and did not help

* One box a block of queries on the way down, then each query against the leaves of a block,
  gained 1.6 times over one query at a time; putting the comparison of eight boxes where it is
  called, 1.5 times more (a call took longer than the comparison).
* The four diagonals of the cube as further directions: 5 % of the proofs' time at most, and
  that only on cloth-ball-clean.
* A test without branches for shared vertices, and `forceinline` for the small vectors: nothing.
* Reach without a bound (see `FAR_REACH`): what is near everything is looked at each time.
* Large zones from their last solution (`solvers/pivoting.py`): solving takes 0.55 of the time on
  armadillo-rollers, 0.59 on stack-6k, 0.63 on sheets-50k, 0.85 on sheets-10k (once each, one
  thread). On cloth-ball-clean it gains nothing: a fifth of its zones,
  with one redundant row of ten, have rows that change sides for ever, and the tries cost what
  the others gain. Against that: from 1e-4 to 1e-10 for rho (49, 30 and 48 given up of 191, least
  at 1e-9); all rows that pull first, then all that are missing (46); the worse half of them
  (32, of steps that take longer); Newton's method projected, with a search for descent, from
  the start or where rows stop to get fewer (more than 100).
* In the rounds with new normals, the impacts that did not hold kept as they were, or with new
  normals: fewer iterations and larger zones, 1.4 and 1.16 times the time on armadillo-rollers,
  the others within 10 %. The objective there is 12 % and 1 % lower, elsewhere the same to 0.1 %.
* Directions for pairs whose proof takes two steps (a quarter of a detection's time): between
  the middles of the sides, or of closest points at half time; they settle 10 to 25 % of them.
* Compiling the helpers of a kernel at -O0 or -O1: 73 and 65 s instead of 63, for more is left
  to the kernel.
"""

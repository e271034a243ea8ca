"""The page of a GPU, from the rows of `study/cuda.py`."""

from collections.abc import Iterable
from pathlib import Path

from validation.report.catalogue import Headline
from validation.report.cuda_bounds import (
    bounds_section,
    counts_section,
    goal_ms,
    kernels_section,
)
from validation.report.tables import NOT_MEASURED, run_table, table, write_page
from validation.rows import Columns, Row, read, runs_of
from validation.study.gpu_counts import Counts
from validation.study.gpu_launches import counted_typical, typical_host_ms

PARTS = (
    *("kernels", "counts", "counts_before", "sizes", "zone_sizes", "filter", "filter_kernels"),
    *("check", "cut", "detection", "blocks", "zones", "steps", "memory"),
)
FILTER: Columns = {
    "step": "step",
    "path to the": "path",
    "pairs": "pairs",
    "contacts": "contacts",
    "settled": "settled",
    "settled, of those apart": "settled_of_apart",
    "contacts that are settled": "missed",
    "groups of 32 with a pair left open": "groups_left_open",
    "detection, CPU without filter [ms]": "cpu_ms",
    "CPU with filter [ms]": "cpu_filtered_ms",
    "with / without": "ratio",
    "load": "load",
}
FILTER_KERNELS: Columns = {
    "kernel": "kernel",
    "compute capability": "capability",
    "float32 instructions": "f32",
    "float64 instructions": "f64",
    "registers": "registers",
}
DETECTION: Columns = {
    "step": "step",
    "GPU": "gpu",
    "triangles": "triangles",
    "impacts": "impacts",
    "pairs of the GPU only": "only_gpu",
    "pairs of the CPU only": "only_cpu",
    "largest difference of times": "toi_difference",
    "of normals": "normal_difference",
    "GPU [ms]": "gpu_ms",
    "lower bound [ms]": "floor_ms",
    "CPU [ms]": "cpu_ms",
    "CPU / GPU": "ratio",
    "SCCD, published [ms]": lambda row: SCCD_MS.get(row["step"]),
}
BLOCKS: Columns = {
    "zone": "zone",
    "impacts": "impacts",
    "active": "active",
    "GPU": "gpu",
    "threads": "threads",
    "shared [KiB]": "shared_kib",
    "solved": "solved",
    "solves": "solves",
    "relative gap": "gap",
    "violation / thickness": "violation",
    "one zone [ms]": "one_ms",
    "100 zones [ms]": "many_ms",
    "one zone by one thread [ms]": "thread_ms",
    "one zone by all blocks [ms]": "all_ms",
    "solved by all blocks": "solved_by_all",
    "all copies end alike": "all_same",
    "CPU, one zone [ms]": "cpu_ms",
    "CPU / all blocks": "ratio",
}
ZONES: Columns = {
    "impacts": "impacts",
    "GPU": "gpu",
    "steps": "steps",
    "relative gap": "gap",
    "violation / thickness": "violation",
    "kernel [ms]": "kernel_ms",
    "CPU, default [ms]": "cpu_ms",
    "CPU / kernel": "ratio",
}
STEPS: Columns = {
    "step": "step",
    "GPU": "gpu",
    "triangles": "triangles",
    "status": "status",
    "status on the CPU": "cpu_status",
    "objective / CPU's": "objective",
    "largest distance of positions [m]": "apart_m",
    "same bits in a second run": "same_again",
    "zones solved": "solved",
    "left to the CPU": "left",
    "iterations": "iterations",
    "iterations on the CPU": "cpu_iterations",
    "lower bound [ms]": "floor_ms",
    "goal [ms]": lambda row: goal_ms(row["triangles"]),
    "loop [ms]": "loop_ms",
    "certificate [ms]": "certify_ms",
    "whole [ms]": "gpu_ms",
    "CPU [ms]": "cpu_ms",
    "CPU / GPU": "ratio",
    "I-Cloth, published [ms]": lambda row: (
        ICLOTH_MS if row["triangles"] in ICLOTH_TRIANGLES else None
    ),
}
CHECK: Columns = {"case": "case", "GPU": "gpu", "time [s]": "seconds"}
CUT: Columns = {
    "part": "part",
    "first case that was left out": "first_left_out",
    "after [s]": "spent_s",
}
MEMORY: Columns = {"tool": "tool", "GPU": "gpu", "passed": "passed", "it says": "said"}
INTRO = (
    "Measured by `python -m validation study cuda`. ptxas says what each kernel needs, which takes "
    "no GPU. The times of kernels and of detection on a GPU are measured with its events, those of "
    "whole steps with the clock. Each time is the median of five runs, after one run that does not "
    "count."
)
LOWER_BOUND = (
    "The lower bound is the time to move once all data that have to be moved, at the rate of a "
    "copy within the memory of the GPU."
)
FILTER_INTRO = (
    "A pair is settled if float32 proves that it stays apart. All others are decided in float64, "
    "by a launch of their own. The pairs are counted on the CPU, for the path to the proposed "
    "positions and for that to the answer, whose pairs are those of the last detection. The times "
    "are CPU times of all threads, medians of five, with and without the filter in turn, while the "
    "machine had the load beside it. Only a GPU uses the filter. Instructions are counted in the "
    "PTX; one in a loop counts once."
)
BLOCKS_INTRO = (
    "The times are those of the launch. This table is what the constants of "
    "`izo_ref/solvers/gpu_pivoting.py` are to be chosen from, and `SMALL` of `gpu_solve.py`."
)
# M. Tang et al. (2018), table of benchmarks: GTX 1080, float32
ICLOTH = (
    "For comparison, I-Cloth's published figures, on a GTX 1080 in float32, are 66 to 654 ms for "
    "the collision handling of a step with 90 to 215 thousand triangles, and 2.86 ms for the zones "
    "of a frame."
)
STEPS_BOUND = (
    "The lower bound of a step is that of its iterations, as in the section on lower bounds, at "
    "the rate of a copy within the memory of the GPU."
)
CHECK_INTRO = (
    "Arrays, programs, detections, certificates, whole steps with every selection, plan, method "
    "and preset, and zones are compared with numpy and with the CPU. The study ends at the first "
    "difference, so all cases in this table agree."
)
CUT_INTRO = "These parts used up their time. What they left out was not measured."
# zulianp/sccd, README of its repository (November 2026): median time of a case, which has the
# vertex-face or the edge-edge pairs of one frame, for two cases
SCCD_MS = {
    "armadillo-rollers": 2 * 6.7,
    "cloth-ball-clean": 2 * 18.5,
    "cloth-funnel-clean": 2 * 4.6,
}
SCCD = (
    "SCCD's published figures are for the public scene of the same name on a GH200: twice the "
    "median of a case, because a frame has two cases. It looks at every pair; the steps here are "
    "single frames of these scenes, from which intersecting faces were removed."
)
# triangles of the steps of I-Cloth's figures
ICLOTH_TRIANGLES = range(90_000, 215_001)
ICLOTH_MS = "66 to 654"


def page(rows_folder: Path, output: Path) -> Path:
    """Write `README.md`.

    Args:
        rows_folder: Folder of the CSV files, one for each of PARTS.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    rows = {name: read(rows_folder, name) for name in PARTS}
    now, before = (counted_typical(rows_folder, name) for name in ("counts", "counts_before"))
    made = runs_of(rows_folder, (row for part in rows.values() for row in part))
    sections = (
        "# On a GPU",
        INTRO,
        run_table(made),
        "## Small cases: whether a GPU finds what the CPU finds",
        CHECK_INTRO,
        _measured(CHECK, rows["check"]),
        *(["## What was cut off", CUT_INTRO, table(CUT, rows["cut"])] if rows["cut"] else []),
        "## Detection: whether a GPU finds the same impacts, and how long it takes",
        LOWER_BOUND,
        SCCD,
        _measured(DETECTION, rows["detection"]),
        "## Float32 filter: how many pairs need no float64",
        FILTER_INTRO,
        _measured(FILTER, rows["filter"], "cpu_ms", "cpu_filtered_ms"),
        _measured(FILTER_KERNELS, rows["filter_kernels"]),
        "## Zones of the loop: block pivoting by one block a zone, and by all blocks",
        BLOCKS_INTRO,
        _measured(BLOCKS, rows["blocks"], "all_ms"),
        "## Zones by the semismooth Newton method: one zone in a call",
        "The loop uses this method if it is asked for by name. Zones of up to 4096 impacts are "
        "solved by one block of threads, larger ones by all blocks.",
        _measured(ZONES, rows["zones"], "kernel_ms"),
        "## Whole steps",
        ICLOTH,
        STEPS_BOUND,
        _measured(STEPS, rows["steps"]),
        "## Memory: `compute-sanitizer` on a small step",
        _measured(MEMORY, rows["memory"]),
        *counts_section(before, now, None if now is None else typical_host_ms(rows_folder)),
        *bounds_section(rows["sizes"], rows["zone_sizes"], now),
        *kernels_section(rows["kernels"]),
    )
    return write_page(output / "README.md", sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    found = []
    kernels = read(rows_folder, "kernels")
    if kernels:
        names = {row["kernel"] for row in kernels}
        spilled = {row["kernel"] for row in kernels if row["stack_bytes"] or row["spilled_bytes"]}
        capabilities = ", ".join(sorted({row["capability"] for row in kernels}, key=float))
        others = f"; the other is `{', '.join(sorted(spilled))}`" if spilled else ""
        found.append(
            Headline(
                "Kernels without a stack frame or spilled registers",
                f"{len(names) - len(spilled)} of {len(names)}",
                f"ptxas says so for the compute capabilities {capabilities}{others}.",
            )
        )
    found += _detection(read(rows_folder, "detection"))
    steps = read(rows_folder, "steps")
    if steps:
        ratios = [row["cpu_ms"] / row["gpu_ms"] for row in steps]
        figure = f"{min(ratios):.2g} to {max(ratios):.2g} times as fast"
        gpus = ", ".join(dict.fromkeys(row["gpu"] for row in steps))
        found.append(
            Headline(
                "Whole steps on a GPU", figure, f"{len(steps)} steps on {gpus}, next to the CPU."
            )
        )
    else:
        found += _launches(counted_typical(rows_folder))
    return found


def _detection(rows: list[Row]) -> Iterable[Headline]:
    """Yield the headline of the detection of the largest step."""
    if rows:
        last = max(rows, key=lambda row: row["triangles"])
        others = sum(row["only_gpu"] + row["only_cpu"] for row in rows)
        ratio = last["cpu_ms"] / last["gpu_ms"]
        yield Headline(
            "Detection on a GPU",
            f"{last['gpu_ms']:.2g} ms",
            f"{last['triangles']:,} triangles on {last['gpu']}; {ratio:.2g} times as fast as the "
            f"CPU beside it. In {len(rows)} steps, {others} pairs differ from those of the CPU.",
        )


def _launches(counts: Counts | None) -> Iterable[Headline]:
    """Yield the headline of a study that has not measured whole steps on a GPU yet."""
    if counts is not None:
        yield Headline(
            "Launches of an iteration on a GPU",
            f"{counts.launches + counts.programs:,}",
            f"With {counts.kernels} kernels, {counts.arrays} new arrays and {counts.reads} reads "
            "of the host, counted without a GPU. Whole steps on a GPU are not measured yet.",
        )


def _measured(
    columns: Columns, rows: list[Row], own_ms: str = "gpu_ms", other_ms: str = "cpu_ms"
) -> str:
    """Return the table of a part, with the ratio of two times: by default CPU over GPU."""
    lines = [row | {"ratio": _over(row.get(other_ms), row.get(own_ms))} for row in rows]
    return table(columns, lines) if lines else NOT_MEASURED


def _over(value: float | None, other: float | None) -> float | None:
    return value / other if value is not None and other else None

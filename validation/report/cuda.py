"""Rows of `study.cuda` to `reports/cuda/README.md`."""

from validation.ptx import FRAMES
from validation.report.tables import table, write
from validation.rows import read, runs

KERNELS = {
    "kernel": "kernel",
    "types": "types",
    "compute capability": "capability",
    "registers": "registers",
    "fixed shared [B]": "shared_bytes",
    "stack [B]": "stack_bytes",
    "spilled [B]": "spilled_bytes",
}
DETECTION = {
    "step": "step",
    "GPU": "gpu",
    "triangles": "triangles",
    "impacts": "impacts",
    "pairs only the GPU has": "only_gpu",
    "only the CPU": "only_cpu",
    "largest difference of times": "toi_difference",
    "of normals": "normal_difference",
    "GPU [ms]": "gpu_ms",
    "floor [ms]": "floor_ms",
    "CPU [ms]": "cpu_ms",
    "CPU / GPU": "ratio",
}
ZONES = {
    "impacts": "impacts",
    "GPU": "gpu",
    "steps": "steps",
    "relative gap": "gap",
    "violation / thickness": "violation",
    "kernel [ms]": "kernel_ms",
    "CPU, default [ms]": "cpu_ms",
    "CPU / kernel": "ratio",
}
STEPS = {
    "step": "step",
    "GPU": "gpu",
    "triangles": "triangles",
    "status": "status",
    "of the CPU": "cpu_status",
    "objective / CPU's": "objective",
    "farthest apart [m]": "apart_m",
    "same bits again": "same_again",
    "zones solved": "solved",
    "by the CPU": "left",
    "iterations": "iterations",
    "of the CPU ": "cpu_iterations",
    "loop [ms]": "loop_ms",
    "certificate [ms]": "certify_ms",
    "whole [ms]": "gpu_ms",
    "CPU [ms]": "cpu_ms",
    "CPU / GPU": "ratio",
}
LAUNCHES = {
    "triangles": "triangles",
    "GPU": "gpu",
    "iterations": "iterations",
    "launches": "launches",
    "arrays": "arrays",
}
MEMORY = {"tool": "tool", "GPU": "gpu", "passed": "passed", "it says": "said"}
NOT_YET = "Not measured yet."
# M. Tang et al. (2018), table of benchmarks: GTX 1080, float32
ICLOTH = (
    "I-Cloth's published figures, of a GTX 1080 in float32: 66 to 654 ms for the collision "
    "handling of a step of 90 to 215 thousand triangles; 2.86 ms for the zones of a frame."
)


def cuda_report(folder, command):
    """Write the page.

    Args:
        folder: `Path`, of the page; rows are in `rows/` there.
        command: that made it.
    """
    names = ("kernels", "detection", "zones", "steps", "launches", "memory")
    rows = {name: read(folder / "rows", name) for name in names}
    used = {row["run"] for part in rows.values() for row in part}
    made = [run for run in runs(folder / "rows") if run["run"] in used]

    def measured(columns, name, kernel="gpu_ms"):
        own = [row | {"ratio": _over(row.get("cpu_ms"), row.get(kernel))} for row in rows[name]]
        return table(columns, own) if own else NOT_YET

    parts = [
        "# On a GPU",
        f"Made by `{command}`. What a kernel takes is what ptxas says, which needs no GPU. Times "
        "on a GPU are of device events, and of whole steps by the clock; medians of five runs "
        "after one that does not count.",
        table({"run": "run", "commit": "commit", "machine": "machine", "begun": "started"}, made),
        "## Detection: the same impacts, and how long it takes\n\nThe floor is what it takes to "
        "move once what cannot be left out, at the rate of a copy on the device itself.\n\n"
        + measured(DETECTION, "detection"),
        "## Zones: one alone, by the semismooth Newton method; up to 4096 impacts by one block\n\n"
        + measured(ZONES, "zones", "kernel_ms"),
        f"## Whole steps\n\n{ICLOTH}\n\n" + measured(STEPS, "steps"),
        "## Launches of whole steps, and arrays made\n\nOf meeting sheets; with more of them trees "
        "have more levels, and sorts more passes. The simulator counts them too: `--only launches` "
        "with `NUMBA_ENABLE_CUDASIM=1 NUMBA_DISABLE_JIT=1`.\n\n" + measured(LAUNCHES, "launches"),
        "## Memory: `compute-sanitizer` on a small step\n\n" + measured(MEMORY, "memory"),
        "## Kernels\n\n" + measured(KERNELS, "kernels"),
        *(f"`{kernel}` has a stack frame: {reason}." for kernel, reason in FRAMES.items()),
    ]
    write(folder / "README.md", "\n\n".join(part.strip() for part in parts) + "\n")


def _over(value, other):
    return value / other if value is not None and other else None

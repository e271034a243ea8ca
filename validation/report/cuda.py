"""Rows of `study.cuda` to `reports/cuda/README.md`."""

from validation.report.tables import table, write
from validation.rows import read, runs

KERNELS = {
    "kernel": "kernel",
    "types": "types",
    "compute capability": "capability",
    "registers": "registers",
    "shared [B]": "shared_bytes",
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
    "CPU [ms]": "cpu_ms",
    "CPU / GPU": "ratio",
}


def cuda_report(folder, command):
    """Write the page.

    Args:
        folder: `Path`, of the page; rows are in `rows/` there.
        command: that made it.
    """
    kernels, detection = (read(folder / "rows", name) for name in ("kernels", "detection"))
    used = {row["run"] for row in kernels + detection}
    made = [run for run in runs(folder / "rows") if run["run"] in used]
    detection = [row | {"ratio": row["cpu_ms"] / row["gpu_ms"]} for row in detection]
    parts = [
        "# On a GPU",
        f"Made by `{command}`. What a kernel takes is what ptxas says, which needs no GPU. Times "
        "on a GPU are of device events, medians of five runs after one that does not count.",
        table({"run": "run", "commit": "commit", "machine": "machine", "begun": "started"}, made),
        "## Detection: the same impacts, and how long it takes\n\n"
        + (table(DETECTION, detection) if detection else "Not measured yet."),
        "## Kernels\n\n" + (table(KERNELS, kernels) if kernels else "Not measured yet."),
    ]
    write(folder / "README.md", "\n\n".join(part.strip() for part in parts) + "\n")

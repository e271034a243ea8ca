"""Rows to Markdown, with what they were measured on. The only writer of reports."""

import math
import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path

from izo_ref.app.files import replacing, save_json

ROOT = Path(__file__).parent.parent.parent
PACKAGES = (
    "numba",
    "numpy",
    "scipy",
    "ipctk",
    "python-fcl",
    "python-flint",
    "qpsolvers",
    "piqp",
    "clarabel",
    "osqp",
    "proxsuite",
    "daqp",
    "matplotlib",
)


def header(title, command) -> str:
    """The first lines of a report: title, command, commit, machine, versions."""
    lines = (
        f"# {title}",
        "",
        f"Made by `{command}` from commit {commit()} on {machine()}, {versions()}. Times are "
        "wall-clock seconds of that machine, which other work may have shared; compile time is "
        "not in them.",
        "",
    )
    return "\n".join(lines)


def versions() -> str:
    """Python and the packages that answers and times depend on."""
    found = [f"Python {platform.python_version()}"]
    for name in PACKAGES:
        try:
            found.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            found.append(f"no {name}")
    return ", ".join(found)


def commit() -> str:
    """The commit that is checked out, and whether something of it was changed."""

    def git(*arguments):
        run = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
        return run.stdout.strip() if run.returncode == 0 else ""

    head = git("rev-parse", "--short=12", "HEAD")
    changed = git("status", "--porcelain", "--untracked-files=no", "--", "izo_ref", "validation")
    return (head or "unknown") + (" with changes" if changed else "")


def machine() -> str:
    """Cores, processor and system."""
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{os.cpu_count()} cores of {model}, {platform.system()}"


def table(columns, rows) -> str:
    """A Markdown table.

    Args:
        columns: {heading: function of a row, or key}.
        rows: dictionaries.
    """
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    for row in rows:
        cells = [row.get(c) if isinstance(c, str) else c(row) for c in columns.values()]
        lines.append("| " + " | ".join(text(cell) for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def text(value) -> str:
    """A cell: numbers with the digits that matter."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        if math.isinf(value):
            return "none"
        if value == 0.0 or 1e-3 <= abs(value) < 1e5:
            return f"{value:.4g}"
        return f"{value:.1e}"
    if isinstance(value, int):
        return f"{value:,}"
    return str(value).replace("|", "/")


def write(path, content, rows=None):
    """Write a report, and beside it its rows as JSON."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write(content.encode())
    if rows is not None:
        save_json(path.with_suffix(".json"), rows)

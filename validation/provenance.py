"""What a measurement was taken on: the commit, the machine, the versions."""

import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Packages that answers and times depend on.
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

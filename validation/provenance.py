"""What a measurement was taken on: the commit, the machine and the versions of packages."""

import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
# Packages that answers and times depend on.
PACKAGES = (
    "numba",
    "numba-cuda",
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


class Made(NamedTuple):
    """What made some rows: a command, and the commit, machine and versions that it ran on."""

    command: str
    commit: str
    machine: str
    versions: str


def made_by(command: str) -> Made:
    """Return what rows are made by, if this command measures them now and here."""
    return Made(command, commit(), machine(), versions())


def versions() -> str:
    """Return the versions of Python and of the packages that answers and times depend on."""
    found = [f"Python {platform.python_version()}"]
    for name in PACKAGES:
        try:
            found.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            found.append(f"no {name}")
    return ", ".join(found)


def commit() -> str:
    """Return the commit that is checked out, and whether the sources differ from it."""
    head = _git("rev-parse", "--short=12", "HEAD")
    changed = _git("status", "--porcelain", "--untracked-files=no", "--", "izo_ref", "validation")
    return (head or "unknown") + (" with changes" if changed else "")


def _git(*arguments: str) -> str:
    """Return what a git command prints; an empty string if it fails."""
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


def machine() -> str:
    """Return the number of cores, the model of the CPU and the operating system."""
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{os.cpu_count()} cores of {model}, {platform.system()}"

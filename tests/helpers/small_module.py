"""A module with two small compiled functions, which runs in processes of its own."""

import os
import subprocess
import sys
from pathlib import Path

import izo_ref

PACKAGE = Path(izo_ref.__file__).parent

SOURCE = """
import sys
import numpy as np
from izo_ref.base.compile import compiled

@compiled
def twice(x):
    return x + x

@compiled
def total(numbers):
    sum = 0.0
    for number in numbers:
        sum += twice(number)
    return sum

print(total(np.arange(4.0)), twice(3))
print(sum(f.stats.cache_hits[s] for f in (total, twice) for s in f.stats.cache_hits))
"""
RIGHT = ["12.0", "6"]


def command(folder):
    """Write the module into a folder; return the command that runs it."""
    (folder / "small.py").write_text(SOURCE)
    return [sys.executable, str(folder / "small.py")]


def environment(cache):
    """Return the variables with which compiled code is kept in a folder."""
    return os.environ | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(PACKAGE.parent)}


def run(folder, cache, **more):
    """Run the module; return what it printed, the number of loaded functions, and its errors."""
    done = subprocess.run(
        command(folder), env=environment(cache), capture_output=True, text=True, **more
    )
    assert done.returncode == 0, done.stderr
    *said, loaded = done.stdout.split()
    return said, int(loaded), done.stderr

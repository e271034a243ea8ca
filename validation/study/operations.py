"""Count the operations in float64 of the proofs of a detection, by running their text as Python.

The pairs are proved with numbers that note what is done with them. Sums, differences, products,
quotients and roots count as one operation each; signs, absolute values and comparisons count as
none. So the time that follows from the published rate of a GPU is a lower bound.
"""

import json
import math
import os
import subprocess
import sys
from types import SimpleNamespace
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from validation.provenance import ROOT
from validation.scenes.sheets import meeting_sheets

TRIANGLES = (
    10_000  # of the sheets whose pairs are proved; a larger sheet has pairs of the same kind
)
SEED = 20261128
LIMIT_S = 240.0


class Operations(NamedTuple):
    """Operations of the proofs of some pairs."""

    pairs: int
    operations: int  # in float64, of all these pairs
    most: int  # of the pair that took most

    @property
    def each(self) -> float:
        """Operations of a pair, on average."""
        return self.operations / self.pairs


class Number(float):
    """A float that counts what is done with it; so do its results."""

    count = 0

    def __add__(self, other: Any) -> "Number":
        """Count a sum."""
        return _counted(float.__add__(self, other))

    def __sub__(self, other: Any) -> "Number":
        """Count a difference."""
        return _counted(float.__sub__(self, other))

    def __rsub__(self, other: Any) -> "Number":
        """Count a difference."""
        return _counted(float.__rsub__(self, other))

    def __mul__(self, other: Any) -> "Number":
        """Count a product."""
        return _counted(float.__mul__(self, other))

    def __truediv__(self, other: Any) -> "Number":
        """Count a quotient."""
        return _counted(float.__truediv__(self, other))

    def __rtruediv__(self, other: Any) -> "Number":
        """Count a quotient."""
        return _counted(float.__rtruediv__(self, other))

    def __neg__(self) -> "Number":
        """Change the sign."""
        return Number(float.__neg__(self))

    def __abs__(self) -> "Number":
        """Drop the sign."""
        return Number(float.__abs__(self))

    __radd__, __rmul__ = __add__, __mul__


def _counted(value: float) -> Number:
    Number.count += 1
    return Number(value)


# the functions of `math` that the formulas call
MATH = SimpleNamespace(
    sqrt=lambda value: _counted(math.sqrt(value)), frexp=math.frexp, ldexp=math.ldexp
)


def operations_of_proofs(n_triangles: int) -> Operations:
    """Count the operations of the first detection of sheets that meet.

    This process must run compiled functions as Python: `NUMBA_DISABLE_JIT=1`.
    """
    from izo_ref.base.formulas import vec3
    from izo_ref.detection.find import find_impacts
    from izo_ref.detection.serial import contacts

    prove, counts = contacts.advance, []

    def counted(is_edge_edge: bool, *points: Any) -> Any:
        before = Number.count
        own: list[Any] = [tuple(map(Number, map(float, point))) for point in points]
        status, toi, direction, steps, margin = prove(is_edge_edge, *own)
        counts.append(Number.count - before)
        return status, float(toi), tuple(map(float, direction)), steps, float(margin)

    scene = meeting_sheets(np.random.default_rng([SEED, n_triangles]), n_triangles)
    with patch.object(contacts, "advance", counted), patch.object(vec3, "math", MATH):
        find_impacts(scene)
    return Operations(len(counts), sum(counts), max(counts))


def measured_operations(n_triangles: int = TRIANGLES) -> Operations:
    """Count in a process of its own, in which compiled functions are Python."""
    more = {"NUMBA_DISABLE_JIT": "1", "NUMBA_ENABLE_CUDASIM": "0"}
    paths = {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", __spec__.name, str(n_triangles)]
    done = subprocess.run(
        command,
        env=os.environ | more | paths,
        check=True,
        timeout=LIMIT_S,
        stdout=subprocess.PIPE,
        text=True,
    )
    return Operations(*json.loads(done.stdout))


if __name__ == "__main__":
    print(json.dumps(operations_of_proofs(int(sys.argv[1]))))

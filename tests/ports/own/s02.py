"""Stage S2 by our own functions."""

from typing import Any

import numpy as np

from izo_ref.base.arrays import Vec3
from izo_ref.detection.formulas.advance import APART, advance


def relative(points: list[float]) -> list[Vec3]:
    """Return nodes 1 to 3 relative to node 0, from flat coordinates."""
    p = np.array(points, np.float64).reshape(4, 3)
    return [tuple(row) for row in p[1:] - p[0]]


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return whether a pair meets, and when."""
    if dtype != "f8":
        raise NotImplementedError("only float64")
    start, end = relative(inputs["start"]), relative(inputs["end"])
    with np.errstate(all="ignore"):  # compiled code does not warn, either
        status, toi, *_ = advance(bool(inputs["is_edge_edge"]), *start, *end)
    return {"meets": 0} if status == APART else {"meets": 1, "toi": float(toi)}

"""Our own path of `numba.cuda` as a port of stages S5, S11 and S12.

    izo conform --exec "python -m tests.ports.own_cuda"

Without a GPU, NUMBA_ENABLE_CUDASIM=1 NUMBA_DISABLE_JIT=1 runs the kernels in Python. That is slow,
so only tiny cases end in time: `is_tiny` says which.
"""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from izo_ref import solve_zone
from tests.helpers.gpu_groups import grouped
from tests.ports.own import s11, s12
from tests.ports.serve import serve
from validation.ladders.zone_arrays import problem_of

VIOLATION = 1e-6  # of the thickness
TINY = {"S5": 400, "S11": 60, "S12": 20}  # numbers in the largest input


def is_tiny(stage: str, inputs: Mapping[str, Any]) -> bool:
    """Return whether the simulator ends a case in a few seconds."""
    return max(len(v) for v in inputs.values() if isinstance(v, list)) <= TINY[stage]


def zones(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the zone of each impact."""
    nodes = np.array(inputs["nodes"], np.int32).reshape(-1, 4)
    pinned = np.array(inputs["pinned"], bool)
    order, offsets, *_ = grouped(nodes, pinned, np.zeros(len(pinned), bool)).zones
    zone_of_impact = np.full(len(nodes), -1)
    zone_of_impact[order] = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    return {"zone_of_impact": zone_of_impact.tolist()}


def optimum(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the optimum of a zone by Newton's method of the augmented Lagrangian.

    The method does not prove that a zone is infeasible; it ends with a violation.
    """
    if dtype != "f8":
        raise NotImplementedError("zones are solved to the end in float64")
    found = solve_zone(problem_of(inputs), device="cuda")
    return s11.reply_of(found, found.residuals.feasible(VIOLATION))


def step(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the end positions of a step that a GPU resolved."""
    return s12.answer(inputs, dtype, device="cuda")


ANSWERS = {"S5": zones, "S11": optimum, "S12": step}

if __name__ == "__main__":
    if os.environ.get("NUMBA_ENABLE_CUDASIM", "0") != "0":
        from validation.simulator import prepare

        prepare()
    serve("izo_ref-cuda", ANSWERS)

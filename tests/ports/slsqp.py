"""SciPy's SLSQP as a port of stage S11 alone.

    izo conform --exec "python -m tests.ports.slsqp"

It solves the scaled form of `validation/oracles/slsqp.py` and gives no multipliers. For a quarter
of the zones SLSQP reports no success although its answer is right: it finds no better step, and
does not know why. So a zone counts as infeasible only if the answer violates a constraint.
"""

from typing import Any

from tests.ports.serve import serve
from validation.ladders.zone_arrays import problem_of
from validation.oracles.slsqp import solve_scaled

VIOLATION = 1e-6  # of the thickness


def with_unpinned(inputs: dict[str, Any]) -> dict[str, Any]:
    """Return a zone without the impacts whose vertices are all pinned: their rows are zero."""
    nodes, pinned = inputs["nodes"], inputs["pinned"]
    kept = [
        j for j in range(len(nodes) // 4) if not all(pinned[v] for v in nodes[4 * j : 4 * j + 4])
    ]
    columns = {"nodes": 4, "weights": 4, "normals": 3}
    parts = {
        name: [x for j in kept for x in inputs[name][n * j : n * j + n]]
        for name, n in columns.items()
    }
    return {**inputs, **parts}


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the optimum of a zone as SLSQP finds it."""
    if dtype != "f8":
        raise NotImplementedError("SciPy computes in float64")
    problem = problem_of(inputs)
    if (problem.gaps(problem.proposed) >= 0.0).all():
        return {"feasible": 1, "positions": list(inputs["proposed"])}
    movable = with_unpinned(inputs)
    if not movable["nodes"]:
        return {"feasible": 0}
    found = solve_scaled(problem_of(movable))
    positions = problem.proposed + found.displacements
    if problem.gaps(positions).min() < -VIOLATION * problem.thickness:
        return {"feasible": 0}
    return {"feasible": 1, "positions": positions.ravel().tolist()}


if __name__ == "__main__":
    serve("scipy-slsqp", {"S11": answer})

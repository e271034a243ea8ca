"""The optimum of a zone by SciPy's SLSQP, once in metres and kilograms and once scaled.

Question: which positions are closest to the proposed ones and satisfy the constraints of the zone?

Method: sequential quadratic programming, SciPy's SLSQP. `solve_raw` states the problem as most
users would write it; `solve_scaled` states the same problem in numbers near 1.

Independent of `izo_ref`: both forms are written from the mathematics, and the solver is SciPy's.

Limits: only the scaled form is right when masses differ by decades; the raw form shows what goes
wrong without scaling. SLSQP factorises all constraints in each iteration, so it suits zones of up
to about 64 impacts.
"""

import time

import numpy as np

from validation.oracles.answer import Answer, Floats, ZoneArrays, scaled_zone


def solve_raw(
    problem: ZoneArrays, ftol: float = 1e-12, gradients: bool = False, max_iterations: int = 1000
) -> Answer:
    """Solve a zone in metres and kilograms.

    The objective is sum m |x - y|^2 / sum m, and the constraints are unscaled gaps in metres.

    Args:
        problem: A zone problem.
        ftol: Tolerance of SLSQP for the objective.
        gradients: Pass the gradient of the objective to SLSQP. Without it SLSQP takes finite
            differences, as it does for most users.
        max_iterations: Limit of iterations.

    Returns:
        The answer, without multipliers.
    """
    from scipy.optimize import minimize

    begin = time.perf_counter()
    unpinned = np.flatnonzero(np.isfinite(problem.masses))
    masses = problem.masses[unpinned][:, None]
    jacobian = np.zeros((len(problem.nodes), len(problem.masses), 3))
    terms = problem.weights[:, :, None] * problem.normals[:, None, :]
    np.add.at(jacobian, (np.arange(len(jacobian))[:, None], problem.nodes), terms)
    jacobian = jacobian[:, unpinned].reshape(len(jacobian), -1)

    def positions(x: Floats) -> Floats:
        full = problem.proposed.copy()
        full[unpinned] = x.reshape(-1, 3)
        return full

    def objective(x: Floats) -> float:
        offsets = x.reshape(-1, 3) - problem.proposed[unpinned]
        return float((masses * offsets**2).sum() / masses.sum())

    def gradient(x: Floats) -> Floats:
        offsets = x.reshape(-1, 3) - problem.proposed[unpinned]
        return (2.0 * masses * offsets / masses.sum()).ravel()

    def constraint(x: Floats) -> Floats:
        points = np.einsum("jk,jkx->jx", problem.weights, positions(x)[problem.nodes])
        return np.einsum("jx,jx->j", problem.normals, points) - problem.thickness

    found = minimize(
        objective,
        problem.proposed[unpinned].ravel(),
        jac=gradient if gradients else None,
        method="SLSQP",
        constraints={"type": "ineq", "fun": constraint, "jac": lambda x: jacobian},
        options={"ftol": ftol, "maxiter": max_iterations},
    )
    seconds = time.perf_counter() - begin
    moves = positions(found.x) - problem.proposed
    return Answer(moves, None, bool(found.success), found.message, seconds)


def solve_scaled(problem: ZoneArrays, ftol: float = 1e-16, max_iterations: int = 1000) -> Answer:
    """Solve a zone in numbers near 1.

    The objective is 1/2 |z|^2, and the rows of the constraint matrix have unit length.

    Args:
        problem: A zone problem.
        ftol: Tolerance of SLSQP for the objective.
        max_iterations: Limit of iterations.

    Returns:
        The answer, without multipliers.
    """
    from scipy.optimize import minimize

    begin = time.perf_counter()
    zone = scaled_zone(problem)
    matrix = zone.matrix.toarray()
    found = minimize(
        lambda z: 0.5 * float(z @ z),
        np.zeros(matrix.shape[1]),
        jac=lambda z: z,
        method="SLSQP",
        constraints={
            "type": "ineq",
            "fun": lambda z: matrix @ z - zone.rhs,
            "jac": lambda z: matrix,
        },
        options={"ftol": ftol, "maxiter": max_iterations},
    )
    seconds = time.perf_counter() - begin
    return Answer(zone.displacements(found.x), None, bool(found.success), found.message, seconds)

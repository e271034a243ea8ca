"""Zones by SciPy's SLSQP: as a user would write them, and in numbers near 1.

Both state the same problem; only the second gets it right when masses differ much.
"""

import time

import numpy as np

from validation.oracles.answer import Answer, scaled_zone


def solve_raw(problem, ftol=1e-12, gradients=False, max_iterations=1000) -> Answer:
    """In metres and kilograms: sum m |x - y|^2 / sum m, constraints as they are.

    Args:
        problem: a zone problem.
        ftol: of SLSQP.
        gradients: give it those of the objective; else it takes differences, as it does
            for most who call it.
    """
    from scipy.optimize import minimize

    begin = time.perf_counter()
    free = np.flatnonzero(np.isfinite(problem.masses))
    masses = problem.masses[free][:, None]
    jacobian = np.zeros((len(problem.nodes), len(problem.masses), 3))
    terms = problem.weights[:, :, None] * problem.normals[:, None, :]
    np.add.at(jacobian, (np.arange(len(jacobian))[:, None], problem.nodes), terms)
    jacobian = jacobian[:, free].reshape(len(jacobian), -1)

    def positions(x):
        full = problem.proposed.copy()
        full[free] = x.reshape(-1, 3)
        return full

    def objective(x):
        offsets = x.reshape(-1, 3) - problem.proposed[free]
        return float((masses * offsets**2).sum() / masses.sum())

    def gradient(x):
        offsets = x.reshape(-1, 3) - problem.proposed[free]
        return (2.0 * masses * offsets / masses.sum()).ravel()

    def constraint(x):
        points = np.einsum("jk,jkx->jx", problem.weights, positions(x)[problem.nodes])
        return np.einsum("jx,jx->j", problem.normals, points) - problem.thickness

    found = minimize(
        objective,
        problem.proposed[free].ravel(),
        jac=gradient if gradients else None,
        method="SLSQP",
        constraints={"type": "ineq", "fun": constraint, "jac": lambda x: jacobian},
        options={"ftol": ftol, "maxiter": max_iterations},
    )
    seconds = time.perf_counter() - begin
    moves = positions(found.x) - problem.proposed
    return Answer(moves, None, bool(found.success), found.message, seconds)


def solve_scaled(problem, ftol=1e-16, max_iterations=1000) -> Answer:
    """In numbers near 1: 1/2 |z|^2, rows of unit length."""
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

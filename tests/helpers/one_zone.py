"""One zone in the form that the compiled functions take, built from a `ZoneProblem`, in metres."""

import numpy as np

from izo_ref.base.options import Options
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.presets import choose_settings
from izo_ref.solvers.serial.lagrangian import Zone
from tests.naive.qp import dense_rows


def one_zone(problem, kappa, x, multipliers, memory=100, dtype=float):
    """Return the `Zone` of a problem, and its constraints as dense rows.

    Args:
        problem: `ZoneProblem` of n vertices and m impacts.
        kappa: (n,) weights of the objective sum kappa |x|^2.
        x: (n, 3) displacements from the proposed positions [m].
        multipliers: (m,).
        memory: number of vectors that the methods may store.
        dtype: of the floating-point arrays.

    Returns:
        The zone, and rows (m, 3 n).
    """
    n, m = len(problem.masses), len(problem.nodes)
    rows = dense_rows(problem.nodes, problem.weights, problem.normals, n)
    starts = problem.thickness - rows @ problem.proposed.ravel()

    def unknowns(values, last):
        """Append the three numbers of the vertex that stands for all pinned ones."""
        return np.append(np.ravel(values), [last] * 3).astype(dtype)

    moved = unknowns(x, 0.0)
    vectors = [np.zeros(len(moved), dtype) for _ in range(4)]
    entries = np.argsort(problem.nodes, axis=None, kind="stable")
    zone = Zone(
        (3 * problem.nodes).astype(np.uint32),
        problem.weights.astype(dtype),
        (entries // 4).astype(np.uint32),
        (problem.weights.ravel()[entries, None] * problem.normals[entries // 4]).astype(dtype),
        np.searchsorted(np.sort(problem.nodes, axis=None), np.arange(n + 2)).astype(np.uint64),
        problem.normals.astype(dtype),
        starts.astype(dtype),
        np.ones(m, dtype),
        unknowns(np.repeat(2.0 * kappa, 3), 1.0),
        moved,
        multipliers.astype(dtype),
        *vectors,
        (starts - rows @ np.ravel(x)).astype(dtype),
        np.zeros(m, dtype),
        np.zeros(m, dtype),
        np.zeros(memory * len(moved), dtype),
        np.zeros(9),
        ALONE,
        np.zeros(1, bool),
    )
    return zone, rows


def settings(**changes):
    """Return the settings of gradient descent with the given changes."""
    return choose_settings(Options(method="gradient"), 1e-3)._replace(**changes)


def value(problem, rows, kappa, mu, x, multipliers):
    """Evaluate the augmented Lagrangian literally.

    Args:
        problem: `ZoneProblem`.
        rows: (m, 3 n) dense constraints.
        kappa: (n,) weights of the objective.
        mu: penalty.
        x: (3 n,) displacements from the proposed positions [m].
        multipliers: (m,).

    Source:
        Page eq. 11.
    """
    c = problem.thickness - rows @ (problem.proposed.ravel() + x)
    pushed = np.maximum(c + multipliers / mu, 0.0)
    penalty = 0.5 * mu * np.sum(pushed**2) - np.sum(multipliers**2) / (2.0 * mu)
    return np.sum(np.repeat(kappa, 3) * x**2) + penalty

"""One zone as the compiled functions take it, from a `ZoneProblem`, in metres."""

import numpy as np

from izo_ref.base.options import Options
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.presets import choose_settings
from izo_ref.solvers.serial.lagrangian import Zone
from tests.naive.qp import dense_rows


def one_zone(problem, kappa, x, multipliers, memory=100, dtype=float):
    """(Zone, dense rows); x (n, 3) from the proposed positions, kappa (n,)."""
    n, m = len(problem.masses), len(problem.nodes)
    rows = dense_rows(problem.nodes, problem.weights, problem.normals, n)
    starts = problem.thickness - rows @ problem.proposed.ravel()

    def unknowns(values, last):
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
    )
    return zone, rows


def settings(**changes):
    """Settings of the loop as gradient descent has them, but for the changes."""
    return choose_settings(Options(method="gradient"), 1e-3)._replace(**changes)


def value(problem, rows, kappa, mu, x, multipliers):
    """Page eq. 11, literally; x (3 n,) from the proposed positions."""
    c = problem.thickness - rows @ (problem.proposed.ravel() + x)
    pushed = np.maximum(c + multipliers / mu, 0.0)
    penalty = 0.5 * mu * np.sum(pushed**2) - np.sum(multipliers**2) / (2.0 * mu)
    return np.sum(np.repeat(kappa, 3) * x**2) + penalty

"""A zone in scaled variables, with bounds of its rounding: what `zones/distance.py` works on."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices
from izo_ref.zones.problem import ZoneProblem

U = 2.0**-53  # u, the largest relative error of one rounding


def norm(values: Floats) -> float:
    """Return the Euclidean norm; squares neither underflow nor overflow."""
    largest = float(np.max(np.abs(values), initial=0.0))
    if largest == 0.0 or not math.isfinite(largest):
        return largest
    return largest * float(np.linalg.norm(values / largest))


class ScaledZone:
    """A zone in scaled variables: C, the slacks C z - s, and bounds of their rounding.

    Attributes:
        matrix: (k, 3 n_unpinned) csr array, C, with rows of unit length.
        size: The absolute values of `matrix`.
        z: (3 n_unpinned,) f8 [m kg^1/2].
        lengths: (k,) f8 [kg^-1/2], lengths of the rows before they were scaled.
        constraint_of: (n_impacts,) the constraint of each impact; equal impacts have one.
        slack: (k,) f8 [m kg^1/2], C z - s.
        slack_error: (k,) f8 [m kg^1/2], bound of the rounding of `slack`.
        hopeless: Whether an impact without unpinned vertices is violated.
    """

    def __init__(self, problem: ZoneProblem, displacements: Floats) -> None:
        """Scale the constraints of a zone, and compute the slacks at some displacements.

        Args:
            problem: The zone problem.
            displacements: (n, 3) f8 [m], from the proposed positions.
        """
        from scipy.sparse import coo_array

        scale = problem.inverse_sqrt_masses
        unpinned = np.flatnonzero(scale > 0.0)
        column = np.full(len(scale), -1)
        column[unpinned] = np.arange(len(unpinned))
        same = np.column_stack((problem.nodes, problem.weights, problem.normals))
        _, first, self.constraint_of = np.unique(
            same, axis=0, return_index=True, return_inverse=True
        )
        nodes, weights = problem.nodes[first], problem.weights[first]
        normals = problem.normals[first]
        entries = (weights * scale[nodes])[:, :, None] * normals[:, None, :]
        largest = np.abs(entries).max(axis=(1, 2), initial=0.0)
        empty = largest == 0.0
        largest[empty] = 1.0
        # entries are divided by the largest, because the squares of small entries would underflow
        self.lengths = largest * np.sqrt(((entries / largest[:, None, None]) ** 2).sum(axis=(1, 2)))
        slack, error = _slack(problem, displacements, first)
        self.hopeless = bool((slack[empty] < 0.0).any())
        slack[empty] = problem.thickness  # so that constraints without unknowns always hold
        self.lengths[empty] = 1.0
        self.slack, self.slack_error = slack / self.lengths, error / self.lengths
        entries /= self.lengths[:, None, None]
        rows = np.broadcast_to(np.arange(len(nodes))[:, None, None], entries.shape)
        columns = 3 * column[nodes][:, :, None] + np.arange(3)
        used = np.broadcast_to((column[nodes] >= 0)[:, :, None], entries.shape)
        shape = (len(nodes), 3 * len(unpinned))
        self.matrix: Any = coo_array((entries[used], (rows[used], columns[used])), shape).tocsr()
        self.size = abs(self.matrix)
        self.z = (displacements[unpinned] / scale[unpinned, None]).ravel()

    def is_sound(self) -> bool:
        """Return whether all numbers are finite, and no impact is hopeless."""
        arrays = (self.matrix.data, self.z, self.slack, self.slack_error, self.lengths)
        return not self.hopeless and all(np.isfinite(array).all() for array in arrays)

    def moved(self, step: Floats) -> tuple[Floats, Floats]:
        """Return the slacks of z - step, and a bound of their rounding.

        An entry of C is the result of five roundings (root, quotient, two products, division by the
        length), so its error is at most 8 u of itself. The product of a row with 12 terms has an
        error of 12 u of the sizes of its terms. Together these are 20 u; the code takes 24 u.
        """
        slack = self.slack - self.matrix @ step
        return slack, self.slack_error + 24 * U * (self.size @ np.abs(step)) + U * np.abs(slack)

    def correction(self, chosen: Flags) -> Floats:
        """Return the shortest step that brings chosen constraints to zero slack; zeros for none."""
        return self._shortest(chosen, self.slack)

    def opening(self, chosen: Flags) -> Floats:
        """Return the shortest direction along which each chosen constraint opens by one."""
        return self._shortest(chosen, np.ones(len(self.slack)))

    def _shortest(self, chosen: Flags, right: Floats) -> Floats:
        """Return the shortest step x with C x = right at the chosen constraints."""
        from scipy.sparse.linalg import lsmr

        step = np.zeros(self.matrix.shape[1])
        unit = float(np.max(np.abs(right[chosen]), initial=0.0))
        if unit > 0.0:
            matrix, wanted = self.matrix[chosen], right[chosen] / unit
            for _ in range(2):  # the second solve removes what the first one left
                left = wanted - matrix @ step
                step += lsmr(matrix, left, atol=1e-14, btol=1e-14, conlim=1e14)[0]
        return unit * step

    def pulled(self, pushes: Floats) -> tuple[Floats, float]:
        """Return C^T pushes, and a bound of the length of its rounding.

        A sum has at most as many terms as a vertex has impacts, and each entry an error of 8 u.
        """
        terms = int(np.bincount(self.matrix.indices, minlength=1).max(initial=1))
        return self.matrix.T @ pushes, (terms + 8) * U * norm(self.size.T @ pushes)


def _slack(problem: ZoneProblem, displacements: Floats, impacts: Indices) -> tuple[Floats, Floats]:
    """Return gap less thickness at proposed plus displacements, and a bound of its rounding.

    Proposed positions and displacements contribute one summand each, relative to the first node.
    Each takes a difference, two products, and sums of 4 and of 3 terms: 8 u of the sizes of its
    terms. Where the weights do not sum to zero, their sum times the first node is added to the
    bound.

    Args:
        problem: The zone problem.
        displacements: (n, 3) f8 [m].
        impacts: (k,) indices of the impacts.

    Returns:
        (k,) f8 [m] each.
    """
    nodes, weights = problem.nodes[impacts], problem.weights[impacts]
    normals = problem.normals[impacts]
    total = np.full(len(nodes), -problem.thickness)
    error = np.zeros(len(nodes))
    sums = np.abs([math.fsum(row) for row in weights.tolist()])
    size = np.abs(normals)
    for summand in (problem.proposed, displacements):
        relative = summand[nodes] - summand[nodes[:, :1]]
        points = np.einsum("jk,jkx->jx", weights, relative)
        total += np.einsum("jx,jx->j", normals, points)
        terms = np.einsum("jk,jkx,jx->j", np.abs(weights), np.abs(relative), size)
        first = np.einsum("jx,jx->j", size, np.abs(summand[nodes[:, 0]]))
        error += 10 * U * terms + (1.0 + 1e-9) * sums * first + 2 * U * np.abs(total)
    return total, error

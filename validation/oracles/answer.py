"""What an oracle of a zone says, and the zone in numbers near 1."""

from typing import NamedTuple

import numpy as np


class Answer(NamedTuple):
    """A solver's answer. Whether it is right is not its own to say."""

    displacements: np.ndarray  # (n, 3) f8 [m], from the proposed positions
    multipliers: np.ndarray | None  # (n_impacts,) f8 [kg], if the solver gives them
    claims: bool  # the solver says that it succeeded
    message: str  # what it says
    seconds: float


class ScaledZone(NamedTuple):
    """minimise 1/2 |z|^2 subject to C z >= s, in numbers near 1 (SPEC section 5)."""

    matrix: object  # (n_impacts, 3 n_free) scipy.sparse.csr_array, C, rows of unit length
    rhs: np.ndarray  # (n_impacts,) f8, s, the largest 1
    lengths: np.ndarray  # (n_impacts,) f8 [kg^-1/2], of the rows before scaling
    unit: float  # [m kg^1/2], z = sqrt(m) (x - y) / unit
    free: np.ndarray  # (n_free,) indices of the vertices of finite mass
    problem: object

    def displacements(self, z):
        """(n, 3) f8 [m], from (3 n_free,) f8."""
        moves = np.zeros_like(self.problem.proposed)
        root = np.sqrt(self.problem.masses[self.free])[:, None]
        moves[self.free] = self.unit * z.reshape(-1, 3) / root
        return moves

    def multipliers(self, scaled):
        """(n_impacts,) f8 [kg], from those of the scaled rows."""
        return self.unit * scaled / self.lengths


def mass_norm(masses, vectors) -> float:
    """[m kg^1/2], sqrt(sum m |v|^2) over the vertices of finite mass."""
    free = np.isfinite(masses)
    return float(np.sqrt((masses[free, None] * vectors[free] ** 2).sum()))


def no_answer(problem, message, seconds) -> Answer:
    return Answer(np.full_like(problem.proposed, np.nan), None, False, message, seconds)


def scaled_zone(problem) -> ScaledZone:
    """Written from the mathematics, and apart from what izo_ref's solvers use.

    Args:
        problem: has nodes, weights, normals, proposed, masses, thickness, as ZoneProblem.

    Raises:
        ValueError: an impact has no vertex of finite mass, so no row.
    """
    from scipy.sparse import coo_array

    free = np.flatnonzero(np.isfinite(problem.masses))
    column = np.full(len(problem.masses), -1)
    column[free] = np.arange(len(free))
    root = np.sqrt(problem.masses)
    entries = (problem.weights / root[problem.nodes])[:, :, None] * problem.normals[:, None, :]
    lengths = np.sqrt((entries**2).sum(axis=(1, 2)))
    if not (lengths > 0.0).all():
        raise ValueError(f"impact {np.argmin(lengths)} has no vertex of finite mass")
    entries /= lengths[:, None, None]
    rows = np.broadcast_to(np.arange(len(entries))[:, None, None], entries.shape)
    columns = 3 * column[problem.nodes][:, :, None] + np.arange(3)
    kept = np.broadcast_to((column[problem.nodes] >= 0)[:, :, None], entries.shape)
    shape = (len(entries), 3 * len(free))
    matrix = coo_array((entries[kept], (rows[kept], columns[kept])), shape=shape).tocsr()

    relative = problem.proposed[problem.nodes] - problem.proposed[problem.nodes[:, :1]]
    gaps = np.einsum("jk,jkx,jx->j", problem.weights, relative, problem.normals)
    rhs = (problem.thickness - gaps) / lengths
    unit = max(float(np.abs(rhs).max(initial=0.0)), np.finfo(float).tiny)
    return ScaledZone(matrix, rhs / unit, lengths, unit, free, problem)

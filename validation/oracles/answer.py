"""The zone problem as oracles see it, scaled to numbers near 1, and the answers of oracles.

The oracles `nnls.py`, `qp.py` and `slsqp.py` solve the scaled zone of `scaled_zone`. It is written
from the mathematics of docs/method section 5 and shares no code with the solvers of `izo_ref`.
"""

from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]  # f8, of the shape that is stated beside
Ints: TypeAlias = NDArray[np.int32]  # i4, of the shape that is stated beside
Indices: TypeAlias = NDArray[np.integer[Any]]  # whole numbers, of the shape that is stated beside
Flags: TypeAlias = NDArray[np.bool_]  # b1, of the shape that is stated beside


class ZoneArrays(Protocol):
    """What oracles read of a zone problem; a `ZoneProblem` has all of it.

    Attributes:
        nodes: (n_impacts, 4) i4, vertices of each impact.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        proposed: (n, 3) f8 [m], the proposed positions.
        masses: (n,) f8 [kg], infinite for a pinned vertex.
        thickness: [m].
    """

    nodes: Ints
    weights: Floats
    normals: Floats
    proposed: Floats
    masses: Floats
    thickness: float


class Answer(NamedTuple):
    """The answer of a solver. The solver does not judge whether it is right."""

    displacements: Floats  # (n, 3) f8 [m], from the proposed positions
    multipliers: Floats | None  # (n_impacts,) f8 [kg], if the solver gives them
    claims: bool  # the solver reports success
    message: str  # the message of the solver
    seconds: float


class ScaledZone(NamedTuple):
    """A zone in numbers near 1: minimise 1/2 |z|^2 subject to C z >= s (docs/method section 5)."""

    matrix: Any  # (n_impacts, 3 n_unpinned) scipy.sparse.csr_array, C; its rows have unit length
    rhs: Floats  # (n_impacts,) f8, s; the largest entry is 1 in magnitude
    lengths: Floats  # (n_impacts,) f8 [kg^-1/2], lengths of the rows before scaling
    unit: float  # [m kg^1/2], z = sqrt(m) (x - y) / unit
    unpinned: Indices  # (n_unpinned,) indices of the vertices of finite mass
    problem: ZoneArrays

    def displacements(self, z: Floats) -> Floats:
        """Convert scaled unknowns to displacements.

        Args:
            z: (3 n_unpinned,) f8.

        Returns:
            (n, 3) f8 [m], from the proposed positions; zero for pinned vertices.
        """
        moves = np.zeros_like(self.problem.proposed)
        root = np.sqrt(self.problem.masses[self.unpinned])[:, None]
        moves[self.unpinned] = self.unit * z.reshape(-1, 3) / root
        return moves

    def multipliers(self, scaled: Floats) -> Floats:
        """Convert the multipliers of the scaled constraints.

        Args:
            scaled: (n_impacts,) f8.

        Returns:
            (n_impacts,) f8 [kg].
        """
        return self.unit * scaled / self.lengths


def mass_norm(masses: Floats, vectors: Floats) -> float:
    """Compute sqrt(sum m |v|^2) over the vertices of finite mass.

    The largest component is made about 1 by a power of two, whose square no float need hold.

    Args:
        masses: (n,) f8 [kg].
        vectors: (n, 3) f8 [m].

    Returns:
        [m kg^1/2].
    """
    unpinned = np.isfinite(masses)
    own = vectors[unpinned]
    exponent = int(np.frexp(np.abs(own).max(initial=0.0))[1])
    root = np.sqrt((masses[unpinned, None] * np.ldexp(own, -exponent) ** 2).sum())
    with np.errstate(over="ignore"):
        return float(np.ldexp(root, exponent))


def no_answer(problem: ZoneArrays, message: str, seconds: float) -> Answer:
    """Return the `Answer` of a solver that failed: its displacements are NaN."""
    return Answer(np.full_like(problem.proposed, np.nan), None, False, message, seconds)


def scaled_zone(problem: ZoneArrays) -> ScaledZone:
    """Scale a zone problem to numbers near 1.

    Args:
        problem: A zone problem, for example a `ZoneProblem`.

    Returns:
        The same problem in scaled unknowns.

    Raises:
        ValueError: An impact has no vertex of finite mass, so its constraint has no unknown.

    Source: docs/method section 5.
    """
    from scipy.sparse import coo_array

    unpinned = np.flatnonzero(np.isfinite(problem.masses))
    column = np.full(len(problem.masses), -1)
    column[unpinned] = np.arange(len(unpinned))
    root = np.sqrt(problem.masses)
    entries = (problem.weights / root[problem.nodes])[:, :, None] * problem.normals[:, None, :]
    lengths = np.sqrt((entries**2).sum(axis=(1, 2)))
    if not (lengths > 0.0).all():
        raise ValueError(f"impact {np.argmin(lengths)} has no vertex of finite mass")
    entries /= lengths[:, None, None]
    rows = np.broadcast_to(np.arange(len(entries))[:, None, None], entries.shape)
    columns = 3 * column[problem.nodes][:, :, None] + np.arange(3)
    kept = np.broadcast_to((column[problem.nodes] >= 0)[:, :, None], entries.shape)
    shape = (len(entries), 3 * len(unpinned))
    matrix = coo_array((entries[kept], (rows[kept], columns[kept])), shape=shape).tocsr()

    relative = problem.proposed[problem.nodes] - problem.proposed[problem.nodes[:, :1]]
    gaps = np.einsum("jk,jkx,jx->j", problem.weights, relative, problem.normals)
    rhs = (problem.thickness - gaps) / lengths
    unit = max(float(np.abs(rhs).max(initial=0.0)), np.finfo(float).tiny)
    return ScaledZone(matrix, rhs / unit, lengths, unit, unpinned, problem)

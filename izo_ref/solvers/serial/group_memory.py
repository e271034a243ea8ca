"""Work space of block pivoting by a thread group."""

from typing import NamedTuple

from izo_ref.base.arrays import Floats, Ints
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.group_cholesky import packed_size


class Memory(NamedTuple):
    """Work space of a zone of n impacts; the work space of the factor is apart."""

    u: Floats  # (n,) f8, the multipliers
    earlier: Floats  # (n,) f8, v
    products: Floats  # (n,) f8, C z
    right: Floats  # (n,) f8, of the guess the point ahead; the right-hand side; what ranks
    scales: Floats  # (n,) f8, reciprocals of the row sums, later of the diagonal of the factor
    rest: Floats  # (n,) f8, work space of solves
    z: Floats  # (3 n_vertices,) f8
    is_active: Ints  # (n,) i4, 1 or 0
    is_wrong: Ints  # (n,) i4, 1 or 0, whether a constraint is on the wrong side
    places: Ints  # (n,) i4, the number of each active constraint among them, else -1
    active: Ints  # (n,) i4, the active constraints
    firsts: Ints  # (n_vertices,) i4, the constraint that comes first at each vertex, or -1


@compiled
def work_of_group_pivot(n: int, n_vertices: int, most_active: int) -> tuple[int, int]:
    """Return the work space of a zone of n impacts, in f8 numbers and in i4 indices.

    Args:
        n: Impacts of the zone.
        n_vertices: Its unpinned vertices.
        most_active: Largest number of active constraints that is solved.
    """
    numbers = vector_size(n, n_vertices) + packed_size(min(n, most_active))
    return numbers, 8 * n + 2 * n_vertices


@compiled
def vector_size(n: int, n_vertices: int) -> int:
    """Return how many f8 numbers the vectors of `Memory` have."""
    return 6 * n + 3 * n_vertices

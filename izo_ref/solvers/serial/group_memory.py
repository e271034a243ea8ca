"""Work space of block pivoting by a thread group."""

from typing import NamedTuple

from izo_ref.base.arrays import Floats, Ints
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.envelope import AREA, SIDE, count_tiles


class Memory(NamedTuple):
    """Work space of a zone of n impacts; the work space of the factor is apart.

    `whole` is n, rounded up to whole tiles.
    """

    u: Floats  # (n,) f8, the multipliers
    earlier: Floats  # (n,) f8, v
    products: Floats  # (n,) f8, C z
    right: Floats  # (whole,) f8, of the guess the point ahead; the right-hand side; what ranks
    scales: Floats  # (whole,) f8, reciprocals of the row sums, later of the diagonal of the factor
    z: Floats  # (3 n_vertices,) f8
    is_active: Ints  # (n,) i4, 1 or 0
    is_wrong: Ints  # (n,) i4, 1 or 0, whether a constraint is on the wrong side
    places: Ints  # (n,) i4, how many active constraints come before, as ~number if inactive
    active: Ints  # (n,) i4, the active constraints
    firsts: Ints  # (n_vertices,) i4, the constraint that comes first at each vertex, or -1
    order: Ints  # (n,) i4, the constraints along the zone
    lowest: Ints  # (n,) i4, of the constraints that share a vertex with each one, the first there
    firsts_of_tiles: Ints  # (tile rows,) i4, of `Envelope`
    lasts_of_tiles: Ints  # (tile rows,) i4
    starts: Ints  # (tile rows + 1,) i4


@compiled
def memory_of(n: int, n_vertices: int, vectors: Floats, indices: Ints) -> Memory:
    """Return the work space of a zone.

    Args:
        n: Impacts of the zone.
        n_vertices: Its unpinned vertices.
        vectors: (>= vector_size(n, n_vertices),) f8.
        indices: i4, those of `index_size` behind the linked lists of `Zone`.
    """
    whole, tiles = SIDE * count_tiles(n), count_tiles(n)
    behind, rest = 3 * n + 2 * whole, indices[6 * n :]
    return Memory(
        vectors[:n],
        vectors[n : 2 * n],
        vectors[2 * n : 3 * n],
        vectors[3 * n : 3 * n + whole],
        vectors[3 * n + whole : behind],
        vectors[behind : behind + 3 * n_vertices],
        indices[:n],
        indices[n : 2 * n],
        indices[2 * n : 3 * n],
        indices[3 * n : 4 * n],
        rest[:n_vertices],
        indices[4 * n : 5 * n],
        indices[5 * n : 6 * n],
        rest[n_vertices : n_vertices + tiles],
        rest[n_vertices + tiles : n_vertices + 2 * tiles],
        rest[n_vertices + 2 * tiles : n_vertices + 3 * tiles + 1],
    )


@compiled
def vector_size(n: int, n_vertices: int) -> int:
    """Return how many f8 numbers the vectors of `Memory` have."""
    return 3 * n + 2 * SIDE * count_tiles(n) + 3 * n_vertices


@compiled
def index_size(n: int, n_vertices: int) -> int:
    """Return how many i4 numbers the indices of `Memory` and the lists of `Zone` have."""
    return 10 * n + 2 * n_vertices + 3 * count_tiles(n) + 1


@compiled
def work_of_group_pivot(n: int, n_vertices: int, n_tiles: int) -> tuple[int, int]:
    """Return the work space of a zone of n impacts, in f8 numbers and in i4 indices.

    Args:
        n: Impacts of the zone.
        n_vertices: Its unpinned vertices.
        n_tiles: Tiles of its factor.
    """
    return vector_size(n, n_vertices) + AREA * n_tiles, index_size(n, n_vertices)

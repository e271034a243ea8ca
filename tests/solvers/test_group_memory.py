"""The work space of block pivoting by a thread group."""

import numpy as np
import pytest

from izo_ref.solvers.serial.envelope import SIDE
from izo_ref.solvers.serial.group_memory import index_size, memory_of, vector_size


@pytest.mark.parametrize(("n", "n_vertices"), [(1, 1), (SIDE, 5), (SIDE + 1, 80), (50, 0)])
def test_the_arrays_of_the_work_space_are_apart_and_fill_it(n, n_vertices):
    vectors = np.zeros(vector_size(n, n_vertices))
    indices = np.zeros(index_size(n, n_vertices) - n_vertices - 4 * n, np.int32)
    memory = memory_of(n, n_vertices, vectors, indices)
    for array in memory:
        array[:] += 1
    assert (vectors == 1).all()
    assert (indices == 1).all()
    whole, tiles = -(-n // SIDE) * SIDE, -(-n // SIDE)
    lengths = [n, n, n, whole, whole, 3 * n_vertices, n, n, n, n, n_vertices, n, n]
    assert [len(array) for array in memory] == [*lengths, tiles, tiles, tiles + 1]

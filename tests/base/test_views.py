"""Views of memory in compiled code."""

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.serial.views import FOUR, ONE, THREE, TWO, matrix_of, place


@compiled
def picked(values, start):
    """Return five numbers from a place on."""
    i = place(start)
    return values[i], values[i + ONE], values[i + TWO], values[i + THREE], values[i + FOUR]


@compiled
def row_sums(flat, rows, columns):
    """Return the sums of the rows of a view of flat memory."""
    view = matrix_of(flat, rows, columns)
    return [view[i].sum() for i in range(rows)]


def test_places_of_any_integer_type_find_the_numbers():
    values = np.arange(10.0)
    for kind in (int, np.int32, np.int64, np.uint32):
        assert picked(values, kind(3)) == (3.0, 4.0, 5.0, 6.0, 7.0)


def test_a_matrix_is_a_view_of_the_first_numbers():
    assert row_sums(np.arange(7.0), 2, 3) == [3.0, 12.0]

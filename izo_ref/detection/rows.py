"""Rows of an array that are equal."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Floats, Indices, Ints
from izo_ref.detection.serial.mesh import sort_rows


def equal_rows(rows: Floats) -> Indices:
    """Number the different rows; return (n,) i8, the number of each row, from 0 on."""
    order = np.lexsort(rows.T)
    group = np.zeros(len(rows), np.int64)
    in_order = rows[order]
    group[order[1:]] = np.cumsum((in_order[1:] != in_order[:-1]).any(axis=1))
    return group


def first_of_each(rows: Ints, n_values: int) -> Indices:
    """Return the index of the first of all rows that have the same numbers, ascending."""
    rows = np.sort(rows, axis=1)
    order = sort_rows(rows, n_values)  # equal rows keep their order
    first = np.ones(len(order), bool)
    in_order = rows[order]
    first[1:] = (in_order[1:] != in_order[:-1]).any(axis=1)
    return np.sort(order[first]).astype(np.int64)

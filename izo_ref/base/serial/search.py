"""Search in sorted arrays."""

from typing import Any

from izo_ref.base.arrays import AnyArray, Offsets
from izo_ref.base.compile import compiled


@compiled
def first_not_below(value: Any, ascending: AnyArray) -> int:
    """Return the first place of a sorted array whose entry is not below a value.

    Args:
        value: The number to look for.
        ascending: (n,) numbers.

    Returns:
        A place from 0 to n; n if all entries are below the value.
    """
    low, high = 0, ascending.shape[0]
    while low < high:
        middle = (low + high) // 2
        if ascending[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def is_among(value: Any, ascending: AnyArray) -> bool:
    """Return whether a sorted array has a value.

    Args:
        value: The number to look for.
        ascending: (n,) numbers.
    """
    place = first_not_below(value, ascending)
    return place < ascending.shape[0] and ascending[place] == value


@compiled
def block_of(i: int, offsets: Offsets) -> int:
    """Return the block that entry i is in.

    Args:
        i: Index of the entry.
        offsets: (n_blocks + 1,) i8, where each block begins, and the end; no block is empty.
    """
    low, high = 0, offsets.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if offsets[middle] <= i:
            low = middle
        else:
            high = middle
    return low

"""Search in sorted arrays."""

from typing import Any

from izo_ref.base.arrays import AnyArray
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

"""Search in sorted arrays."""

from izo_ref._jit import compiled


@compiled
def is_among(value, ascending):
    """Whether a sorted array has a value."""
    low, high = 0, ascending.shape[0]
    while low < high:
        middle = (low + high) // 2
        if ascending[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low < ascending.shape[0] and ascending[low] == value

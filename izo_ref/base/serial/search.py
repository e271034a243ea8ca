"""Search in sorted arrays."""

from izo_ref.base.compile import compiled


@compiled
def first_not_below(value, ascending):
    """Where a sorted array comes to a value, or passes it; its length if it does not."""
    low, high = 0, ascending.shape[0]
    while low < high:
        middle = (low + high) // 2
        if ascending[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def is_among(value, ascending):
    """Whether a sorted array has a value."""
    place = first_not_below(value, ascending)
    return place < ascending.shape[0] and ascending[place] == value


@compiled
def block_of(i, starts):
    """Which part i is in, of parts that begin at starts (n + 1,); none is empty."""
    low, high = 0, starts.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if starts[middle] <= i:
            low = middle
        else:
            high = middle
    return low

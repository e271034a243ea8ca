"""Sort keys by the threads of a group (`thread_group.py`).

Each thread sorts runs of RUN neighbouring keys. Then neighbouring runs are merged, pass by pass,
until one run is left. In a pass, each key finds its place by itself: a search in the other run says
how many of its keys come before. So a pass takes one wait, and no thread depends on another.
"""

from izo_ref.base.arrays import AnyInt, AnyInts
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup

# Keys that one thread sorts by insertion. Not measured yet; a longer run saves a wait each time it
# doubles, and the time of the insertions grows with its square.
RUN = 8


@compiled
def place_in_merge(keys: AnyInts, n: int, width: int, i: int) -> AnyInt:
    """Return the place of key i when each sorted run of `width` keys is merged with the next.

    Equal keys keep their order. The runs begin at key 0, and the last one ends at key n - 1.
    """
    run = i // width
    beside = run ^ 1  # the other run, with which it is merged
    key = keys[i]
    low = min(beside * width, n)
    begin, end = low, min(low + width, n)
    while low < end:
        middle = (low + end) // 2
        if keys[middle] < key or (beside < run and keys[middle] == key):
            low = middle + 1
        else:
            end = middle
    return min(run, beside) * width + (i - run * width) + (low - begin)


@compiled
def _sort_run(begin: int, end: int, keys: AnyInts, keys_out: AnyInts, places_out: AnyInts) -> None:
    """Sort the keys from `begin` to `end` - 1 by insertion; `keys_out` may be `keys`."""
    for i in range(begin, end):
        key = keys[i]
        at = i
        while at > begin and keys_out[at - 1] > key:
            keys_out[at], places_out[at] = keys_out[at - 1], places_out[at - 1]
            at -= 1
        keys_out[at], places_out[at] = key, i


@compiled
def group_sort(
    group: ThreadGroup,
    n: int,
    keys: AnyInts,
    places_out: AnyInts,
    other_keys: AnyInts,
    other_places: AnyInts,
) -> None:
    """Sort the first n keys in place; equal keys keep their order.

    The group waits 1 + ceil(log2(n / RUN)) times, at the end too: so all threads may read all
    results. All threads must have waited since the keys were written.

    Args:
        group: The threads.
        n: Number of keys; the same for all threads.
        keys: (>= n,) i8 or i4, which become sorted.
        places_out: (>= n,) i8 or i4, where each of the sorted keys was.
        other_keys: (>= n,) i8 or i4, work space.
        other_places: (>= n,) i8 or i4, work space.
    """
    target, target_places = keys, places_out
    source, source_places = other_keys, other_places
    width = RUN
    while width < n:  # the last of the passes has to write to `keys`
        source, source_places, target, target_places = target, target_places, source, source_places
        width *= 2
    for run in range(group.rank(), -(-n // RUN), group.size()):
        end = min(RUN * (run + 1), n)
        _sort_run(RUN * run, end, keys, target, target_places)
    group.wait()
    width = RUN
    while width < n:
        source, source_places, target, target_places = target, target_places, source, source_places
        for i in range(group.rank(), n, group.size()):
            at = place_in_merge(source, n, width, i)
            target[at], target_places[at] = source[i], source_places[i]
        group.wait()
        width *= 2

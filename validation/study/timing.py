"""Time a call: the median of repeats, within a budget."""

import time
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Generic, NamedTuple, TypeVar

import numpy as np

Returned = TypeVar("Returned")
Key = TypeVar("Key", bound=Hashable)

SHORTEST_S = 2e-3  # a call of microseconds is repeated until its repeats took this long in all
MOST_REPEATS = 200
REPEATS = 5  # of calls that are timed in turn; their median is taken


class Timing(NamedTuple, Generic[Returned]):
    """Result and times of a call."""

    result: Returned  # of the first call
    first_s: float  # of the first call; it may compile
    seconds: float  # median of the repeats; of the first call if there are none
    spent_s: float  # on all calls


def measure(call: Callable[[], Returned], repeats: int, budget_s: float) -> Timing[Returned]:
    """Call a function once, and then again to measure its time.

    Args:
        call: The function; what it raises is raised here.
        repeats: Least number of calls after the first one, as far as the budget allows.
        budget_s: Seconds for all calls. If the first call takes longer, it is not repeated.

    Returns:
        The result of the first call, and the times.
    """
    begin = time.perf_counter()
    result = call()
    first = time.perf_counter() - begin
    seconds, spent = [], 0.0
    while spent + first < budget_s and len(seconds) < MOST_REPEATS:
        if len(seconds) >= repeats and spent > SHORTEST_S:
            break
        begin = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begin)
        spent += seconds[-1]
    return Timing(result, first, float(np.median(seconds)) if seconds else first, first + spent)


def in_turn(calls: Mapping[Key, Callable[[], object]], repeats: int) -> dict[Key, list[float]]:
    """Time all calls one after the other, and do so several times.

    Args:
        calls: `{key: call}`. Each was called before, since a first call compiles.
        repeats: How often each call is timed.

    Returns:
        `{key: seconds of each call}`.
    """
    seconds: dict[Key, list[float]] = {key: [] for key in calls}
    for _ in range(repeats):
        for key, call in calls.items():
            begin = time.perf_counter()
            call()
            seconds[key].append(time.perf_counter() - begin)
    return seconds


def spread(seconds: Sequence[float]) -> dict[str, float | int]:
    """Return the median, the least, the most and the number of some times."""
    return {
        "median_s": float(np.median(seconds)),
        "least_s": float(min(seconds)),
        "most_s": float(max(seconds)),
        "repeats": len(seconds),
    }


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Set the number of numba's threads inside the block, and restore it afterwards."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(count)
    try:
        yield
    finally:
        numba.set_num_threads(before)


def thread_counts() -> list[int]:
    """Return the numbers of threads that are timed: one, and two if the machine has two."""
    import numba

    # numba.config is made when numba is imported, which the type checker cannot see
    most = numba.config.NUMBA_NUM_THREADS  # pyright: ignore
    return [1, 2] if most >= 2 else [1]

"""Time of a call: a median of repeats, within a limit."""

import time
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

SHORTEST_S = 2e-3  # in all: repeats of a call that takes microseconds go on until then
MOST_REPEATS = 200


class Timing(NamedTuple):
    result: object  # of the first call
    first_s: float  # of the first call, with compiling if it compiles
    seconds: float  # median of the calls after it; of the first if there are no others
    spent_s: float  # on all calls


def measure(call, repeats, budget_s) -> Timing:
    """Call once, and then again for the time.

    Args:
        call: without arguments; may raise.
        repeats: at least, after the first call, as far as the budget allows.
        budget_s: for the repeats; a first call that took longer is not repeated.
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


@contextmanager
def threads(count):
    """Numba's threads inside the block; as many as before after it."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(count)
    try:
        yield
    finally:
        numba.set_num_threads(before)


def thread_counts() -> list[int]:
    """Those that are timed: one, and two if there are two."""
    import numba

    return [1, 2] if numba.config.NUMBA_NUM_THREADS >= 2 else [1]

"""Threads that sort together never read or write what another thread writes before they wait."""

import numpy as np
import pytest

from izo_ref.base.serial.group_sort import RUN, group_sort
from tests.helpers.logged import Log, logged


def sorted_by(log, values):
    """Sort keys by the threads of a log, and return (keys, places) as each thread reads them."""
    empty = [np.full(len(values), -7) for _ in range(3)]
    keys, places, *more = (logged(array, log) for array in (values.copy(), *empty))

    def call():
        group_sort(log.group(), len(values), keys, places, *more)
        return [[array[i] for i in range(len(values))] for array in (keys, places)]

    return log.run(call)


@pytest.mark.parametrize("n_threads", [2, 3, 7])
@pytest.mark.parametrize("n", [0, 1, RUN + 1, 2 * RUN + 3, 5 * RUN])
def test_threads_sort_without_conflicts(rng, n_threads, n):
    values = rng.integers(0, 20, n)
    expected = np.argsort(values, kind="stable")
    log = Log(n_threads)
    read = sorted_by(log, values)
    assert np.array_equal(read, [[values[expected], expected]] * n_threads)
    assert log.conflicts() == (0, [])
    waits = 1 + int(np.ceil(np.log2(max(n / RUN, 1.0))))
    assert len(log.sites) == waits


def test_no_wait_can_be_left_out(rng):
    log = Log(3)
    sorted_by(log, rng.integers(0, 20, 5 * RUN))
    sites = set(log.sites.values())
    assert len(sites) == 2
    assert [site for site in sorted(sites) if log.conflicts(site)[0] == 0] == []

"""The log of accesses finds conflicts, and only those; a seed draws the same order again."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ThreadGroup
from tests.helpers.logged import Log, logged

N = 3


def run(text, seed=None, n=4):
    """Run a text by N threads on an array, and return (log, array)."""
    log, array = Log(N, seed), np.zeros(n)
    own, group = logged(array, log), log.group()
    log.run(lambda: text(group, own))
    return log, array


def each_its_own(group: ThreadGroup, a):
    a[group.rank()] = 1.0
    group.wait()
    a[3] = a[0] + a[1]  # all write the same


def same_and_read(group: ThreadGroup, a):
    a[0] = 5.0
    a[1 + group.rank()] = a[0]


def different(group: ThreadGroup, a):
    a[0] = float(group.rank())


def reads_what_another_writes(group: ThreadGroup, a):
    if group.rank() == 0:
        a[0] = 5.0
    else:
        a[group.rank()] = a[0]


def reads_before_it_writes(group: ThreadGroup, a):
    a[0] = 0.0 * a[0] + 5.0


def counts(group: ThreadGroup, a):
    group.add(a, 0, 1)
    group.wait()
    a[1] = a[0]


def counts_and_reads(group: ThreadGroup, a):
    group.add(a, 0, 1)
    a[1 + group.rank()] = a[0]


def slices(group: ThreadGroup, a):
    a[group.rank() : group.rank() + 2] = float(group.rank())


@pytest.mark.parametrize("seed", [None, 1, 2])
@pytest.mark.parametrize(
    ("text", "conflicts"),
    [
        (each_its_own, 0),
        (same_and_read, 0),
        (different, 1),
        (reads_what_another_writes, 1),
        (reads_before_it_writes, 1),
        (counts, 0),
        (counts_and_reads, 1),
        (slices, 2),
    ],
)
def test_conflicts_are_found(text, conflicts, seed):
    log, _ = run(text, seed)
    assert log.conflicts()[0] == conflicts


@pytest.mark.parametrize("text", [each_its_own, counts])
def test_a_wait_that_is_needed_is_told_from_others(text):
    log, _ = run(text)
    (site,) = log.sites.values()
    assert log.conflicts(site)[0] > 0


def test_the_order_of_the_threads_is_that_of_the_seed():
    orders = [[rank for rank, *_ in run(slices, seed)[0].accesses] for seed in (1, 1, 2, 3)]
    assert orders[0] == orders[1]
    assert len({tuple(order) for order in orders}) > 1


def test_errors_of_a_thread_end_all_threads():
    def fails(group: ThreadGroup, a):
        if group.rank() == 1:
            raise ValueError("one")
        group.wait()

    with pytest.raises(ValueError, match="one"):
        run(fails, 1)

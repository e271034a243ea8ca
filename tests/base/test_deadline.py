"""The deadline: stages, slices of work, and the flag that compiled loops read."""

import math
import time

import numpy as np
import pytest

from izo_ref.base.deadline import FIRST_SLICE, SLICE_S, UNLIMITED, Deadline, OutOfTimeError


class Clock:
    """A clock that shows what a test sets."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


def test_a_stage_ends_at_its_end_and_not_before():
    clock = Clock()
    deadline = Deadline(10.0, clock)
    clock.now_s = 1000.0
    deadline.check()  # outside of any stage, nothing ends
    clock.now_s = 100.0
    deadline.begin_stage(2.0)
    clock.now_s = 101.9
    deadline.check()
    clock.now_s = 102.0
    with pytest.raises(OutOfTimeError):
        deadline.check()
    deadline.begin_stage(5.0)
    deadline.check()
    deadline.begin_stage(math.inf)
    clock.now_s = 1e9
    deadline.check()


def test_a_deadline_without_a_limit_never_ends_and_makes_one_slice():
    deadline = Deadline(None, lambda: 1 / 0)
    assert not deadline.is_limited
    assert deadline.elapsed_s() == 0.0
    deadline.check()
    assert list(deadline.slices(range(7, 10**6))) == [range(7, 10**6)]
    assert list(deadline.checked([3, 1])) == [3, 1]
    assert not UNLIMITED.stop[0]


def test_slices_are_all_items_once_and_grow_until_they_take_long():
    clock = Clock()
    deadline = Deadline(10.0, clock)
    deadline.begin_stage(9.0)
    sizes, seen = [], []
    for part in deadline.slices(range(5, 5000)):
        clock.now_s += 1e-5 * len(part)
        sizes.append(len(part))
        seen += part
    assert seen == list(range(5, 5000))
    assert sizes[0] == FIRST_SLICE
    assert 0.5 * SLICE_S <= 1e-5 * max(sizes) <= SLICE_S
    deadline.begin_stage(9.0)
    slow = []
    advanced(clock, deadline.slices(range(200)), slow)
    assert [len(part) for part in slow[:4]] == [64, 32, 16, 8]


def advanced(clock, items, done):
    """Advance the clock by 0.1 s for each item, and keep the items."""
    for item in items:
        clock.now_s += 0.1
        done.append(item)


def test_slices_and_items_end_with_the_stage():
    clock, slices, items = Clock(), [], []
    deadline = Deadline(10.0, clock)
    deadline.begin_stage(0.45)
    with pytest.raises(OutOfTimeError):
        advanced(clock, deadline.slices(range(10_000)), slices)
    assert len(slices) == 5
    deadline.begin_stage(0.95)
    with pytest.raises(OutOfTimeError):
        advanced(clock, deadline.checked(range(100)), items)
    assert len(items) == 5


def test_a_timer_sets_the_flag_of_its_stage_alone():
    deadline = Deadline(60.0)
    deadline.begin_stage(deadline.elapsed_s() + 0.02)
    first = deadline.stop
    end = time.perf_counter() + 30.0
    while not first[0] and time.perf_counter() < end:
        time.sleep(0.005)
    assert first[0]
    with pytest.raises(OutOfTimeError):
        deadline.check()
    deadline.begin_stage(50.0)
    deadline.check()
    assert not deadline.stop[0]
    deadline.begin_stage(math.inf)
    assert np.shares_memory(deadline.stop, first) is False

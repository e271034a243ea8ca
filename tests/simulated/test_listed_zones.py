"""Threads that write constraints, solve zones and update a step never disturb each other."""

import numpy as np
import pytest

from izo_ref.loop.serial.update import measure
from izo_ref.solvers.serial import group_guess
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.zones.serial import listed_zones as listed
from tests.helpers.listed import (
    MOST_LARGE,
    listed_step,
    run,
    solve_large,
    solve_middle,
    solve_small,
    take_answers,
    work_of_group,
    write,
)
from tests.helpers.logged import Log, logged
from validation.scenes.zones import random_zone

SIZES = (1, 9, 2, 3, 61, 1, 10)  # impacts of zones: of all three lists
GUESS_STEPS = 2  # so that the test ends soon


def a_step():
    """Return a step of a few zones, one with a pinned vertex, and none of them solved."""
    rng = np.random.default_rng(5)
    zones = [random_zone(rng, n, fresh_only=True) for n in SIZES]
    zones[2].masses[0] = np.inf
    return listed_step(zones)


def watched(step, log):
    """Return the same step, whose accesses are logged; `values` shares the memory of `counts`."""
    columns = {}
    for name, column in step._asdict().items():
        if isinstance(column, np.ndarray):
            columns[name] = logged(column, log)
        elif name in ("zones", "arrays", "rows", "answers"):
            own = (logged(a, log) if isinstance(a, np.ndarray) else a for a in column)
            columns[name] = column._make(own)
    return step._replace(**columns)


def same(own, other):
    """Check that two steps have the same bits, except for the order of the zones that are left."""
    for name in ("rows", "state"):
        for one, two in zip(getattr(own, name), getattr(other, name), strict=True):
            assert np.array_equal(one, two, equal_nan=one.dtype.kind == "f"), name
    others = [k for k in range(at.N_COUNTS) if k != at.SQUARES]
    assert np.array_equal(own.counts[others], other.counts[others])
    np.testing.assert_allclose(own.values[at.SQUARES], other.values[at.SQUARES], rtol=1e-13)
    n = own.counts[at.LEFT]
    assert np.array_equal(np.sort(own.left[:n]), np.sort(other.left[:n]))


def logged_parts(n_threads, expected):
    """Run each part by a group, and return the logs; the zones are solved by one thread."""
    step, logs = a_step(), [Log(n_threads) for _ in range(3)]
    log = logs[0]
    watched_step = watched(step, log)
    log.run(lambda: write(watched_step, log.group()))
    solve_small(step)
    solve_middle(step)
    solve_large(step)
    log = logs[1]
    watched_step = watched(step, log)
    log.run(lambda: take_answers(watched_step, log.group()))
    same(step, expected)
    log = logs[2]
    own = watched(step, log)
    measured = own.arrays, own.sizes, own.counts, own.values
    log.run(lambda: measure(log.group(), *measured))
    same(step, expected)
    return logs


@pytest.fixture(autouse=True)
def _few_guesses(monkeypatch):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)


@pytest.mark.parametrize("n_threads", [2, 3, 7])
def test_threads_share_a_step_without_conflicts(n_threads):
    expected = a_step()
    run(expected)
    assert expected.counts[at.SOLVED] >= 6
    for log in logged_parts(n_threads, expected):
        assert log.conflicts() == (0, [])


def test_no_wait_can_be_left_out():
    expected = a_step()
    run(expected)
    logs = logged_parts(3, expected)
    assert sum(len([site for site in log.sites.values() if site]) for log in logs) == 2
    for log in logs:
        for site in set(log.sites.values()) - {None}:
            assert log.conflicts(site)[0] > 0, site


def test_groups_take_the_zones_of_a_list_from_each_other():
    """Two groups, one after the other, as blocks do: the second one finds what the first left."""
    expected, step = a_step(), a_step()
    run(expected)
    write(step)
    solve_small(step)
    log = Log(3)
    own, work = watched(step, log), tuple(logged(a, log) for a in work_of_group())

    def call():
        solve_middle(own, log.group(), work=work)
        return solve_middle(own, log.group(), work=work)  # other zones in the same memory

    log.run(call)
    assert log.conflicts() == (0, [])
    assert step.zones.counts[listed.MIDDLE] >= 2
    assert step.sizes[at.TICKET] > 2 * step.zones.counts[listed.MIDDLE]
    solve_large(step)
    take_answers(step)
    same(step, expected)


@pytest.mark.parametrize(("n_threads", "n_teams"), [(4, 2), (6, 3)])
def test_teams_solve_large_zones_together(n_threads, n_teams):
    expected, step = a_step(), a_step()
    run(expected)
    write(step)
    solve_small(step)
    solve_middle(step)
    log = Log(n_threads, n_teams=n_teams)
    own, work = watched(step, log), tuple(logged(a, log) for a in work_of_group(MOST_LARGE))
    log.run(lambda: solve_large(own, log.group(), work=work))
    assert log.conflicts() == (0, [])
    assert step.zones.counts[listed.LARGE] == 1
    take_answers(step)
    same(step, expected)

"""Threads select and group together without conflicts, and find what one thread finds."""

import numpy as np
import pytest

from izo_ref.base.records import no_impacts
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.zones.serial import group_counts as at
from izo_ref.zones.serial.group_select import group_select
from izo_ref.zones.serial.group_zones import group_zones
from tests.helpers.groups import RULE, RULES, Grouping, RecordedStep, Selection, random_case
from tests.helpers.logged import Log, logged

# Impacts, vertices and how many edges the vertices move: few and large zones, many and small ones,
# and deep ones.
SHAPES = [(30, 16, 1.0), (30, 250, 30.0), (30, 60, 1e3)]


def logged_all(arguments, log):
    """Return arguments whose arrays are logged."""
    if isinstance(arguments, np.ndarray):
        return logged(arguments, log)
    if isinstance(arguments, tuple):
        values = [logged_all(argument, log) for argument in arguments]
        return arguments._make(values) if hasattr(arguments, "_make") else tuple(values)
    return arguments


def selected(rng, rule, shape, log):
    """Select by the threads of a log; check the result, and return the case and the step."""
    n, n_vertices, edges = shape
    case = random_case(rng, n, n_vertices, 0.2, 4, edges)
    step = RecordedStep(case, no_impacts(), selection=rule)
    step.select()
    own = Selection(case, no_impacts(), rule, n)
    arguments = logged_all(own.arguments, log)
    log.run(lambda: group_select(log.group(), *arguments))
    assert own.has_entered(step.impacts)
    assert np.array_equal(own.known_depths, step.known_depths)
    assert not own.vertices.marks.any()


def grouped(rng, shape, log):
    """Group by the threads of a log, and check that one thread finds the same."""
    n, n_vertices, _ = shape
    case = random_case(rng, n, n_vertices, 0.2)
    case.stuck[case.found.nodes[0]] = True
    shared = case.found.nodes, case.scene.pinned, case.stuck, 2, RULE, n
    own, expected = Grouping(*shared), Grouping(*shared)
    group_zones(ALONE, *expected.arguments)
    arguments = logged_all(own.arguments, log)
    log.run(lambda: group_zones(log.group(), *arguments))
    assert own.counts.tolist() == expected.counts.tolist()
    for column, values in zip(own.zones(), expected.zones(), strict=True):
        assert np.array_equal(column, values)
    for row, values in zip(own.to_solve(), expected.to_solve(), strict=True):
        assert np.array_equal(row, values)
    assert np.array_equal(own.stuck, expected.stuck)
    assert not own.vertices.marks.any()
    return own


@pytest.mark.parametrize("n_threads", [2, 3, 7])
@pytest.mark.parametrize("rule", RULES)
def test_threads_select_without_conflicts(rng, rule, n_threads):
    for shape in SHAPES:
        log = Log(n_threads)
        selected(rng, rule, shape, log)
        assert log.conflicts() == (0, [])


@pytest.mark.parametrize("n_threads", [2, 3, 7])
def test_threads_group_without_conflicts(rng, n_threads):
    n_stuck = 0
    for shape in SHAPES:
        log = Log(n_threads)
        own = grouped(rng, shape, log)
        assert log.conflicts() == (0, [])
        n_stuck += own.counts[at.ZONES] - own.counts[at.TO_SOLVE]
    assert n_stuck > 0


def waits_without_a_reason(logs):
    """Return the waits that could be left out in all of some runs."""
    sites = {site for log in logs for site in log.sites.values() if site is not None}
    return [s for s in sorted(sites) if not any(log.conflicts(s)[0] for log in logs)]


def test_no_wait_can_be_left_out(rng):
    logs = []
    for shape in SHAPES:
        logs += [Log(3), Log(3)]
        selected(rng, "independent", shape, logs[-2])
        grouped(rng, shape, logs[-1])
    assert waits_without_a_reason(logs) == []

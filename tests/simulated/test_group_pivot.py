"""Threads that share a zone never read or write what another thread writes before they wait."""

import math
from typing import Any

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial import envelope, envelope_solve, group_guess, group_memory, group_order
from izo_ref.solvers.serial import group_pivot as group_pivot_module
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.group_pivot import group_pivot
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import problem_system
from tests.helpers.logged import Log, logged
from validation.scenes.piles import stack_zone
from validation.study import group_zones

LIMITS = Limits(1e-9, 1e-12, 1e4, np.zeros(1, bool))
SEED = 3
GUESS_STEPS = 2  # so that many constraints are exchanged


def solved(seed, group, log, near_size=0):
    """Solve a zone by a group, and return (solved, solves), multipliers and z."""
    problem = stack_zone(np.random.default_rng(seed), 3, 4, 1e3)
    system, _ = problem_system([problem])
    rows, n = scale_constraints(system), len(problem.nodes)
    last = int(system.vertex_offsets[1])
    n_numbers, n_indices = work_of_group_pivot(n, last, envelope.dense_tiles(n))
    own = (rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths)
    own = (*own, system.proposed[:last])
    work = (
        np.full(near_size, np.nan),
        np.full(n_numbers, np.nan),
        np.full(n_indices, -7, np.int32),
        np.zeros(n),
        np.full(3 * last, np.nan),
    )
    arrays = [logged(a, log) if log is not None else a for a in (*own, *work)]

    arguments: list[Any] = [group, 0, n, 0, last, *arrays[:6], LIMITS, *arrays[6:]]

    def call():
        first = group_pivot(*arguments)
        return *first, *group_pivot(*arguments)  # another zone in the same memory

    status = call() if log is None else log.run(call)
    return status, work[3], work[4]


@pytest.fixture(autouse=True)
def _small_tiles(monkeypatch):
    """Use tiles of 4 x 4, so that a zone that is solved in seconds has several tile columns."""
    for module in (envelope, envelope_solve, group_memory, group_order, group_pivot_module):
        for name, value in (("SIDE", 4), ("SHIFT", 2), ("AREA", 16)):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, value)


@pytest.mark.parametrize(
    ("n_threads", "n_teams", "near_size"),
    [(2, 1, 0), (3, 1, 10_000), (7, 1, 0), (2, 2, 0), (6, 2, 0), (6, 3, 0)],
)
def test_threads_share_a_zone_without_conflicts(monkeypatch, n_threads, n_teams, near_size):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    expected, u, z = solved(SEED, ALONE, None)
    assert expected[0]
    assert expected[1] > 3, "constraints are exchanged"
    log = Log(n_threads, n_teams=n_teams)
    results, own_u, own_z = solved(SEED, log.group(), log, near_size)
    assert log.conflicts() == (0, [])
    assert results == [expected] * n_threads
    # Sums over all threads only decide when the zone is done, so the bits are the same.
    assert np.array_equal(own_u, u)
    assert np.array_equal(own_z, z)


def test_no_wait_can_be_left_out(monkeypatch):
    """Some waits are needed between teams only, others in a team of several threads only."""
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    logs = [Log(4), Log(4, n_teams=2), Log(6, n_teams=3)]
    for log in logs:
        solved(SEED, log.group(), log)
    sites = {site for log in logs for site in log.team_sites.values() if site is not None}
    assert len(sites) >= 22
    needless = [s for s in sorted(sites) if not any(log.conflicts(s)[0] for log in logs)]
    assert needless == []


def test_the_study_counts_waits(monkeypatch):
    """The study of lower bounds computes how often a group waits; here it is counted."""
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    monkeypatch.setattr(group_zones, "GUESS_STEPS", GUESS_STEPS)
    log = Log(2)
    (result, _), u, _ = solved(SEED, log.group(), log)
    active, expected = int(np.count_nonzero(u)), 0
    for solves in result[1::2]:  # the zone is solved twice
        own = group_zones.GroupZone(len(u), active, solves, -(-active // 4), 0, 0.0, True)
        expected += group_zones.count_waits(own)
    # Not every solve exchanges constraints, no factor before is larger than the last one, and
    # nothing looks for hopeless constraints here.
    fewer = (group_zones.WAITS_OF_A_SOLVE + 4) * sum(result[1::2])
    assert expected - fewer <= len(log.sites) <= expected


def arrays_of(problem):
    """Return the arrays of a zone that `group_pivot` reads, and u and z, which it writes."""
    system, _ = problem_system([problem])
    rows, last = scale_constraints(system), int(system.vertex_offsets[1])
    own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
    out = np.zeros(len(rows.rhs)), np.full(3 * last, np.nan)
    return (*own, system.proposed[:last]), out


def is_solved(read, out, limits=LIMITS):
    """Return whether one thread solves a zone."""
    n, last = len(out[0]), len(out[1]) // 3
    sizes = work_of_group_pivot(n, last, envelope.dense_tiles(n))
    work = np.zeros(0), np.full(sizes[0], np.nan), np.full(sizes[1], -7, np.int32)
    solved, _ = group_pivot(ALONE, 0, n, 0, last, *read, limits, *work, *out)
    return solved


@pytest.mark.parametrize("sides", [(3, 4), (4, 3)])
def test_zones_of_two_sizes_take_the_same_memory_one_after_the_other(monkeypatch, sides):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    log, zones = Log(3), []
    sizes = work_of_group_pivot(100, 300, envelope.dense_tiles(100))
    work = [logged(np.full(sizes[0], np.nan), log), logged(np.full(sizes[1], -7, np.int32), log)]
    for n_side in sides:
        problem = stack_zone(np.random.default_rng(SEED), 3, n_side, 1e3)
        read, out = arrays_of(problem)
        whole = 0, len(out[0]), 0, len(out[1]) // 3
        own = *read, LIMITS, np.zeros(0), *work, *(logged(a, log) for a in out)
        zones.append((log.group(), *whole, *own))
    log.run(lambda: [group_pivot(*arguments) for arguments in zones])
    assert log.conflicts() == (0, [])


@pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
@pytest.mark.parametrize("factor", [1e-310, 1e-150, 1e150])
def test_zones_of_extraordinary_sizes_are_ordered(factor):
    """At 1e-310, the reciprocal of the length of a zone overflows."""
    zone = stack_zone(np.random.default_rng(SEED), 3, 3, 1e3)
    own = zone.nodes, zone.weights, zone.normals, factor * zone.proposed, zone.masses
    limits = LIMITS._replace(violation=factor * LIMITS.violation)
    scaled = ZoneProblem(*own, factor * zone.thickness)
    assert is_solved(*arrays_of(scaled), limits)


def max_of_gpu(a, b):
    """Return what `max` is on a GPU: the other number, if one is NaN."""
    return b if math.isnan(a) else a if math.isnan(b) else max(a, b)


@pytest.mark.parametrize("largest", [max, max_of_gpu])
@pytest.mark.parametrize("is_rest_satisfied", [False, True])
def test_a_constraint_that_is_not_a_number_leaves_its_zone(monkeypatch, largest, is_rest_satisfied):
    for module in (group_pivot_module, group_guess, group_order):
        monkeypatch.setattr(module, "max", largest, raising=False)
    read, out = arrays_of(stack_zone(np.random.default_rng(SEED), 3, 3, 1e3))
    rhs = read[3]
    if is_rest_satisfied:
        rhs[:] = -1.0
    assert is_solved(read, out)
    rhs[1] = np.nan
    out[0][:] = 0.0
    assert not is_solved(read, out)

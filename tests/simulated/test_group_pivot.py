"""Threads that share a zone never read or write what another thread writes before they wait."""

from typing import Any

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial import group_guess
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.group_pivot import group_pivot
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.zones.system import problem_system
from tests.helpers.logged import Log, logged
from validation.scenes.piles import stack_zone

LIMITS = Limits(1e-9, 1e-12, 1e4, np.zeros(1, bool))
SEED = 3
GUESS_STEPS = 2  # so that many constraints are exchanged


def solved(seed, group, log, near_size=0):
    """Solve a zone by a group, and return (solved, solves), multipliers and z."""
    problem = stack_zone(np.random.default_rng(seed), 3, 4, 1e3)
    system, _ = problem_system([problem])
    rows, n = scale_constraints(system), len(problem.nodes)
    last = int(system.vertex_offsets[1])
    n_numbers, n_indices = work_of_group_pivot(n, last, n)
    own = (rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths)
    work = (
        np.full(near_size, np.nan),
        np.full(n_numbers, np.nan),
        np.full(n_indices, -7, np.int32),
        np.full(n, np.nan),
        np.full(3 * last, np.nan),
    )
    arrays = [logged(a, log) if log is not None else a for a in (*own, *work)]

    arguments: list[Any] = [group, 0, n, 0, last, *arrays[:5], LIMITS, n, *arrays[5:]]

    def call():
        group_pivot(*arguments)
        return group_pivot(*arguments)  # another zone in the same memory

    status = call() if log is None else log.run(call)
    return status, work[3], work[4]


@pytest.mark.parametrize(("n_threads", "near_size"), [(2, 0), (3, 10_000), (7, 0)])
def test_threads_share_a_zone_without_conflicts(monkeypatch, n_threads, near_size):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    expected, u, z = solved(SEED, ALONE, None)
    assert expected[0]
    assert expected[1] > 3, "constraints are exchanged"
    log = Log(n_threads)
    results, own_u, own_z = solved(SEED, log.group(), log, near_size)
    assert log.conflicts() == (0, [])
    assert results == [expected] * n_threads
    # Sums over all threads only decide when the zone is done, so the bits are the same.
    assert np.array_equal(own_u, u)
    assert np.array_equal(own_z, z)


def test_no_wait_can_be_left_out(monkeypatch):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    log = Log(3)
    solved(SEED, log.group(), log)
    sites = {site for site in log.sites.values() if site is not None}
    assert len(sites) >= 12
    assert [site for site in sorted(sites) if log.conflicts(site)[0] == 0] == []

"""Compiled loops that may run for long: a flag ends them, also while they run."""

import threading
import time

import numpy as np
import pytest

from izo_ref import Options
from izo_ref.base.deadline import Deadline, OutOfTimeError
from izo_ref.solvers.large_zone import solve_large_zone
from izo_ref.solvers.serial.dense import (
    LARGE,
    partial_cholesky,
    stoppable_cholesky,
    work_of_cholesky,
)
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.system import problem_system
from tests.helpers.shapes import large_zone, random_problem

LONG_S = 60.0  # a loop that nothing ended would take longer
SOON_S = 0.01  # after which the flag is set; the shortest of the runs takes some 0.05 s
METHODS = {
    # No method reaches a gap of 0. Sweeps go on for ever, and gradient descent for 2000 steps at
    # least.
    "pgs": {"gap_tolerance": 0.0, "max_steps": 10**9},
    "apgs": {"gap_tolerance": 0.0, "max_steps": 10**9},
    "gradient": {"gap_tolerance": 0.0, "violation_tolerance": 1e-300, "max_steps": 10**8},
}


@pytest.mark.parametrize("method", [*METHODS, "newton", "active-set", "interior-point", "auto"])
def test_a_flag_that_is_set_ends_a_solve_at_once(rng, method):
    """The flag is set before the solve: no method begins another step, and no answer is used."""
    system, _ = problem_system([random_problem(rng, 300)])
    deadline = Deadline(1e6, lambda: 0.0)
    deadline.begin_stage(1e5)
    options = Options(method=method, **METHODS.get(method, {}))
    deadline.stop[0] = True
    with pytest.raises(OutOfTimeError):
        solve_system(system, options, deadline=deadline)


@pytest.mark.parametrize("method", METHODS)
def test_a_flag_that_is_set_later_ends_a_running_loop(rng, method):
    """Compiled code must read the flag anew in each step, and not keep it in a register."""
    system, _ = problem_system([random_problem(rng, 2000)])
    options = Options(method=method, **METHODS[method])
    warm = Options(method=method, **(METHODS[method] | {"max_steps": 2}))
    solve_system(system, warm)  # so that nothing is compiled in the measured time
    deadline = Deadline(1e6, lambda: 0.0)
    deadline.begin_stage(1e5)
    timer = threading.Timer(SOON_S, deadline.stop.__setitem__, (0, True))
    timer.start()
    begin = time.perf_counter()
    with pytest.raises(OutOfTimeError):
        solve_system(system, options, deadline=deadline)
    assert 0.5 * SOON_S < time.perf_counter() - begin < LONG_S


def test_the_interior_point_ends_between_its_iterations(rng):
    zone, readings = large_zone(random_problem(rng, 300)), []

    def clock():
        readings.append(0)
        return 0.0 if len(readings) < 12 else 1e9

    deadline = Deadline(10.0, clock)
    deadline.begin_stage(9.0)
    with pytest.raises(OutOfTimeError):
        solve_large_zone(zone, np.zeros(300), 1e-9, 1e-12, True, deadline=deadline)


def test_a_factorisation_that_may_be_stopped_has_the_same_bits(rng):
    for n, pivots in ((7, 5), (LARGE + 37, LARGE + 37), (LARGE + 90, LARGE)):
        a = rng.normal(size=(n, n))
        a = a @ a.T + n * np.eye(n)
        whole, stoppable, stopped = a.copy(), a.copy(), a.copy()
        work = np.empty(work_of_cholesky(n))
        partial_cholesky(whole, n, pivots, 0.0, work)
        stoppable_cholesky(stoppable, n, pivots, 0.0, work, np.zeros(1, bool))
        np.testing.assert_array_equal(whole, stoppable)
        stoppable_cholesky(stopped, n, pivots, 0.0, work, np.ones(1, bool))
        assert np.array_equal(stopped, a) == (n >= LARGE)

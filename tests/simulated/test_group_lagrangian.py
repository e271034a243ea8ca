"""Threads that share a zone of an augmented-Lagrangian method have no conflicts."""

import numpy as np
import pytest

from izo_ref import Options
from izo_ref.solvers.augmented_lagrangian import descend, make_work_space
from izo_ref.solvers.presets import METHOD_PARAMETERS, PRESETS
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.descent import minimise_zone
from izo_ref.zones.system import problem_system
from tests.helpers.logged import Log, logged
from tests.helpers.shapes import random_problem

# In compiled code, x / 0 is inf without a warning; in Python numpy warns.
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
SEED, IMPACTS, STEPS = 5, 4, 8
NAMED = [*({"method": name} for name in METHOD_PARAMETERS), *({"preset": name} for name in PRESETS)]


def minimised(named, n_threads, seed):
    """Solve a zone by threads that share it; return their log."""
    problem = random_problem(np.random.default_rng(SEED), IMPACTS, mass_ratio=1e3)
    system, _ = problem_system([problem])
    log = Log(n_threads, seed)

    def solve(inputs, settings, results):
        work = make_work_space(inputs, inputs.memory_offsets[-1], n_threads, np.zeros)
        own = [
            record._replace(
                **{
                    name: logged(array, log)
                    for name, array in record._asdict().items()
                    if array.size and name != "states"
                }
            )
            for record in (inputs, results, work)
        ]
        group = log.group()

        def call():
            state = work.states[0, group.rank()]
            minimise_zone(0, state, group, own[0], settings, own[1], own[2])

        log.run(call)

    options = Options(**named, max_steps=STEPS)
    descend(system, options, scale_constraints(system), solve=solve)
    return log


@pytest.mark.parametrize("named", NAMED, ids=lambda named: "-".join(named.values()))
@pytest.mark.parametrize("n_threads", [2, 5])
def test_threads_share_a_zone_without_conflicts(rng, named, n_threads):
    seed = int(rng.integers(2**31))
    print(f"seed of the schedule: {seed}")
    log = minimised(named, n_threads, seed)
    assert log.conflicts() == (0, [])
    assert len(log.sites) > STEPS


def test_no_wait_can_be_left_out():
    needed, sites = set(), set()
    for named in NAMED:
        log = minimised(named, 3, 1)
        own = {site for site in log.sites.values() if site is not None}
        sites |= own
        needed |= {site for site in own - needed if log.conflicts(site)[0]}
    assert len(sites) >= 5
    assert sites - needed == set()

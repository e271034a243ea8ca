"""The update of a step after its zones are solved, on one thread."""

import numpy as np

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.loop.serial.update import measure
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.zones.objective import objective
from izo_ref.zones.serial import listed_zones as listed
from tests.helpers.listed import (
    listed_step,
    run,
    solve_middle,
    solve_small,
    take_answers,
    write,
)
from validation.scenes.zones import random_zone


def a_step(rng):
    """Return a step of some zones, with pinned vertices, and the large zone, which is left."""
    zones = [random_zone(rng, n, mass_ratio=1e3, fresh_only=True) for n in (1, 2, 5, 9, 20, 61)]
    zones[1].masses[0] = np.inf
    step = listed_step(zones)
    write(step)
    solve_small(step)
    solve_middle(step)
    take_answers(step)
    return step, step.left[: step.counts[at.LEFT]]


def test_the_objective_is_that_of_the_cpu(rng):
    step, _ = a_step(rng)
    mass = step.arrays.masses.sum()
    expected = objective(step.scene, step.arrays.positions)
    assert expected > 0.0
    # Both sum n terms that are not negative, in other orders.
    n = len(step.arrays.masses)
    found = step.values[at.SQUARES] / mass
    assert abs(found - expected) <= 4.0 * n * 2.0**-53 * expected


def test_active_impacts_are_counted(rng):
    step, left = a_step(rng)
    assert len(left) > 0
    assert step.counts[at.ACTIVE] == np.count_nonzero(step.arrays.active) > 0


def test_a_step_is_measured_again_after_the_cpu_has_changed_it(rng):
    step, left = a_step(rng)
    solved, squares = step.counts[at.SOLVED], step.values[at.SQUARES]
    own = step.on_cpu.impacts_of(left[0])
    step.arrays.active[own[:2]] = True
    vertex = step.on_cpu.vertices_of(left[0])[0]
    step.arrays.positions[vertex] = step.arrays.proposed[vertex] + (0.0, 3.0, 4.0)
    before = step.counts[at.ACTIVE]
    measured = step.arrays, step.sizes, step.counts, step.values
    measure(ALONE, *measured)
    assert step.counts[at.ACTIVE] == before + 2
    assert step.counts[at.SOLVED] == solved
    added = 25.0 * step.arrays.masses[vertex]
    np.testing.assert_allclose(step.values[at.SQUARES], squares + added, rtol=1e-13)


def test_a_step_without_zones_is_measured(rng):
    """Nothing is grouped if no impact is new, and the active impacts are those of before."""
    step, _ = a_step(rng)
    active, squares = step.counts[at.ACTIVE], step.values[at.SQUARES]
    step.zones.counts[listed.ZONES :] = 0
    assert len(run(step)) == 0
    assert step.counts[at.SOLVED] == 0
    assert step.counts[at.ACTIVE] == active > 0
    assert step.values[at.SQUARES] == squares > 0.0

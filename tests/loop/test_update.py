"""The update of a step after its zones are solved, on one thread."""

import numpy as np

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.loop.serial.update import measure
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.zones.objective import objective
from izo_ref.zones.serial import listed_zones as listed
from tests.helpers.listed import listed_step, run
from validation.scenes.zones import random_zone


def a_step(rng):
    """Return a step of some zones, with pinned vertices, that are solved as far as possible."""
    zones = [random_zone(rng, n, mass_ratio=1e3, fresh_only=True) for n in (1, 2, 5, 9, 20, 61)]
    zones[1].masses[0] = np.inf
    step = listed_step(zones)
    return step, run(step)


def test_the_objective_is_that_of_the_cpu(rng):
    step, _ = a_step(rng)
    mass = step.inputs.masses.sum()
    expected = objective(step.scene, step.state.positions)
    assert expected > 0.0
    # Both sum n terms that are not negative, in other orders.
    n = len(step.inputs.masses)
    found = step.values[at.SQUARES] / mass
    assert abs(found - expected) <= 4.0 * n * 2.0**-53 * expected


def test_active_impacts_are_counted(rng):
    step, left = a_step(rng)
    assert len(left) > 0
    assert step.counts[at.ACTIVE] == np.count_nonzero(step.state.active) > 0


def test_a_step_is_measured_again_after_the_cpu_has_changed_it(rng):
    step, left = a_step(rng)
    solved, squares = step.counts[at.SOLVED], step.values[at.SQUARES]
    own = step.on_cpu.impacts_of(left[0])
    step.state.active[own[:2]] = True
    vertex = step.on_cpu.vertices_of(left[0])[0]
    step.state.positions[vertex] = step.inputs.proposed[vertex] + (0.0, 3.0, 4.0)
    before = step.counts[at.ACTIVE]
    measured = step.inputs, step.sizes, step.state, step.counts, step.values
    measure(ALONE, *measured)
    assert step.counts[at.ACTIVE] == before + 2
    assert step.counts[at.SOLVED] == solved
    added = 25.0 * step.inputs.masses[vertex]
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

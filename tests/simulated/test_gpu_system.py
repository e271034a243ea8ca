"""Zones of a system on a GPU are solved by the launches of a step."""

import numpy as np
import pytest

from izo_ref.base.options import Options
from izo_ref.solvers import gpu_pivoting as pivoting
from izo_ref.solvers import gpu_solve
from izo_ref.solvers.serial import group_guess
from izo_ref.solvers.solve import solve_system, solve_zone
from izo_ref.zones.system import problem_system
from tests.helpers.listed import leave_larger_zones
from validation.scenes.zones import random_zone

SIZES = 1, 3, 9, 20, 1, 24  # impacts of zones: of all three lists
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.fixture(autouse=True)
def _small_limits(monkeypatch):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", 3)
    monkeypatch.setattr(gpu_solve, "SMALL", 4)
    monkeypatch.setattr(pivoting, "LARGEST", 20)
    monkeypatch.setattr(pivoting, "THREADS", 2)


def a_system(rng):
    """Return zones side by side, one with a pinned vertex."""
    zones = [random_zone(rng, n, fresh_only=True) for n in SIZES]
    zones[1].masses[0] = np.inf
    return problem_system(zones)[0]


@pytest.mark.parametrize("left", [False, True])
def test_zones_end_near_the_cpu(rng, monkeypatch, left):
    """The CPU solves what there is no room for."""
    system = a_system(rng)
    if left:
        leave_larger_zones(monkeypatch, pivoting)
    found, expected = (
        solve_system(system, Options(), device="cuda"),
        solve_system(system, Options()),
    )
    assert found.feasible.all()
    assert expected.feasible.all()
    is_larger = np.array(SIZES) > 4
    assert (found.methods[is_larger] != "block-pivot").all() == left
    assert (found.methods[~is_larger] == "block-pivot").all()
    n = int(system.vertex_offsets[-1])
    mass = system.masses[:n, None]
    apart = np.sqrt((mass * (found.displacements - expected.displacements)[:n] ** 2).sum())
    # Both have a gap of at most 1e-9, so each is within sqrt(2e-9) of the distance to the optimum.
    assert apart <= 2.0 * np.sqrt(2e-9 * (mass * expected.displacements[:n] ** 2).sum())


def test_a_system_begins_at_its_last_solution(rng):
    system = a_system(rng)
    first = solve_system(system, Options(), device="cuda")
    again = solve_system(system, Options(), start=first.multipliers, device="cuda")
    is_larger = np.array(SIZES) > 4
    assert again.feasible.all()
    assert (again.iterations <= first.iterations)[is_larger].all()
    assert again.iterations[is_larger].sum() < first.iterations[is_larger].sum()


def test_one_zone_is_solved(rng):
    problem = random_zone(rng, 12, fresh_only=True)
    found = solve_zone(problem, device="cuda")
    assert found.feasible
    assert found.method == "block-pivot"
    assert found.residuals.solved(1e-9, 1e-9)

"""Large zones: which of two methods solves them, and that both end at the optimum."""

import numpy as np
import pytest

from izo_ref.solvers import large_zone as large
from izo_ref.solvers.large_zone import is_entangled, solve_large_zone
from izo_ref.solvers.solve import solve_zone
from tests.helpers.shapes import large_zone, random_problem
from validation.scenes.piles import chain_zone, stack_zone
from validation.scenes.zones import random_zone


def test_layers_and_chains_are_not_entangled_and_random_zones_are(rng):
    assert not is_entangled(large_zone(chain_zone(rng, 500)))
    assert not is_entangled(large_zone(stack_zone(rng, 5, 12)))
    assert is_entangled(large_zone(random_problem(rng, 300)))


@pytest.mark.parametrize(
    ("make", "method"), [(random_problem, "apgs"), (chain_zone, "interior-point")]
)
def test_both_ways_end_at_the_optimum(rng, make, method):
    problem = make(rng, 600)
    found = solve_zone(problem, tolerance=1e-10)
    assert found.method == method
    assert found.residuals.solved(1e-10, 1e-10)
    alone = solve_zone(problem, "interior-point", tolerance=1e-10)
    assert alone.method == "interior-point"
    size = np.linalg.norm(alone.displacements)
    # Each solution is within the square root of its gap.
    assert np.linalg.norm(found.displacements - alone.displacements) <= 4e-5 * size


def test_sweeps_that_do_not_end_give_the_interior_point_a_start(rng, monkeypatch):
    """Redundant impacts hinder sweeps, whose number is limited by the size of the zone."""
    zone, counts = large_zone(random_zone(rng, 257)), []
    sweep = large._sweep
    monkeypatch.setattr(large, "_sweep", lambda *given: counts.append(given[1]) or sweep(*given))
    start = np.zeros(len(zone.rhs))
    solution = solve_large_zone(zone, start, 1e-12, 1e-12 * zone.lengths.max(), False)
    assert solution.solved
    assert solution.method == "interior-point"
    assert counts == [257**2 // 500]


def test_a_shared_pinned_vertex_does_not_entangle_a_zone(rng):
    """All impacts share one pinned vertex, which is not an unknown and so connects nothing."""
    problem = chain_zone(rng, 200)
    n = len(problem.masses)
    nodes = problem.nodes.copy()
    nodes[:, 3] = n
    proposed = np.vstack((problem.proposed, problem.proposed[-1]))
    masses = np.append(problem.masses, np.inf)
    shared = type(problem)(
        nodes, problem.weights, problem.normals, proposed, masses, problem.thickness
    )
    assert not is_entangled(large_zone(shared))


def test_an_infeasible_zone_is_reported_unsolved(rng):
    problem = chain_zone(rng, 50)
    nodes, weights = (np.concatenate((a, a)) for a in (problem.nodes, problem.weights))
    normals = np.concatenate((problem.normals, -problem.normals))
    opposed = type(problem)(
        nodes, weights, normals, problem.proposed, problem.masses, problem.thickness
    )
    zone = large_zone(opposed)
    *_, solved = solve_large_zone(
        zone, np.zeros(len(zone.rhs)), 1e-9, 1e-9 * problem.thickness, False
    )
    assert not solved

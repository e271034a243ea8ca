"""Large zones: which of two methods solves them, and that both end at the optimum."""

from fractions import Fraction

import numpy as np
import pytest

from izo_ref.solvers import large_zone as large
from izo_ref.solvers.interior_point import interior_point
from izo_ref.solvers.large_zone import is_entangled, solve_large_zone
from izo_ref.solvers.solve import solve_zone
from tests.helpers.shapes import large_zone, random_problem
from validation.oracles.rational import ExactZone
from validation.scenes.piles import chain_zone, stack_zone
from validation.scenes.stiff_zones import copied_zone, slab_zone, wedge_zone
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


DEEP_M = 500.0  # rounding at this size is half of the tolerance at a thickness of 1e-4 m


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("make", "size"), [(chain_zone, (400,)), (stack_zone, (6, 12))])
def test_impacts_far_deeper_than_the_thickness_are_solved_to_the_same_tolerance(make, size, seed):
    drawn = make(np.random.default_rng(seed), *size)
    scale = DEEP_M / (-drawn.gaps(drawn.proposed)).max()
    zone = large_zone(
        type(drawn)(
            drawn.nodes, drawn.weights, drawn.normals, scale * drawn.proposed, drawn.masses, 1e-4
        )
    )
    tolerance_m = 1e-9 * 1e-4
    first = solve_large_zone(zone, np.zeros(len(zone.rhs)), 1e-9, tolerance_m, False)
    again = solve_large_zone(zone, 1.1 * first.multipliers, 1e-9, tolerance_m, False)
    for solution in (first, again):
        assert solution.solved
        # exact sums, because those of floats have a rounding of the size of the tolerance
        assert violation_m(zone, solution.z) <= tolerance_m
        slack = zone.times(solution.z) - zone.rhs
        gap = 2.0 * (solution.multipliers * np.abs(slack)).sum() / (solution.z**2).sum()
        assert gap <= 1e-9


def violation_m(zone, z):
    """Return the largest violation of a zone [m], with exact products and sums."""
    largest = 0.0
    for nodes, coefficients, normal, s, length in zip(*zone[:5], strict=True):
        terms = [
            Fraction(float(c)) * Fraction(float(n)) * Fraction(float(z[3 * node + axis]))
            for node, c in zip(nodes, coefficients, strict=True)
            if node >= 0
            for axis, n in enumerate(normal)
        ]
        largest = max(largest, float(Fraction(float(s)) - sum(terms)) * length)
    return largest


def miss(monkeypatch, *by_m):
    """Let the first calls of the interior point miss by distances; return the list of calls."""
    calls, exact = [], large.interior_point

    def missing(zone, *given):
        z, multipliers, steps, solved = exact(zone, *given)
        calls.append(zone)
        if len(calls) <= len(by_m):
            off = zone.times(z) - zone.rhs
            worst = int(np.argmin(off))
            z, solved = z.copy(), False
            at = 3 * zone.nodes[worst, 0]
            row = zone.coefficients[worst, 0] * zone.normals[worst]
            z[at : at + 3] -= (
                row * (by_m[len(calls) - 1] / zone.lengths[worst] + off[worst]) / (row @ row)
            )
        return z, multipliers, steps, solved

    monkeypatch.setattr(large, "interior_point", missing)
    return calls


def test_a_zone_that_is_missed_by_little_is_aimed_at_again(rng, monkeypatch):
    problem = chain_zone(rng, 400)
    zone, tolerance_m = large_zone(problem), 1e-9 * problem.thickness
    calls = miss(monkeypatch, 3.0 * tolerance_m)
    solution = solve_large_zone(zone, np.zeros(400), 1e-9, tolerance_m, False)
    assert solution.solved
    assert violation_m(zone, solution.z) <= tolerance_m
    aimed_beyond = (calls[1].rhs - zone.rhs) * zone.lengths
    assert len(calls) == 2
    assert np.allclose(aimed_beyond, 6.0 * tolerance_m, rtol=1e-3)


@pytest.mark.parametrize(("second", "n_calls"), [(5.5, 2), (6.5, 2), (8.0, 3)])
def test_an_aim_beyond_may_be_missed_as_long_as_the_zone_is_not(rng, monkeypatch, second, n_calls):
    """The second aim is 6 tolerances beyond, so up to 7 may be missing there."""
    problem = chain_zone(rng, 400)
    zone, tolerance_m = large_zone(problem), 1e-9 * problem.thickness
    calls = miss(monkeypatch, 3.0 * tolerance_m, second * tolerance_m)
    solution = solve_large_zone(zone, np.zeros(400), 1e-9, tolerance_m, False)
    assert solution.solved
    assert len(calls) == n_calls
    assert violation_m(zone, solution.z) <= tolerance_m


def test_a_zone_that_is_missed_by_far_is_not_solved_again(rng, monkeypatch):
    problem = chain_zone(rng, 400)
    zone, tolerance_m = large_zone(problem), 1e-9 * problem.thickness
    calls = miss(monkeypatch, 1e3 * tolerance_m)
    assert not solve_large_zone(zone, np.zeros(400), 1e-9, tolerance_m, False).solved
    assert len(calls) == 1


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


@pytest.mark.parametrize(("copies", "method"), [(1, "pivoting"), (7, "interior-point")])
def test_a_zone_with_more_impacts_than_unknowns_is_not_pivoted(rng, copies, method):
    drawn = chain_zone(rng, 400)  # 2406 unknowns
    columns = (drawn.nodes, drawn.weights, drawn.normals)
    columns = (np.concatenate((column,) * copies) for column in columns)
    zone = large_zone(type(drawn)(*columns, drawn.proposed, drawn.masses, drawn.thickness))
    assert (len(zone.rhs) >= 3 * zone.n_vertices) == (method != "pivoting")
    tolerance_m = 1e-9 * drawn.thickness
    first = solve_large_zone(zone, np.zeros(len(zone.rhs)), 1e-9, tolerance_m, False)
    again = solve_large_zone(zone, 1.1 * first.multipliers, 1e-9, tolerance_m, False)
    assert again.solved
    assert again.method == method


@pytest.mark.parametrize("copies", [1, 2, 40])
def test_the_interior_point_solves_a_zone_that_sweeps_solve_exactly(rng, copies):
    """Then all slacks are zero or rounding, and it could not begin."""
    problem = copied_zone(rng, wedge_zone(rng, 0.0), copies)
    found = solve_zone(problem, "interior-point")
    zone = ExactZone(problem)
    optimum = zone.solve()
    assert found.residuals.solved(1e-9, 1e-9)
    assert zone.relative_error(found.displacements, optimum) <= 1e-14


@pytest.mark.parametrize("unit", [2.0**-20, 2.0**10])
def test_the_interior_point_takes_the_same_iterations_in_any_unit(rng, unit):
    zone = large_zone(chain_zone(rng, 300))
    u = np.maximum(zone.rhs, 0.0)
    z, multipliers, *counts = interior_point(zone, (zone.pull(u), u), 1e-9, 1e-9)
    other = zone._replace(rhs=unit * zone.rhs)
    start = other.pull(unit * u), unit * u
    z_there, multipliers_there, *counts_there = interior_point(other, start, 1e-9, unit * 1e-9)
    assert counts == counts_there
    np.testing.assert_array_equal(z_there, unit * z)
    np.testing.assert_array_equal(multipliers_there, unit * multipliers)


@pytest.mark.parametrize("mass_ratio", [1e8, 1e10, 1e12])
@pytest.mark.parametrize("width", [-10.0, -0.1])
def test_a_light_vertex_moves_heavy_faces_apart(rng, width, mass_ratio):
    """In the norm of the masses that is far, 1e6 times as far as the light vertex alone goes."""
    problem = slab_zone(rng, width, mass_ratio)
    found, zone = solve_zone(problem), ExactZone(problem)
    assert found.feasible
    assert found.residuals.solved(1e-9, 1e-9)
    # the condition number is some 1e12 at most, so rounding leaves up to 1e-10
    assert zone.relative_error(found.displacements, zone.solve()) <= 1e-10

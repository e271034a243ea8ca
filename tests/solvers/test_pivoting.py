"""Pivoting from the solution of a zone with fewer impacts to one with more."""

import numpy as np
import pytest

from izo_ref.solvers.large_zone import solve_large_zone
from izo_ref.solvers.pivoting import first_of_neighbours, pivot_from, polish
from izo_ref.solvers.scaled_constraints import LargeZone
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from tests.helpers.shapes import large_zone
from validation.scenes.piles import chain_zone, stack_zone

GAP, VIOLATION = 1e-10, 1e-12  # violation in the unit of rhs, whose largest entry is about 1e-2


def without(zone, rows):
    """Return the zone without the constraints that are flagged in `rows`, (m,) b1."""
    parts = (zone.nodes, zone.coefficients, zone.normals, zone.rhs, zone.lengths)
    return LargeZone(*(part[~rows] for part in parts), zone.n_vertices)


def repeated(zone):
    """Return the zone with each constraint twice."""
    parts = (zone.nodes, zone.coefficients, zone.normals, zone.rhs, zone.lengths)
    return LargeZone(*(np.concatenate((part, part)) for part in parts), zone.n_vertices)


def solved(zone):
    """Return z and the multipliers by the interior point, with 0 for inactive constraints."""
    violation_m = VIOLATION * zone.lengths.max()
    z, u, _, _, done = solve_large_zone(zone, np.zeros(len(zone.rhs)), GAP, violation_m, True)
    assert done
    return z, np.where(u > zone.times(z) - zone.rhs, u, 0.0)


def start_without(zone, new):
    """Return the multipliers of the solution without the constraints flagged in `new`."""
    start = np.zeros(len(new))
    start[~new] = solved(without(zone, new))[1]
    return start


def assert_same(zone, found, z):
    """Check multipliers that prove the gap, and z within the square root of both gaps."""
    found_z, u, _ = found
    assert (u >= 0.0).all()
    assert (zone.rhs - zone.times(found_z)).max() <= VIOLATION
    gap = np.sum(u * np.abs(zone.times(found_z) - zone.rhs))
    assert gap <= GAP * 0.5 * np.sum(found_z**2)
    assert np.linalg.norm(found_z - z) <= 4.0 * np.sqrt(GAP) * np.linalg.norm(z)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.3])
def test_new_constraints_are_added_to_a_solution(rng, share):
    zone = large_zone(chain_zone(rng, 400))
    z, _ = solved(zone)
    found = pivot_from(zone, start_without(zone, rng.random(len(zone.rhs)) < share), GAP, VIOLATION)
    assert found is not None
    assert_same(zone, found, z)


def test_redundant_constraints_do_not_prevent_the_optimum(rng):
    zone = large_zone(stack_zone(rng, 6, 12))
    z, u = solved(zone)
    found = pivot_from(repeated(zone), np.concatenate((u, np.zeros(len(u)))), GAP, VIOLATION)
    assert found is not None
    assert_same(repeated(zone), found, z)


def test_a_far_start_ends_at_the_optimum_or_gives_up(rng):
    zone = large_zone(chain_zone(rng, 400))
    z, _ = solved(zone)
    ended = 0
    for _ in range(20):
        found = pivot_from(zone, rng.random(len(zone.rhs)), GAP, VIOLATION)
        if found is not None:
            ended += 1
            assert_same(zone, found, z)
    assert ended > 0


@pytest.mark.parametrize("share", [0.001, 0.01, 0.1])
def test_new_constraints_of_a_pile_in_full_contact_are_added(rng, share):
    """The layers support each other in many ways, so sets of constraints could repeat for ever."""
    zone = large_zone(stack_zone(rng, 6, 12))
    z, _ = solved(zone)
    found = pivot_from(zone, start_without(zone, rng.random(len(zone.rhs)) < share), GAP, VIOLATION)
    assert found is not None
    assert_same(zone, found, z)


@pytest.mark.parametrize(
    ("by", "first"),
    [([5.0, 1.0, 9.0, 9.0, 2.0, 2.0], [2, 4, 5]), ([9.0, 4.0, 1.0, 0.0, 2.0, 3.0], [0, 1, 4]),
     (None, [2, 4, 5])],
)  # fmt: skip
def test_no_neighbours_change_sides_together(by, first):
    """Constraints that share a pinned vertex only are no neighbours."""
    pairs = [[0, 1], [8, 9], [1, 2], [2, 3], [6, 7], [9, 8]]
    nodes = np.array([[*pair, -1, -1] for pair in pairs], np.int32)
    ones = np.ones((6, 4))
    zone = LargeZone(nodes, ones, ones[:, :3], ones[:, 0], ones[:, 0], 10)
    wrong = np.array([True, True, True, False, True, True])
    found = first_of_neighbours(zone, wrong, None if by is None else np.array(by))
    np.testing.assert_array_equal(np.flatnonzero(found), first)


def test_rounding_does_not_hold_up_an_answer_that_is_within_tolerance(rng):
    zone = large_zone(chain_zone(rng, 400))
    z, u = solved(zone)
    gap, violation = 3e-14, 3e-14  # a hundredth of it is below rounding
    found = pivot_from(zone, u, gap, violation)
    assert found is not None
    assert (zone.rhs - zone.times(found[0])).max() <= violation
    assert_same(zone, found, z)


def test_an_infeasible_zone_is_given_up(rng):
    zone = large_zone(chain_zone(rng, 50))
    opposed = repeated(zone)._replace(normals=np.concatenate((zone.normals, -zone.normals)))
    _, u = solved(zone)
    assert pivot_from(opposed, np.concatenate((u, u)), GAP, VIOLATION) is None


def test_the_same_start_ends_in_the_same_bits(rng):
    zone = large_zone(chain_zone(rng, 400))
    start = start_without(zone, np.arange(len(zone.rhs)) % 10 == 0)
    once, again = (pivot_from(zone, start, GAP, VIOLATION) for _ in range(2))
    np.testing.assert_array_equal(once[0], again[0])
    np.testing.assert_array_equal(once[1], again[1])


@pytest.mark.parametrize("mass_ratio", [1.0, 1e6, 1e12])
@pytest.mark.parametrize("make", [chain_zone, lambda rng, _, m: stack_zone(rng, 3, 11, m)])
def test_a_large_zone_is_proved_to_end_at_the_optimum(rng, make, mass_ratio):
    """The interior point alone ends 1e-9 to 4e-6 away, with a gap below 1e-11."""
    problem = make(rng, 300, mass_ratio)
    found = solve_zone(problem)
    assert found.method == "interior-point"
    moves = found.displacements
    bound = distance_bound(problem, found.positions, found.multipliers, moves)
    unpinned = np.isfinite(problem.masses)
    size = np.sqrt((problem.masses[unpinned, None] * moves[unpinned] ** 2).sum())
    # the bound itself has the rounding of C, up to 5e-11 of the answer where C is worst
    assert bound <= 1e-9 * size


def test_polishing_keeps_what_came_in_if_it_finds_nothing_better(rng):
    zone = large_zone(chain_zone(rng, 50))
    z, u = solved(zone)
    z, u = polish(zone, z, u, VIOLATION)
    again = polish(zone, z, u, VIOLATION)
    size = np.linalg.norm(z)
    assert np.linalg.norm(again[0] - z) <= 1e-13 * size
    nowhere = np.zeros_like(z), np.zeros_like(u)  # no constraint is active, and most are violated
    kept = polish(zone._replace(rhs=np.where(u > 0.0, zone.rhs, 1.0)), *nowhere, 1e-30)
    np.testing.assert_array_equal(kept[0], nowhere[0])
    np.testing.assert_array_equal(kept[1], nowhere[1])

"""Zones: connected components of impacts, and the problems that they state."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.system import problem_system, zone_system
from tests.helpers.shapes import random_problem, two_sheets
from tests.naive.groups import components


class Vertices:
    """The part of a scene that zones read."""

    def __init__(self, n, pinned=()):
        self.pinned = np.zeros(n, bool)
        self.pinned[list(pinned)] = True


def impacts_of(nodes):
    """Return impacts of the given vertices, without weights and normals."""
    nodes = np.array(nodes, np.int32).reshape(-1, 4)
    n = len(nodes)
    return Impacts(nodes, np.zeros(n, bool), np.zeros(n), np.zeros((n, 4)), np.zeros((n, 3)))


@pytest.mark.parametrize("n", [0, 1, 10, 60])
def test_zones_are_connected_components(rng, n):
    for _ in range(20):
        k = 4 + 3 * n
        nodes = [rng.choice(k, 4, replace=False) for _ in range(n)]
        scene = Vertices(k, np.flatnonzero(rng.random(k) < 0.3))
        impacts = impacts_of(nodes)
        zones = izo_ref.build_zones(scene, impacts)
        found = {frozenset(zones.impacts_of(z).tolist()) for z in range(len(zones))}
        assert found == {frozenset(group) for group in components(impacts.nodes, scene.pinned)}
        for z in range(len(zones)):
            own = np.unique(impacts.nodes[zones.impacts_of(z)])
            assert zones.vertices_of(z).tolist() == own[~scene.pinned[own]].tolist()
            assert (np.diff(zones.impacts_of(z)) > 0).all()


def test_a_long_chain_in_the_worst_order_is_one_zone():
    """Merging in one pass, or to a fixed depth, would split this chain."""
    n = 500
    links = [(3 * i, 3 * i + 1, 3 * i + 2, 3 * i + 3) for i in range(n)]
    order = np.argsort(np.arange(n) * 7919 % n)
    zones = izo_ref.build_zones(Vertices(3 * n + 1), impacts_of([links[i] for i in order]))
    assert len(zones) == 1
    assert len(zones.vertices) == 3 * n + 1


def test_a_thousand_zones_are_found():
    zones = izo_ref.build_zones(Vertices(4000), impacts_of(np.arange(4000).reshape(-1, 4)))
    assert len(zones) == 1000


def test_pinned_vertices_do_not_join_zones():
    nodes = [[0, 1, 2, 3], [4, 5, 6, 3]]
    assert len(izo_ref.build_zones(Vertices(7), impacts_of(nodes))) == 1
    assert len(izo_ref.build_zones(Vertices(7, [3]), impacts_of(nodes))) == 2


def test_impacts_of_pinned_vertices_only_are_in_no_zone():
    zones = izo_ref.build_zones(Vertices(8, range(4)), impacts_of([[0, 1, 2, 3], [4, 5, 6, 7]]))
    assert zones.impacts.tolist() == [1]


def test_a_zone_problem_equals_its_part_of_the_system(rng):
    scene = two_sheets(rng, pinned_below=True)
    impacts = izo_ref.find_impacts(scene)
    zones = izo_ref.build_zones(scene, impacts)
    system = zone_system(scene, impacts, zones, 1e-3)
    for z in range(len(zones)):
        problem = izo_ref.zone_problem(scene, impacts, zones, z, 1e-3)
        rows = slice(*system.impact_offsets[z : z + 2])
        np.testing.assert_array_equal(
            problem.proposed[problem.nodes], system.proposed[system.nodes[rows]]
        )
        np.testing.assert_array_equal(
            problem.masses[problem.nodes], system.masses[system.nodes[rows]]
        )
        np.testing.assert_array_equal(problem.weights, system.weights[rows])
        pinned = scene.pinned[impacts.nodes[zones.impacts_of(z)]]
        assert (np.isinf(problem.masses[problem.nodes]) == pinned).all()


def test_problems_in_one_system_are_solved_as_each_alone(rng):
    problems = [random_problem(rng, n) for n in (1, 5, 20)]
    problems[1].masses[2] = np.inf
    system, places = problem_system(problems)
    together = solve_system(system, Options())
    alone = [izo_ref.solve_zone(p).displacements for p in problems]
    np.testing.assert_array_equal(together.displacements[places], np.concatenate(alone))

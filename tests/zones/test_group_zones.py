"""Zones by a thread group are those of the CPU, and so are the zones to solve."""

import numpy as np
import pytest

from izo_ref.zones.grouping import build_zones
from izo_ref.zones.serial import group_counts as at
from tests.helpers.groups import RULE, Grouping, RecordedStep, Scene, group_alone, random_case


def check_zones(own, expected):
    """Check that a group has found the expected zones, and has left no mark."""
    for column, values in zip(own.zones(), expected, strict=True):
        assert np.array_equal(column, values)
    assert own.counts[at.ZONES] == len(expected)
    assert not own.vertices.marks.any()


@pytest.mark.parametrize(("n", "n_vertices"), [(1, 6), (5, 40), (30, 12), (60, 300), (400, 1500)])
def test_zones_and_zones_to_solve_are_those_of_a_step_of_the_cpu(rng, n, n_vertices):
    for p_pinned in (0.0, 0.3):
        for plan in ("needed", "everything"):
            case = random_case(rng, n, n_vertices, p_pinned)
            n_impacts = len(case.found.toi)
            if n_impacts == 0:
                continue
            first_new = int(rng.integers(n_impacts))
            step = RecordedStep(case, case.found, plan=plan)
            n_zones, n_solved = step.solve(first_new)
            rule = RULE._replace(every_zone=plan == "everything")
            own = Grouping(
                case.found.nodes, case.scene.pinned, case.stuck, first_new, rule, n_impacts + 3
            )
            group_alone(own.arguments)
            expected = build_zones(case.scene, case.found)
            check_zones(own, expected)
            assert own.counts[at.ZONES] == n_zones
            assert own.counts[at.TO_SOLVE] == n_solved
            assert np.array_equal(own.stuck, step.stuck)
            check_sizes(own, expected, step.to_solve)


def check_sizes(own, zones, to_solve):
    """Check that the zones to solve are listed by their size, ascending."""
    sizes = np.diff(zones.impact_offsets)
    bounds = (0, RULE.small, RULE.middle, len(zones.impacts))
    for row, low, high in zip(own.to_solve(), bounds[:-1], bounds[1:], strict=True):
        assert (np.diff(row) > 0).all()
        assert ((sizes[row] > low) & (sizes[row] <= high)).all()
    chosen = np.sort(np.concatenate(own.to_solve()))
    expected = [] if to_solve is None else zones.part(chosen).impacts
    assert np.array_equal(expected, [] if to_solve is None else to_solve.impacts)
    assert len(chosen) == (0 if to_solve is None else len(to_solve))


def test_all_sizes_and_stuck_zones_occur(rng):
    """Without them, the test above would compare less than it says."""
    counts, n_stuck = np.zeros(3, int), 0
    for _ in range(20):
        case = random_case(rng, 60, 300)
        own = Grouping(case.found.nodes, case.scene.pinned, case.stuck, 0, RULE)
        group_alone(own.arguments)
        counts += own.counts[at.OF_SIZE : at.OF_SIZE + 3]
        n_stuck += own.counts[at.ZONES] - own.counts[at.TO_SOLVE]
    assert (counts > 10).all()
    assert n_stuck > 3


def test_without_a_new_impact_there_are_no_zones(rng):
    case = random_case(rng, 20, 40)
    for rule in (RULE, RULE._replace(every_zone=True)):
        n = len(case.found.toi)
        own = Grouping(case.found.nodes, case.scene.pinned, case.stuck, n, rule)
        group_alone(own.arguments)
        assert own.counts.tolist() == [n, n, -1, -1] + [0] * (at.N_COUNTS - 4)
        assert np.array_equal(own.stuck, case.stuck)


def test_impacts_between_pinned_vertices_are_in_no_zone(rng):
    nodes = random_case(rng, 30, 40, 0.0).found.nodes
    for pinned in (np.ones(40, bool), np.arange(40) < 30):
        own = Grouping(nodes, pinned, np.zeros(40, bool))
        group_alone(own.arguments)
        all_pinned = pinned[nodes].all(axis=1)
        assert all_pinned.any()
        assert own.counts[at.LEFT_OUT] == all_pinned.sum()
        impacts = random_case(rng, 0, 40).found._replace(nodes=nodes)
        check_zones(own, build_zones(Scene(None, None, pinned), impacts))


@pytest.mark.parametrize("n", [2, 3, 64, 1000])
def test_a_chain_in_any_order_is_one_zone(rng, n):
    ends = rng.permutation(n + 1)
    pinned = np.arange(n + 2) == n + 1
    for links in (ends, np.arange(n + 1), np.arange(n + 1)[::-1]):
        nodes = np.column_stack((links[:-1], links[1:], np.full((n, 2), n + 1))).astype(np.int32)
        own = Grouping(nodes[rng.permutation(n)], pinned, np.zeros(n + 2, bool))
        group_alone(own.arguments)
        assert own.lists.impact_offsets[:2].tolist() == [0, n]
        assert own.zones()[2].tolist() == list(range(n + 1))

"""Selection and zones on the GPU, compared with those on the CPU."""

import numpy as np
import pytest

from izo_ref.base.cuda.program import Program
from izo_ref.base.gpu_arrays import empty, to_cpu, to_gpu
from izo_ref.zones.gpu_grouping import launch_of_grouping, launch_of_selection
from izo_ref.zones.group_buffers import listed_zones
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.serial import group_counts as at
from tests.helpers.gpu_groups import counts_of, grouped, step_of
from tests.helpers.groups import RULE, RULES, RecordedStep, random_case
from tests.helpers.same import same_columns

BY_BLOCK, BY_GRID = 10**6, -1  # values of `few`
SHAPES = [(0, 5, 1.0), (1, 5, 1.0), (30, 12, 1.0), (25, 90, 1e3)]


def found_of(case):
    """Send the impacts that were found to the GPU, and their number."""
    return to_gpu(case.found), to_gpu(np.array([len(case.found.toi)]))


@pytest.mark.parametrize("few", [BY_BLOCK, BY_GRID])
@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize(("n", "n_vertices", "edges"), SHAPES)
def test_the_same_impacts_enter(rng, name, n, n_vertices, edges, few):
    before = random_case(rng, 3, n_vertices).found
    for _ in range(2):
        case = random_case(rng, n, n_vertices, edges=edges)
        step, n_before = RecordedStep(case, before, selection=name), len(before.toi)
        n_new, counts = step.select(), counts_of(0, n_before)
        own = step_of(case, before, n_before + len(case.found.toi))
        launch_of_selection(*found_of(case), name, own, counts, few)()
        seen = to_cpu(counts)
        assert seen[[at.FIRST_NEW, at.IMPACTS, at.NEW]].tolist() == [
            n_before,
            n_before + n_new,
            n_new,
        ]
        same_columns([column[: n_before + n_new] for column in own[:5]], step.impacts)
        assert np.array_equal(to_cpu(own.known_depths), step.known_depths)
        before = step.impacts


@pytest.mark.parametrize("few", [BY_BLOCK, BY_GRID])
@pytest.mark.parametrize(("n", "n_vertices"), [(1, 5), (30, 12), (25, 90), (60, 200)])
def test_zones_are_those_of_the_cpu(rng, n, n_vertices, few):
    case = random_case(rng, n, n_vertices, 0.3)
    found = grouped(case.found.nodes, case.scene.pinned, case.stuck, few=few)
    for own, expected in zip(found.zones, build_zones(case.scene, case.found), strict=True):
        assert np.array_equal(own, expected)


def test_no_impacts_and_impacts_of_pinned_vertices_have_no_zones(rng):
    nodes = random_case(rng, 4, 8, 0.0).found.nodes
    for own, pinned in ((nodes[:0], np.zeros(8, bool)), (nodes, np.ones(8, bool))):
        found = grouped(own, pinned, np.zeros(8, bool))
        assert found.counts[[at.ZONES, at.ZONE_IMPACTS, at.ZONE_VERTICES, at.TO_SOLVE]].max() == 0


@pytest.mark.parametrize("first_new", [0, 20])
def test_the_zones_to_solve_are_those_of_the_cpu(rng, first_new):
    case = random_case(rng, 40, 300)
    case.stuck[case.found.nodes[25]] = True
    step = RecordedStep(case, case.found)
    n_zones, n_solved = step.solve(first_new)
    found = grouped(case.found.nodes, case.scene.pinned, case.stuck, first_new, RULE)
    assert found.counts[[at.ZONES, at.TO_SOLVE]].tolist() == [n_zones, n_solved]
    assert n_solved < n_zones
    expected = build_zones(case.scene, case.found)
    assert np.array_equal(expected.part(found.to_solve).impacts, step.to_solve.impacts)
    assert np.array_equal(found.stuck, step.stuck)


def test_impacts_that_outgrow_their_room_get_more_and_the_launches_are_repeated(rng):
    """The launches work as a step uses them: counts stay on the device but for one look at them."""
    case, before = random_case(rng, 40, 120, edges=30.0), random_case(rng, 3, 120).found
    step, n_vertices = RecordedStep(case, before), len(case.stuck)
    n_new = step.select()
    n_zones, n_solved = step.solve(len(before.toi))
    counts = counts_of(len(before.toi), len(before.toi))
    room, grew = 4, 0
    own = step_of(case, before, room)
    while True:
        zones = listed_zones(room, n_vertices, counts, empty)
        select = launch_of_selection(*found_of(case), "independent", own, counts)
        Program([select, launch_of_grouping(own, RULE, zones)]).run()
        seen = to_cpu(counts)
        if seen[at.NEEDED_IMPACTS] <= room:
            break
        grew, room = grew + 1, int(seen[at.NEEDED_IMPACTS])
        own = step_of(case._replace(known_depths=to_cpu(own.known_depths)), before, room)
        assert seen[[at.NEW, at.ZONES, at.TO_SOLVE]].tolist() == [0, 0, 0]
    n = len(before.toi) + n_new
    assert grew == 1
    same_columns([column[:n] for column in own[:5]], step.impacts)
    assert seen[: at.TO_SOLVE + 1].tolist() == [n - n_new, n, n_new, n, n_zones, n_solved]
    assert np.array_equal(to_cpu(own.stuck), step.stuck)

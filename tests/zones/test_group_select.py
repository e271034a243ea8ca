"""The selection by a thread group takes the impacts that a step of the CPU takes."""

from fractions import Fraction

import numpy as np
import pytest

from izo_ref.base.records import no_impacts
from izo_ref.zones.serial import group_counts as at
from izo_ref.zones.serial.deep_selection import DEEP, DEEP_EDGES, SHALLOW, UNDECIDED
from izo_ref.zones.serial.group_depths import DEEPEST, UNIT, depth_of_sum
from tests.helpers.groups import (
    RULES,
    RecordedStep,
    Scene,
    Selection,
    random_case,
    select_alone,
)

SHAPES = [(0, 6), (1, 6), (5, 12), (40, 16), (40, 90), (150, 60), (150, 400)]


def check_same(case, impacts, rule, room):
    """Check that a group selects as a step of the CPU does, and return that step."""
    step, own = RecordedStep(case, impacts, selection=rule), Selection(case, impacts, rule, room)
    n_new = step.select()
    select_alone(own.arguments)
    before, needed = len(impacts.toi), len(impacts.toi) + n_new
    assert own.has_entered(step.impacts)
    assert own.counts[: at.NEEDED_IMPACTS + 1].tolist() == [before, needed, n_new, needed]
    assert np.array_equal(own.known_depths, step.known_depths)
    assert not own.vertices.marks.any()
    return step


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("n", "n_vertices"), SHAPES)
def test_the_same_impacts_enter_in_the_same_order(rng, rule, n, n_vertices):
    for edges in (1.0, 30.0, 1e3):
        for n_times in (3, 10**6):
            case = random_case(rng, n, n_vertices, rng.choice([0.0, 0.3]), n_times, edges)
            step = check_same(case, no_impacts(), rule, n)
            again = random_case(rng, n, n_vertices, 0.0, n_times, edges)
            again = again._replace(known_depths=step.known_depths)
            check_same(again, step.impacts, rule, 2 * n + 7)


def test_zones_of_all_depths_occur(rng):
    """Without them, the test above would compare nothing."""
    known = [set(), set()]
    for k, edges in enumerate((1.0, 1e3)):
        for _ in range(10):
            case = random_case(rng, 40, 90, 0.3, 3, edges)
            step = check_same(case, no_impacts(), "independent", 40)
            known[k] |= set(step.known_depths.tolist())
    assert known == [{UNDECIDED, SHALLOW}, {UNDECIDED, SHALLOW, DEEP}]


@pytest.mark.parametrize("rule", RULES)
def test_impacts_that_do_not_fit_are_counted_and_enter_the_next_time(rng, rule):
    case, before = random_case(rng, 60, 90, 0.2, 5, 30.0), random_case(rng, 7, 90).found
    step = RecordedStep(case, before, selection=rule)
    n_new = step.select()
    assert n_new > 1
    needed = len(before.toi) + n_new
    for room in (len(before.toi), needed - 1):
        own = Selection(case, before, rule, room)
        for _ in range(2):  # the second call finds what the first one has left
            select_alone(own.arguments)
            assert own.has_entered(before)
            assert own.counts[: at.NEEDED_IMPACTS + 1].tolist() == [needed - n_new] * 2 + [
                0,
                needed,
            ]
        more = Selection(case._replace(known_depths=own.known_depths), before, rule, needed)
        select_alone(more.arguments)
        assert more.has_entered(step.impacts)
        assert np.array_equal(more.known_depths, step.known_depths)


@pytest.mark.parametrize("rule", RULES)
def test_nothing_is_done_if_the_detection_has_found_more_than_there_is_room_for(rng, rule):
    case, before = random_case(rng, 30, 60), random_case(rng, 7, 60).found
    own = Selection(case, before, rule, 100, room_found=len(case.found.toi) - 1)
    select_alone(own.arguments)
    n = len(before.toi)
    assert own.counts[: at.NEEDED_IMPACTS + 1].tolist() == [n, n, 0, n]
    assert own.has_entered(before)
    assert not own.known_depths.any()


def columns_of_vertices(depths):
    """Return a case of vertices that fall through one face, so deep, in edges of the face."""
    n = len(depths)
    start = np.concatenate(([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], np.tile([0.2, 0.2, 0.1], (n, 1))))
    end = start.copy()
    end[3:, 2] = -np.array(depths) * np.sqrt(2.0)
    case = random_case(np.random.default_rng(0), n, n + 3, 0.0)
    nodes = np.column_stack((np.arange(3, n + 3), np.zeros(n), np.ones(n), np.full(n, 2)))
    found = case.found._replace(
        nodes=nodes.astype(np.int32),
        is_edge_edge=np.zeros(n, bool),
        weights=np.tile([1.0, -0.5, -0.25, -0.25], (n, 1)),
        normals=np.tile([0.0, 0.0, 1.0], (n, 1)),
    )
    return case._replace(scene=Scene(start, end, case.scene.pinned), found=found)


@pytest.mark.parametrize(
    "depths",
    [
        [DEEP_EDGES] * 5,  # so near to the limit that the order of the sum decides
        [DEEP_EDGES + 1e-9, DEEP_EDGES - 2e-9] * 3,
        [DEEP_EDGES + 1e-3, DEEP_EDGES],
        [2.0 * DEEPEST, -2.0 * DEEPEST, 7.0],  # too deep for units
        [2.0 * DEEPEST, -2.0 * DEEPEST, 30.0],
        [np.nan, 100.0],
        [np.inf, 1.0],
        [-np.inf, 1.0],
    ],
)
def test_sums_near_the_limit_and_enormous_depths_are_decided_as_on_the_cpu(depths):
    case = columns_of_vertices(depths)
    step = check_same(case, no_impacts(), "independent", len(depths))
    assert (step.known_depths != UNDECIDED).all()


def test_sums_of_units_decide_only_what_any_order_of_the_sum_decides(rng):
    answers = set()
    for _ in range(3000):
        n = int(rng.integers(1, 200))
        depths = rng.normal(DEEP_EDGES, 10.0 ** rng.uniform(-9, 1), n)
        units = sum(int(depth / UNIT) for depth in depths)
        answer = depth_of_sum(units, n)
        exact = sum(map(Fraction, depths.tolist()))
        total = 0.0
        for depth in depths:
            total += depth
        if answer != UNDECIDED:
            assert answer == (DEEP if total > DEEP_EDGES * n else SHALLOW)
            assert answer == (DEEP if exact > Fraction(DEEP_EDGES) * n else SHALLOW)
        answers.add(answer)
    assert answers == {UNDECIDED, SHALLOW, DEEP}

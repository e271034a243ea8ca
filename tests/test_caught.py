"""What deliberate faults showed to be untested; see `python -m validation mutants`."""

import numpy as np
import pytest

import izo_ref
from izo_ref.certificate.cpu.meetings import decide_meetings
from izo_ref.detection.serial.tree import box_of, meeting_lanes
from tests.helpers.shapes import two_sheets, vertex_over_face
from validation.oracles.rational import ExactZone, active_rows

AXES_AND_SIDES = [(axis, side) for axis in range(3) for side in (-1.0, 1.0)]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("axis", "side"), AXES_AND_SIDES)
@pytest.mark.parametrize("times", [(0, 6), (6, 0)], ids=["apart at the start", "at the end"])
def test_boxes_that_touch_meet_along_each_axis_from_both_sides(axis, side, dtype, times):
    block = np.empty((1, 12, 8), dtype)
    block[0] = np.array([0.0, 0, 0, 1, 1, 1] * 2, dtype)[:, None]
    for row in range(axis, 12, 3):
        block[0, row, 5] += side
    for time in times:
        inner = axis + time + (0 if side > 0.0 else 3)  # the side of the box that touches
        assert meeting_lanes(box_of(block, 0, 0), block, 0) == 255
        block[0, inner, 5] = np.nextafter(block[0, inner, 5], dtype(2.0 * side))
    assert meeting_lanes(box_of(block, 0, 0), block, 0) == 255 - 32


@pytest.mark.parametrize(("axis", "side"), AXES_AND_SIDES)
def test_a_contact_at_the_end_is_found_along_each_axis_from_both_sides(axis, side):
    """The boxes of the vertex and of the face have one plane in common, no more."""
    scene = vertex_over_face(drop=1.0)
    start, end = (
        np.roll(positions * (1.0, 1.0, side), axis + 1, axis=1)
        for positions in (scene.positions_t0, scene.positions_t1)
    )
    turned = izo_ref.Scene(start, end, scene.faces)
    found = izo_ref.find_impacts(turned)
    assert [3, 0, 1, 2] in found.nodes.tolist()
    assert not izo_ref.certify_path(turned, end).free


@pytest.mark.parametrize("shift", [(0, 0, 5), (0, -3, 0)], ids=["vertex-face", "edge-edge"])
@pytest.mark.parametrize("turn", range(3))
@pytest.mark.parametrize("order", [range(6), range(5, -1, -1)], ids=["up", "down"])
def test_pairs_left_out_are_left_out_everywhere(shift, turn, order):
    """A triangle through another leaves it: only pairs that were left out meet.

    Whatever the numbering and the first corner: `resolve` works in a numbering of its own.
    """
    start = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [0.9, 1, 2], [1.1, 1.05, 2]])
    end = start.copy()
    end[3:] += shift
    order = np.array(order)
    faces = np.argsort(order)[[np.roll([0, 1, 2], turn), np.roll([3, 4, 5], turn)]]
    with pytest.raises(izo_ref.base.errors.InitialIntersectionError):
        izo_ref.Scene(start[order], end[order], faces)
    scene = izo_ref.Scene(start[order], end[order], faces, initial_intersections="exclude")
    assert len(izo_ref.find_impacts(scene).toi) == 0
    assert izo_ref.certify_path(scene, end[order]).free
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is izo_ref.Status.FREE
    assert len(result.impacts.toi) == 0
    np.testing.assert_array_equal(result.positions, end[order])
    scene.excluded = None  # and they do meet
    assert len(izo_ref.find_impacts(scene).toi) > 0


@pytest.mark.parametrize("height", [0.0, -5e-324, -1e-17])
def test_a_start_that_crosses_by_less_than_rounding_is_refused(height):
    """The corner is not in the face, but its edges go through: no sign of floats is certain."""
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, height], [0, 0, 1], [1, 0, 1]])
    with pytest.raises(izo_ref.base.errors.InitialIntersectionError):
        izo_ref.Scene(start, start, [[0, 1, 2], [3, 4, 5]])


def test_a_violation_does_not_hide_a_gap():
    """Two rows with equal multipliers, one violated and one open by 1/2: the products cancel."""
    zone = izo_ref.ZoneProblem(
        [[0, 1, 2, 3], [4, 1, 2, 3]],
        [[1.0, -0.5, -0.25, -0.25]] * 2,
        [[0.0, 0.0, 1.0]] * 2,
        [[0, 0, 0.0], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.0]],
        [1.0, np.inf, np.inf, np.inf, 1.0],
        1.0,
    )
    positions = zone.proposed.copy()
    positions[[0, 4], 2] = 0.5, 1.5
    found = izo_ref.residuals(zone, positions, np.array([1.0, 1.0]))
    primal = 0.5 * (0.5**2 + 1.5**2)
    assert found.complementarity == pytest.approx((0.5 + 0.5) / primal)
    # moved 1/2 and 3/2 where the multipliers pull 1 each: 1/2 (1/4 + 1/4) more
    assert found.gap == pytest.approx((0.25 + 0.5 + 0.5) / primal)


def test_the_objective_is_over_the_mass_of_what_is_free():
    scene = vertex_over_face(masses=(7.0, 8.0, 9.0, 0.5), pinned=(True, True, True, False))
    result = izo_ref.resolve(scene, thickness=0.125)
    # masses 0.5, 1 and 1 are free, the first moves by 1.125
    assert result.objective == pytest.approx(0.5 * 1.125**2 / 2.5)


def test_a_bound_on_the_distance_holds_where_rounding_is_all_there_is(rng):
    """Rows of size 1 that are violated by 1e-9: slacks are rounded by 1e-7 of the answer."""
    beyond = 0
    for _ in range(100):
        weights = np.append(1.0, -rng.dirichlet([1.0, 1.0, 1.0]))
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        proposed = rng.normal(size=(4, 3))
        gap = normal @ (weights @ proposed)
        if gap < 0.1:
            continue
        parts = ([[0, 1, 2, 3]], [weights], [normal], proposed, np.ones(4), gap + 1e-9)
        problem = izo_ref.ZoneProblem(*parts)
        found = izo_ref.solve_zone(problem)
        zone = ExactZone(problem)
        optimum = zone.solve(active_rows(found.multipliers))
        true = zone.distance(found.displacements, optimum.moves)
        bound = izo_ref.distance_bound(
            problem, found.positions, found.multipliers, found.displacements
        )
        assert bound >= true
        beyond += true > 1e-17
    assert beyond > 10


def test_what_is_scaled_back_goes_the_part_of_its_way_that_is_named(rng):
    scene = two_sheets(rng, 8)
    result = izo_ref.resolve(scene, 1e-3, options=izo_ref.Options(max_iterations=0))
    assert min(part.scale for part in result.scaled_back) < 0.5  # more than one round
    for part in result.scaled_back:
        start, end = scene.positions_t0[part.vertices], scene.positions_t1[part.vertices]
        expected = start + part.scale * (end - start)
        np.testing.assert_allclose(result.positions[part.vertices], expected, atol=1e-15)


@pytest.mark.parametrize(
    ("is_edge_edge", "at", "meets"),
    [
        (True, (0, 0), True),
        (True, (3, 0), False),
        (True, (-3, 0), False),
        (True, (0, 3), False),
        (True, (0, -3), False),
        (True, (3, 3), False),
        (False, (0.25, 0.25), True),
        (False, (-0.5, 0.5), False),
        (False, (0.5, -0.5), False),
        (False, (1, 1), False),
        (False, (-1, -1), False),
    ],
)
def test_a_coplanar_moment_beside_each_other_is_no_certain_meeting(is_edge_edge, at, meets):
    """The first side falls through the plane of the second at t = 1/2, at a place."""
    if is_edge_edge:
        start = np.array([[-1, 0, 1], [1, 0, 1], [0, -1, 0], [0, 1, 0.0]])
        falling = slice(0, 2)
    else:
        start = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
        falling = slice(0, 1)
    start[falling, :2] += at
    end = start.copy()
    end[falling, 2] = -1.0
    for order in ([0, 1, 2, 3], [2, 3, 0, 1]) if is_edge_edge else ([0, 1, 2, 3], [0, 3, 1, 2]):
        found = np.empty(1, bool)
        nodes, kind = np.array([order], np.int32), np.array([is_edge_edge])
        decide_meetings(start, end, nodes, kind, np.array([0.5]), found)
        assert bool(found[0]) is meets

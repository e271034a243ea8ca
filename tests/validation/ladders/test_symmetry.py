"""Symmetries: the twins are the same steps, the judges can fail, and the quick rungs are right."""

import numpy as np
import pytest

from validation.ladders import (
    symmetry,
    symmetry_of_pairs,
    symmetry_of_zones,
    twins,
    twins_rounded,
    twins_same_bits,
)
from validation.ladders.ladder import ANOTHER, RIGHT, SAYS_SO, WRONG
from validation.ladders.twins import Compared
from validation.oracles.pairs import meeting_pairs
from validation.oracles.path import first_meeting
from validation.scenes.crossing import LATTICE_M, crossing_sheets, on_lattice, regular_layers

LADDER = {ladder.name: ladder for ladder in symmetry.LADDERS}
MAPS = ("turned", "axes_exchanged", "mirrored", "moved", "scaled_by_three")


@pytest.mark.parametrize("rung", LADDER["sample"].quick)
def test_quick_rungs_are_right(rung):
    (outcome,) = LADDER["sample"].run(rung)
    assert outcome.verdict == RIGHT, outcome


def test_ladders_have_names_of_their_own():
    assert len(LADDER) == len(symmetry.LADDERS)
    assert all(set(ladder.quick) <= set(ladder.rungs) for ladder in symmetry.LADDERS)


@pytest.mark.parametrize("name", MAPS)
@pytest.mark.parametrize("seed", range(3))
def test_a_map_changes_no_coordinate_by_rounding_and_is_undone(name, seed):
    """All distances of a twin are the same multiple of those of the step, exactly."""
    rng = np.random.default_rng(seed)
    step = crossing_sheets(rng, 1.0)
    twin = getattr(twins_rounded, name)(rng, step)
    factor = twin.step.thickness / step.thickness
    for own, other in ((step.start, twin.step.start), (step.end, twin.step.end)):
        units = [np.rint(p / LATTICE_M).astype(np.int64).astype(object) for p in (own, other)]
        for numbers, positions in zip(units, (own, other), strict=True):
            np.testing.assert_array_equal(numbers.astype(float) * LATTICE_M, positions)
        squares = [((u[1:] - u[:-1]) ** 2).sum(axis=1) for u in units]
        assert (squares[1] == int(factor) ** 2 * squares[0]).all()
        np.testing.assert_allclose(twin.back(other), own, rtol=0.0, atol=1e-13)


def test_a_step_with_other_numbers_is_the_same_mesh():
    rng = np.random.default_rng(3)
    step = crossing_sheets(rng, 1.0)
    twin = twins_same_bits.numbered_anew(rng, step)
    assert not (twin.step.start == step.start).all()
    np.testing.assert_array_equal(twin.back(twin.step.start), step.start)
    corners = [
        {tuple(sorted(map(tuple, s.start[face].tolist()))) for face in s.faces}
        for s in (step, twin.step)
    ]
    assert corners[0] == corners[1]


def test_a_step_with_another_one_beside_it_begins_with_the_step():
    rng = np.random.default_rng(4)
    step = crossing_sheets(rng, 1.0)
    twin = twins_rounded.beside(rng, step, 16.0)
    np.testing.assert_array_equal(twin.back(twin.step.start), step.start)
    assert len(twin.step.faces) == 2 * len(step.faces)
    assert twin.step.faces[len(step.faces) :].min() == len(step.start)


@pytest.mark.parametrize("seed", range(4))
def test_crossing_steps_start_free_and_end_crossed(seed):
    """By exact arithmetic over all pairs; all coordinates are on the lattice."""
    step = crossing_sheets(np.random.default_rng(seed), 0.5)
    at_start = meeting_pairs(step.start, step.start, step.faces)
    assert len(at_start.vertex_face) + len(at_start.edge_edge) == 0
    assert len(meeting_pairs(step.start, step.end, step.faces).vertex_face) > 0
    np.testing.assert_array_equal(on_lattice(step.end), step.end)


def test_regular_layers_have_impacts_at_equal_times():
    step = regular_layers(np.random.default_rng(0))
    times = meeting_pairs(step.start, step.end, step.faces).vertex_face_time
    assert len(np.unique(times)) < len(times) / 4


def compared(deviation=0.0, objective=0.0, statuses=("FREE", "FREE")):
    """Return a comparison."""
    return Compared(deviation, True, objective, statuses)


def test_judges_tell_equal_bits_rounding_and_worse_answers():
    same, near, far = compared(), compared(1e-12), compared(1e-6)
    worse = compared(0.5, objective=0.2)
    given_up = compared(0.5, objective=0.2, statuses=("FREE", "FREE_BY_FALLBACK"))
    assert symmetry.same_bits([same, same]) == RIGHT
    assert symmetry.same_bits([same, near]) == WRONG
    assert symmetry.same_bits([compared(statuses=("FREE", "BLOCKED"))]) == WRONG
    assert symmetry.same_up_to_rounding([same, near]) == RIGHT
    assert symmetry.same_up_to_rounding([same, far]) == ANOTHER
    assert symmetry.same_up_to_rounding([same, given_up]) == SAYS_SO
    assert symmetry.as_good([same, far]) == RIGHT
    assert symmetry.as_good([same, worse]) == ANOTHER
    assert symmetry.as_good([worse, given_up]) == ANOTHER
    assert symmetry.as_good([given_up]) == SAYS_SO


def test_a_deviation_is_over_the_largest_move():
    """A vertex falls through a pinned face by 1 m, and another answer ends 0.25 m elsewhere."""
    step = crossing_sheets(np.random.default_rng(1), 0.5)
    result = twins.resolved(step)
    moved = np.abs(result.positions - step.end).max()
    other = result.positions.copy()
    other[0, 0] += 0.25 * moved
    found = twins.compared(step, result, result, other)
    assert found.deviation == pytest.approx(0.25)
    assert found.same_way
    assert twins.compared(step, result, result, result.positions).objective == 0.0


@pytest.mark.parametrize("name", symmetry_of_zones.SYMMETRIES)
def test_zones_written_in_another_way_have_the_same_optimum(name):
    (outcome,) = symmetry_of_zones.judge_zone_symmetry(name, 6)
    assert outcome.verdict == RIGHT, outcome


@pytest.mark.parametrize("word", ["linear", "beside", "in-plane", "parallel", "no-root"])
def test_roles_in_a_pair_do_not_matter(word):
    pairs = symmetry_of_pairs.pairs_of(word)
    assert pairs
    (outcome,) = symmetry_of_pairs.judge_pairs(pairs)
    assert outcome.verdict == RIGHT, outcome


def test_all_ways_to_write_a_pair_are_different_and_the_same_pair():
    pair = symmetry_of_pairs.pairs_of("linear")
    for own in pair:
        written = list(symmetry_of_pairs.ways(own))
        assert len({other.start.tobytes() for other in written}) == (8 if own.is_edge_edge else 6)
        assert len({first_meeting(*other) for other in written}) == 1

"""The ladders of scale and place: their quick rungs, and the steps that are solved by hand."""

from fractions import Fraction

import numpy as np
import pytest

from validation.ladders.ladder import RIGHT
from validation.ladders.scale import LADDERS, rounded
from validation.oracles.pairs import meeting_pairs
from validation.scenes import analytic

QUICK = [(ladder, rung) for ladder in LADDERS for rung in ladder.quick]
STEPS = [analytic.vertex_on_face, analytic.edge_on_edge, analytic.sheet_on_table]


@pytest.mark.parametrize(
    ("ladder", "rung"), QUICK, ids=[f"{ladder.name}-{rung}" for ladder, rung in QUICK]
)
def test_quick_rungs_are_right(ladder, rung):
    own = next(iter(ladder.run(rung)))
    assert own.verdict == RIGHT, own


def test_ladders_go_one_way_and_have_their_own_names():
    names = [ladder.name for ladder in LADDERS]
    assert len(set(names)) == len(names)
    for ladder in LADDERS:
        assert set(ladder.quick) <= set(ladder.rungs), ladder.name
        assert ladder.wanted is None or ladder.wanted in ladder.rungs, ladder.name
        if ladder.unit != "kind":
            steps = np.diff(ladder.rungs)
            assert (steps > 0.0).all() or (steps < 0.0).all(), ladder.name


@pytest.mark.parametrize("make", STEPS)
@pytest.mark.parametrize("thickness", [2.0**-10, 4.0])
def test_the_right_end_is_free_and_nothing_less_would_be(make, thickness):
    """Exact arithmetic over all pairs; 2^-40 below the pinned part, the path meets it."""
    step = make(thickness)
    assert not _meets(step, step.right)
    low = step.right.copy()
    moved = (step.right != step.end).any(axis=1)
    low[moved, 2] = -(2.0**-40)
    assert _meets(step, low)
    assert _meets(step, step.end)
    assert not moved[step.pinned].any()


@pytest.mark.parametrize("make", STEPS)
def test_a_higher_step_is_the_same_step_moved(make):
    high, moved = make(height=1.0), analytic.moved(make(), np.array([0.0, 0.0, 1.0]))
    for part in ("start", "end", "right"):
        np.testing.assert_array_equal(getattr(high, part), getattr(moved, part))


@pytest.mark.parametrize("masses", [(1.0, 1.0, 1.0, 1.0), (1000.0, 8.0, 0.5, 1.0)])
def test_the_right_end_of_free_bodies_is_the_optimum(masses):
    """The gap is the thickness, and the moves are the pull of one positive multiplier."""
    step = analytic.free_vertex_on_face(masses)
    z = [Fraction(float(v)) for v in step.right[:4, 2]]
    gap = z[3] - z[0] / 2 - z[1] / 4 - z[2] / 4
    assert float(gap - Fraction(step.thickness)) == pytest.approx(0.0, abs=1e-15)
    pulls = (step.right - step.end)[:4, 2] * masses / (-0.5, -0.25, -0.25, 1.0)
    assert pulls.min() > 0.0
    np.testing.assert_allclose(pulls, pulls[0], rtol=1e-12)


def test_a_rounded_start_that_touches_is_known_to_be_refused():
    step = analytic.vertex_on_face()
    assert "FREE" in rounded(step).statuses
    flat = step._replace(start=step.start * (1.0, 1.0, 0.0))
    assert rounded(flat).statuses == ("InitialIntersectionError",)


def _meets(step, end):
    found = meeting_pairs(step.start, end, step.faces)
    return len(found.vertex_face) + len(found.edge_edge) > 0

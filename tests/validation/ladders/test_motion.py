"""The quick rungs of the family of motion are right, and so are the answers that it knows."""

import numpy as np
import pytest

from izo_ref import Scene, certify_path
from tests.helpers.rungs import quick_rungs
from validation.ladders.ladder import RIGHT
from validation.ladders.motion import LADDERS
from validation.oracles.pairs import meeting_pairs
from validation.scenes.sweeping import (
    coplanar_grids,
    folded_sheet,
    rippled_sheets,
    scaled_ball,
    turned_block,
)

QUICK = quick_rungs(LADDERS)


@pytest.mark.parametrize(("ladder", "rung"), QUICK)
def test_a_quick_rung_is_right(ladder, rung):
    own, *_ = ladder.run(rung)
    assert own.verdict == RIGHT, own


# motions below and at the border at which they meet, which exact arithmetic confirms
BORDERS = {
    "turn": (turned_block, 179.0, 180.0),
    "fold": (lambda fold: folded_sheet(3, fold), 0.5 - 2.0**-10, 0.5),
    "grids": (lambda move: coplanar_grids(2, move), 0.25 - 2.0**-10, 0.25),
}


@pytest.mark.parametrize("name", BORDERS)
def test_a_motion_meets_from_its_border_on(name):
    make, below, border = BORDERS[name]
    for value, meets in ((below, False), (border, True)):
        found = meeting_pairs(*make(value))
        assert (len(found.vertex_face) + len(found.edge_edge) > 0) is meets


def test_a_ball_is_closed_and_points_outward():
    start, _, faces = scaled_ball(1.0)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    assert len(start) - len(edges) + len(faces) == 2
    assert (np.linalg.det(start[faces]) > 0.0).all()


def test_a_turn_keeps_the_shape_of_the_block():
    start, end, faces = turned_block(77.0)
    lengths = [np.linalg.norm(x[faces[:, 0]] - x[faces[:, 1]], axis=1) for x in (start, end)]
    np.testing.assert_allclose(*lengths, rtol=1e-14)


def test_rippled_sheets_start_free_and_go_through_each_other(rng):
    scene = rippled_sheets(rng)
    assert not certify_path(Scene(*scene), scene.end).free


def test_a_folded_sheet_stays_in_its_plane():
    start, end, _ = folded_sheet(5, 0.8)
    assert not start[:, 2].any()
    assert not end[:, 2].any()
    assert np.array_equal(start[:, 1], end[:, 1])

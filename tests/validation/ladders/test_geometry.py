"""The quick rungs of the family of geometry are right, and so are the answers that it knows."""

import numpy as np
import pytest

from izo_ref import Scene, certify_path
from tests.helpers.rungs import quick_rungs
from tests.naive.qp import solve_qp
from validation.ladders.geometry import LADDERS
from validation.ladders.ladder import RIGHT
from validation.scenes.gadgets import (
    THICKNESS_M,
    edge_on_edge,
    vertex_on_edge,
    vertex_on_face,
)
from validation.scenes.shapes import CORNERS, book, fan, soup, tetrahedron, with_parts

QUICK = quick_rungs(LADDERS)


@pytest.mark.parametrize(("ladder", "rung"), QUICK)
def test_a_quick_rung_is_right(ladder, rung):
    own, *_ = ladder.run(rung)
    assert own.verdict == RIGHT, own


# each gadget with the weights of its contact, worked out by hand, and the axis of its normal
CONTACTS = {
    "vertex on face": (vertex_on_face(CORNERS), [-1 / 3, -1 / 3, -1 / 3, 1.0], 2),
    "edge on edge": (edge_on_edge(), [-0.5, -0.5, 0.0, 0.5, 0.5, 0.0], 2),
    "vertex on edge": (vertex_on_edge(1.0, -0.5), [-0.5, -0.5, 0.0, 1.0, 0.0, 0.0], 1),
    "fan": (fan(5), [1.0, *[0.0] * 5, -1 / 3, -1 / 3, -1 / 3], 2),
    "book": (book(2), [0.5, 0.5, 0.0, 0.0, -0.5, -0.5, 0.0], 2),
}


@pytest.mark.parametrize("name", CONTACTS)
def test_the_answer_of_a_contact_is_the_best_of_all_active_sets(name):
    scene, weights, axis = CONTACTS[name]
    row = np.zeros(scene.end.shape)
    row[:, axis] = weights
    pinned = np.zeros(len(row), bool) if scene.pinned is None else scene.pinned
    masses = np.where(pinned, 2.0**100, 1.0)  # pinned vertices hardly move
    expected = solve_qp(row.reshape(1, -1), np.array([THICKNESS_M]), masses, scene.end)
    np.testing.assert_allclose(scene.best, expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", CONTACTS)
def test_the_proposal_of_a_contact_meets_and_its_answer_is_free(name):
    scene = CONTACTS[name][0]
    assert not certify_path(Scene(*scene[:3]), scene.end).free
    assert certify_path(Scene(*scene[:3]), scene.best).free


def test_parts_move_without_touching_the_contact():
    scene = with_parts(*tetrahedron(), (1.0, 2.0, 3.0))
    assert np.array_equal(scene.end[4:] - scene.start[4:], np.tile([1.0, 2.0, 3.0], (4, 1)))
    assert certify_path(Scene(*scene[:3]), scene.best).free


def test_twin_fans_start_apart():
    scene = fan(7, twin=True)
    assert len(scene.faces) == 14
    assert not certify_path(Scene(*scene[:3]), scene.end).free


def test_triangles_of_a_soup_start_in_cells_of_their_own(rng):
    start, end, faces = soup(rng, 30)
    assert np.array_equal(np.sort(faces, axis=None), np.arange(90))
    cells = np.floor(start).astype(int).reshape(30, 3, 3)
    assert (np.ptp(cells, axis=1) == 0).all()
    assert len(np.unique(cells[:, 0], axis=0)) == 30
    assert np.abs(end - np.floor(start) - 0.5).max() <= 2.0

"""A numbering that the caller's has no part in."""

import numpy as np
import pytest

from izo_ref.loop import numbering
from izo_ref.loop.numbering import geometric_order, renumber_scene
from tests.helpers.shapes import two_sheets


@pytest.mark.parametrize("largest", [numbering.LARGEST_CORNER, 5])
def test_faces_do_not_depend_on_the_numbering(rng, monkeypatch, largest):
    monkeypatch.setattr(numbering, "LARGEST_CORNER", largest)
    scene = two_sheets(rng, 5)
    expected = renumber_scene(scene, geometric_order(scene))
    # corners in turn, and each face as it was oriented
    corners = {tuple(np.roll(face, -np.argmin(face))) for face in expected.faces.tolist()}
    assert [tuple(face) for face in expected.faces.tolist()] == sorted(corners)
    again = renumber_scene(scene, rng.permutation(len(scene.masses)))
    again.faces = np.roll(again.faces, 1, axis=1)[::-1]
    found = renumber_scene(again, geometric_order(again))
    for name in ("faces", "edges", "positions_t0", "positions_t1"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
        assert getattr(found, name).dtype == getattr(expected, name).dtype

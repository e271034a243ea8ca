"""The impacts of a whole scene: which pairs, in which order, and at which times."""

import numpy as np
import pytest

import izo_ref
from tests.helpers.shapes import two_sheets, vertex_over_face
from tests.helpers.steps import load, load_step

AXES_AND_SIDES = [(axis, side) for axis in range(3) for side in (-1.0, 1.0)]


def test_order_and_times_depend_on_the_scene_alone(rng):
    scene = two_sheets(rng)
    first, again = izo_ref.find_impacts(scene), izo_ref.find_impacts(scene)
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a, b)
    kinds = first.is_edge_edge.astype(int)
    assert (np.diff(kinds) >= 0).all()


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scaling_a_scene_changes_no_decision(rng, scale):
    scene = two_sheets(rng)
    scaled = izo_ref.Scene(scale * scene.positions_t0, scale * scene.positions_t1, scene.faces)
    a, b = izo_ref.find_impacts(scene), izo_ref.find_impacts(scaled)
    np.testing.assert_array_equal(a.nodes, b.nodes)
    np.testing.assert_allclose(a.toi, b.toi, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("axis", "side"), AXES_AND_SIDES)
def test_a_contact_at_the_end_is_found_along_each_axis_from_both_sides(axis, side):
    """The boxes of the vertex and of the face have only one plane in common."""
    scene = vertex_over_face(drop=1.0)
    start, end = (
        np.roll(positions * (1.0, 1.0, side), axis + 1, axis=1)
        for positions in (scene.positions_t0, scene.positions_t1)
    )
    turned = izo_ref.Scene(start, end, scene.faces)
    found = izo_ref.find_impacts(turned)
    assert [3, 0, 1, 2] in found.nodes.tolist()
    assert not izo_ref.certify_path(turned, end).free


@pytest.mark.data
def test_armadillo_rollers_gives_exactly_the_published_pairs():
    truth = load("armadillo-rollers")
    impacts = izo_ref.find_impacts(load_step("armadillo-rollers"))

    def key(row, is_edge_edge):
        """Return a key that does not depend on the order of corners, ends or edges."""
        a, b = (row[:2], row[2:]) if is_edge_edge else (row[:1], row[1:])
        sides = tuple(sorted(a)), tuple(sorted(b))
        return tuple(sorted(sides)) if is_edge_edge else sides

    for is_edge_edge, name, count in ((False, "vf", 4650), (True, "ee", 19308)):
        rows = impacts.nodes[impacts.is_edge_edge == is_edge_edge].tolist()
        found = {key(row, is_edge_edge) for row in rows}
        expected = {key(row, is_edge_edge) for row in truth[f"true_{name}"].tolist()}
        assert len(rows) == len(found) == len(expected) == count
        assert found == expected

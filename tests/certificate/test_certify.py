"""The certificate of a path: free, or the pairs that meet and when."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base import errors
from tests.helpers.contacts import first_contact
from tests.helpers.shapes import grid, two_sheets, vertex_over_face


def test_a_certificate_says_free_or_names_the_meeting_pairs():
    scene = vertex_over_face()
    free = izo_ref.certify_path(scene, scene.positions_t0)
    assert free.free
    assert free.time_free == 1.0
    assert len(free.meeting.nodes) == 0
    hit = izo_ref.certify_path(scene, scene.positions_t1)
    assert not hit.free
    assert hit.time_free == pytest.approx(0.5)
    assert [3, 0, 1, 2] in hit.meeting.nodes.tolist()
    assert hit.candidates == hit.vertex_face + hit.edge_edge


def test_a_vertex_pushed_through_by_a_nanometre_is_found():
    scene = vertex_over_face()
    end = scene.positions_t0.copy()
    for height, free in ((1e-9, True), (-1e-9, False), (0.0, False)):
        end[3, 2] = height
        assert izo_ref.certify_path(scene, end).free is free


def test_layers_that_swapped_are_found_though_both_ends_are_free():
    """A check of the end positions alone cannot see this."""
    a, faces = grid(6)
    start = np.concatenate((a, a + (0.01, 0.02, 0.1)))
    end = np.concatenate((a + (0.0, 0.0, 0.2), a + (0.01, 0.02, 0.1)))
    scene = izo_ref.Scene(start, end, np.concatenate((faces, faces + 36)))
    izo_ref.Scene(end, end, scene.faces)  # the end is free of intersections
    certificate = izo_ref.certify_path(scene, end)
    assert not certificate.free
    assert certificate.time_free == pytest.approx(0.5)


def test_a_certificate_finds_the_pairs_that_detection_finds(rng):
    scene = two_sheets(rng)
    impacts = izo_ref.find_impacts(scene)
    certificate = izo_ref.certify_path(scene, scene.positions_t1)
    in_time = np.argsort(impacts.toi, kind="stable")
    np.testing.assert_array_equal(certificate.meeting.nodes, impacts.nodes[in_time])
    np.testing.assert_array_equal(certificate.meeting_toi, impacts.toi[in_time])
    assert certificate.time_free == certificate.meeting_toi[0]


def test_a_certificate_counts_the_steps_of_all_proofs_and_of_the_longest(rng):
    """Pairs whose boxes are apart take no step, so all pairs of the mesh may be asked."""
    scene = two_sheets(rng, 5)
    start, end = scene.positions_t0, scene.positions_t1
    certificate = izo_ref.certify_path(scene, end)
    pairs = [(False, (v, *face)) for v in range(len(start)) for face in scene.faces.tolist()]
    pairs += [(True, (*a, *b)) for a in scene.edges.tolist() for b in scene.edges.tolist() if a < b]
    steps = [
        first_contact(kind, start[list(nodes)], end[list(nodes)])[3]
        for kind, nodes in pairs
        if len(set(nodes)) == 4
    ]
    assert certificate.proofs == sum(steps)
    assert certificate.most_proofs == max(steps) > 1


def test_a_flat_sheet_that_moves_as_one_is_proved_apart():
    """All pairs of neighbours are coplanar at all times."""
    a, faces = grid(12)
    c, s = np.cos(0.5), np.sin(0.5)
    turned = a @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]).T + (0.3, 0.2, 0.1)
    certificate = izo_ref.certify_path(izo_ref.Scene(a, turned, faces), turned)
    assert certificate.free
    assert certificate.candidates > 1000


def test_bad_positions_are_refused():
    scene = vertex_over_face()
    with pytest.raises(errors.ShapeError, match="positions"):
        izo_ref.certify_path(scene, scene.positions_t0[:3])
    with pytest.raises(errors.NonFiniteError, match="positions"):
        izo_ref.certify_path(scene, np.full_like(scene.positions_t0, np.nan))

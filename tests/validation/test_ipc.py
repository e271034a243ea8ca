"""Hits on a path, and intersections at rest, as ipctk reports them."""

import ipctk
import numpy as np
import pytest

import izo_ref
from izo_ref.detection.mesh import edges_of
from tests.helpers.shapes import grid, two_sheets, vertex_over_face
from validation.oracles import ipc
from validation.oracles.ipc import has_intersections, path_hits

pytestmark = pytest.mark.skipif(bool(ipc.unusable()), reason=f"ipctk: {ipc.unusable()}")


def hits_of(scene, **options):
    """Return the hits on the proposed path of a scene."""
    return path_hits(scene.positions_t0, scene.positions_t1, scene.edges, scene.faces, **options)


def pairs_of(nodes, is_edge_edge):
    """Return keys of pairs that do not depend on the order of edges, ends and corners."""
    return {
        (bool(kind), frozenset((frozenset(row[: 1 + kind]), frozenset(row[1 + kind :]))))
        for row, kind in zip(nodes.tolist(), is_edge_edge, strict=True)
    }


def layers(n=5, gap=0.1):
    """Return two sheets that swap places, and so intersect neither at the start nor at the end."""
    low, faces = grid(n)
    high = low + (0.03, 0.02, gap)
    start, end = np.concatenate((low, high)), np.concatenate((low, high))
    start[:, 2], end[:, 2] = start[:, 2], gap - end[:, 2]
    faces = np.concatenate((faces, faces + n * n))
    return start, end, edges_of(faces), faces


def test_layers_that_swap_are_found_on_the_path():
    start, end, edges, faces = layers()
    assert not has_intersections(start, edges, faces)
    assert not has_intersections(end, edges, faces)
    assert has_intersections(0.5 * (start + end), edges, faces)
    nodes, is_edge_edge, toi, complete = path_hits(start, end, edges, faces)
    assert complete
    assert is_edge_edge.any()
    assert not is_edge_edge.all()
    np.testing.assert_allclose(toi, 0.5, rtol=0.0, atol=1e-7)
    assert len(pairs_of(nodes, is_edge_edge)) == len(nodes)


def test_a_step_without_contact_has_no_hits():
    start, end, edges, faces = layers()
    end[:, 2] = 0.9 * start[:, 2]
    nodes, is_edge_edge, toi, complete = path_hits(start, end, edges, faces)
    assert nodes.shape == (0, 4)
    assert is_edge_edge.shape == toi.shape == (0,)
    assert complete


@pytest.mark.parametrize("chunk", [1, 37, 1000])
def test_agrees_with_izo_ref_on_two_sheets(rng, monkeypatch, chunk):
    monkeypatch.setattr(ipc, "CHUNK", chunk)
    scene = two_sheets(rng)
    impacts = izo_ref.find_impacts(scene)
    nodes, is_edge_edge, toi, complete = hits_of(scene)
    assert complete
    assert pairs_of(nodes, is_edge_edge) == pairs_of(impacts.nodes, impacts.is_edge_edge)
    np.testing.assert_allclose(np.sort(toi), np.sort(impacts.toi), rtol=0.0, atol=1e-6)


def test_a_resolved_path_has_no_hits(rng):
    scene = two_sheets(rng)
    end = izo_ref.resolve(scene).positions
    assert len(path_hits(scene.positions_t0, end, scene.edges, scene.faces)[0]) == 0
    assert not has_intersections(end, scene.edges, scene.faces)


def test_nodes_are_a_vertex_then_the_face():
    nodes, is_edge_edge, toi, _ = hits_of(vertex_over_face())
    row = int(np.flatnonzero(nodes[:, 0] == 3)[0])
    assert nodes[row].tolist() == [3, 0, 1, 2]
    assert not is_edge_edge[row]
    assert toi[row] == pytest.approx(0.5, abs=1e-8)


def test_contact_exactly_at_the_end_is_not_missed():
    assert len(hits_of(vertex_over_face(drop=1.0))[0]) > 0


def test_settings_raise_no_alarm_for_a_near_miss(rng):
    """The defaults of ipctk report a vertex that stops well before the face."""
    turned = np.linalg.qr(rng.normal(size=(3, 3)))[0]  # boxes of a level face would not overlap
    for gap in (1e-4, 1e-9):
        scene = vertex_over_face(drop=1.0 - gap)
        start, end = scene.positions_t0 @ turned, scene.positions_t1 @ turned
        assert len(path_hits(start, end, scene.edges, scene.faces)[0]) == 0
        mesh = ipctk.CollisionMesh(start, scene.edges, scene.faces)
        assert not ipctk.is_step_collision_free(mesh, start, end)


def test_a_search_that_ends_early_reports_it():
    start, end, edges, faces = layers()
    everything = path_hits(start, end, edges, faces)
    n = len(everything[0])
    for at_most in (1, 3, n - 1):
        nodes, is_edge_edge, toi, complete = path_hits(start, end, edges, faces, at_most)
        assert not complete
        for part, whole in zip((nodes, is_edge_edge, toi), everything, strict=False):
            np.testing.assert_array_equal(part, whole[:at_most])
    assert path_hits(start, end, edges, faces, n)[3]


def test_touching_at_rest_is_an_intersection():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 0], [0, 0, 1], [1, 1, 1]])
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    assert has_intersections(positions, edges_of(faces), faces)


def test_a_mesh_without_faces_has_no_hits():
    positions, none = np.zeros((3, 3)), np.empty((0, 2), int)
    assert not has_intersections(positions, none, np.empty((0, 3), int))
    assert len(path_hits(positions, positions + 1, none, np.empty((0, 3), int))[0]) == 0


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_positions_that_are_not_finite_are_refused(value):
    start, end, edges, faces = layers()
    bad = end.copy()
    bad[[6, 9], 1] = value
    with pytest.raises(ValueError, match="positions: expected finite, vertex 6 "):
        has_intersections(bad, edges, faces)
    with pytest.raises(ValueError, match="positions_t0: expected finite, vertex 6 "):
        path_hits(bad, end, edges, faces)
    with pytest.raises(ValueError, match="positions_t1: expected finite, vertex 6 "):
        path_hits(start, bad, edges, faces)

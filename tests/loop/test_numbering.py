"""The geometric numbering, in which results do not depend on the caller's numbering."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.loop.numbering import geometric_order, renumber_scene
from tests.helpers.shapes import grid, two_sheets


def test_faces_do_not_depend_on_the_numbering(rng):
    scene = two_sheets(rng, 5)
    expected = renumber_scene(scene, geometric_order(scene))
    # Faces are sorted by their corners, and each keeps its orientation.
    corners = {tuple(np.roll(face, -np.argmin(face))) for face in expected.faces.tolist()}
    assert [tuple(face) for face in expected.faces.tolist()] == sorted(corners)
    again = renumber_scene(scene, rng.permutation(len(scene.masses)))
    again.faces = np.roll(again.faces, 1, axis=1)[::-1]
    found = renumber_scene(again, geometric_order(again))
    for name in ("faces", "edges", "positions_t0", "positions_t1"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
        assert getattr(found, name).dtype == getattr(expected, name).dtype


def test_renumbering_changes_nothing_beyond_rounding(rng):
    scene = two_sheets(rng, 10)
    result = izo_ref.resolve(scene, 1e-3)
    order = rng.permutation(len(scene.masses))
    place = np.argsort(order)
    faces = place[scene.faces][rng.permutation(len(scene.faces))]
    other = izo_ref.Scene(
        scene.positions_t0[order],
        scene.positions_t1[order],
        faces,
        scene.masses[order],
        scene.pinned[order],
    )
    again = izo_ref.resolve(other, 1e-3)
    np.testing.assert_allclose(again.positions, result.positions[order], rtol=0.0, atol=1e-12)
    assert len(again.impacts.toi) == len(result.impacts.toi)


def test_impacts_at_equal_times_are_resolved_alike_in_any_numbering(rng):
    """On two regular grids, many impacts have equal times; no index may decide between them."""
    low, faces = grid(7)
    start = np.concatenate((low, low + (0.0, 0.0, 0.05)))
    start[49:, :2] += 0.031
    end = start.copy()
    end[49:, 2] -= 0.1
    faces = np.concatenate((faces, faces + 49))
    results = []
    for order in (np.arange(98), np.arange(98)[::-1], rng.permutation(98)):
        place = np.argsort(order)
        scene = izo_ref.Scene(start[order], end[order], place[faces])
        results.append(izo_ref.resolve(scene, 1e-3).positions[place])
    for other in results[1:]:
        np.testing.assert_allclose(other, results[0], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("apart", ["at the start", "at the end"])
def test_vertices_of_one_code_are_told_apart_by_where_they_are(rng, apart):
    """Four sheets are closer to each other than a cell of the curve, or they end at one place."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    one_place, layers = np.concatenate([corners] * 4), np.repeat(np.arange(4.0), 3)[:, None]
    start, end = one_place + (0.0, 0.0, 1e-9) * layers, one_place + 2.0
    if apart == "at the end":
        start, end = one_place, one_place + (0.0, 0.5, 1.0) * layers
    found = []
    for _ in range(5):
        order = rng.permutation(12)
        faces = np.argsort(order)[np.arange(12).reshape(4, 3)]
        scene = izo_ref.Scene(start[order], end[order], faces, initial_intersections="ratchet")
        scene = renumber_scene(scene, geometric_order(scene))
        found.append(np.hstack((scene.positions_t0, scene.positions_t1)))
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


def test_impacts_come_in_the_callers_numbering(rng):
    scene = two_sheets(rng, 8)
    result = izo_ref.resolve(scene, 1e-3, options=Options(relinearize=0, selection="all"))
    faces = {tuple(face) for face in scene.faces.tolist()}
    edges = {tuple(edge) for edge in scene.edges.tolist()}
    impacts = result.impacts
    for nodes, is_edge_edge in zip(impacts.nodes.tolist(), impacts.is_edge_edge, strict=True):
        if is_edge_edge:
            assert tuple(nodes[:2]) in edges
            assert tuple(nodes[2:]) in edges
            assert nodes[:2] < nodes[2:]
        else:
            assert tuple(nodes[1:]) in faces
    first = izo_ref.find_impacts(scene)
    known = {tuple(nodes): i for i, nodes in enumerate(first.nodes.tolist())}
    for j, nodes in enumerate(result.impacts.nodes.tolist()):
        if tuple(nodes) in known and result.impacts.toi[j] == first.toi[known[tuple(nodes)]]:
            i = known[tuple(nodes)]
            np.testing.assert_allclose(
                result.impacts.weights[j], first.weights[i], rtol=0.0, atol=1e-9
            )
            np.testing.assert_allclose(
                result.impacts.normals[j], first.normals[i], rtol=0.0, atol=1e-9
            )

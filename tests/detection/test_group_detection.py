"""A detection by a thread group of one thread: its lists are those of the detection on the CPU."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.detection.cpu.tree import fit_tree
from izo_ref.detection.detector import Detector
from izo_ref.detection.formulas.advance import APART
from izo_ref.detection.serial import found_counts as places
from izo_ref.detection.serial.contacts import crossings_of_pairs
from izo_ref.detection.serial.prescribed import prescribed_impacts
from izo_ref.detection.trees import Elements, VertexBoxes, meeting_pairs
from tests.helpers.group_detection import GroupDetection
from tests.helpers.shapes import two_sheets, vertex_over_face

ALL = frozenset({"still", "float32-boxes"})  # without what keeps pairs, or leaves out components


def scene_of(rng, n, share_at_rest=0.5):
    """Return two sheets that meet; many vertices are pinned, and a share is at rest."""
    scene = two_sheets(rng, n)
    scene.pinned[:] = rng.random(len(scene.masses)) < 0.7
    still = rng.random(len(scene.masses)) < share_at_rest
    scene.positions_t1[still] = scene.positions_t0[still]
    return scene


def detected(scene, to_solve=False, **room):
    """Run all parts, and return the detection, its counts, and what its parts returned."""
    own = GroupDetection(scene, **room)
    own.fit(ALONE)
    n_vertex_face = own.list_pairs(ALONE)
    own.list_open_pairs(ALONE)
    proofs = own.list_contacts(ALONE)
    own.list_impacts(ALONE, to_solve)
    return own, own.counts.tolist(), n_vertex_face, proofs


@pytest.mark.parametrize("n", [2, 3, 7, 20])
def test_boxes_and_marks_are_those_of_the_cpu(rng, n):
    scene = scene_of(rng, n)
    moved = (scene.positions_t0 != scene.positions_t1).any(axis=1)
    own = GroupDetection(scene)
    own.path.seen[:] = scene.positions_t1
    own.path.seen[::3, 1] += 1e-9
    own.fit(ALONE)
    still = np.zeros(len(moved))
    boxes = VertexBoxes(scene.positions_t0, scene.positions_t1, still, edges=scene.edges).boxes
    assert np.array_equal(own.boxes, boxes)
    assert np.array_equal(own.moved, moved)
    for tree in own.trees:
        same = Elements(tree.nodes, np.arange(len(tree.nodes), dtype=np.int32)).tree
        fit_tree(moved, boxes, True, tree.nodes, same.levels, same.lanes, same.blocks)
        assert np.array_equal(tree.lanes, same.lanes)
        assert np.array_equal(tree.blocks, same.blocks)
    assert own.counts[places.MOVED] == len(moved[::3])
    assert np.count_nonzero(own.counts) == 1


@pytest.mark.parametrize("n", [2, 3, 7, 20])
def test_pairs_are_those_of_the_cpu(rng, n):
    scene = scene_of(rng, n)
    own, counts, n_vertex_face, _ = detected(scene, n_pairs=20_000)
    vertices, edges, faces = (Elements(tree.nodes, tree.order) for tree in own.trees)
    for elements, tree in zip((vertices, edges, faces), own.trees, strict=True):
        elements.tree = tree
    expected = [(a, b) for a, b in meeting_pairs(vertices, faces).tolist()]
    assert n_vertex_face == len(expected)
    expected += [(-1 - a, b) for a, b in meeting_pairs(edges, edges).tolist()]
    assert counts[places.PAIRS] == len(expected)
    assert sorted(map(tuple, own.pairs[: len(expected)].tolist())) == sorted(expected)
    assert (own.pairs[len(expected) :] == -7).all()


@pytest.mark.parametrize("n", [2, 3, 7, 20])
@pytest.mark.parametrize("n_pairs", [0, 20_000])
def test_edges_and_faces_that_may_meet_at_rest_are_those_of_the_cpu(rng, n, n_pairs):
    scene = scene_of(rng, n)
    scene.positions_t0[:] = scene.positions_t1  # where the sheets went through each other
    own = GroupDetection(scene, n_pairs)
    own.fit_at_rest(ALONE)
    assert own.moved.all()
    assert all(
        np.unpackbits(t.lanes[: -(-len(t.nodes) // 8)]).sum() == len(t.nodes) for t in own.trees
    )
    own.list_edge_faces(ALONE)
    own.count_crossings(ALONE)
    _, edges, faces = (Elements(tree.nodes, tree.order) for tree in own.trees)
    edges.tree, faces.tree = own.trees[1:]
    expected = meeting_pairs(edges, faces)
    assert own.counts[places.PAIRS] == len(expected)
    if n_pairs == 0:
        assert own.counts[places.OPEN] == 0
        return
    assert sorted(own.pairs[: len(expected)].tolist()) == sorted(expected.tolist())
    statuses, nodes = np.empty(len(expected), np.int8), (edges.tree.nodes, faces.tree.nodes)
    crossings_of_pairs(0, len(expected), expected, *nodes, scene.positions_t0, statuses)
    assert own.counts[places.OPEN] == np.count_nonzero(statuses != APART)
    assert n == 2 or 0 < own.counts[places.OPEN] < len(expected)


@pytest.mark.parametrize("n", [3, 7, 12])
def test_pairs_that_may_touch_at_rest_are_those_of_the_cpu(rng, n):
    scene = scene_of(rng, n)
    faces = scene.faces
    scene.positions_t0[faces[0, 0]] = scene.positions_t0[faces[-1]].mean(axis=0)
    scene.positions_t1[:] = scene.positions_t0
    mesh = scene.edges, scene.faces
    expected = Detector(scene.positions_t0, *mesh, start_is_free=False).find(scene.positions_t0)
    own = GroupDetection(scene, 20_000, 2000)
    own.fit_at_rest(ALONE)
    for part in ("list_pairs", "list_open_pairs", "list_contacts"):
        getattr(own, part)(ALONE)
    n_found = own.counts[places.CONTACTS]
    assert n_found == len(expected.toi) > 0
    found = np.column_stack((own.contacts.keys[:n_found] >= 0, own.contacts.nodes[:n_found]))
    others = np.column_stack((expected.is_edge_edge, expected.nodes))
    assert sorted(found.tolist()) == sorted(others.tolist())


@pytest.mark.parametrize("n", [2, 3, 7, 12])
@pytest.mark.parametrize("to_solve", [False, True])
def test_impacts_and_counts_are_those_of_the_cpu(rng, n, to_solve):
    scene = scene_of(rng, n, 0.2)
    detector = Detector.of_scene(scene, ALL)
    expected = detector.find(scene.positions_t1)
    prescribed = np.empty(len(expected.toi), bool)
    prescribed_impacts(expected.nodes, expected.weights, scene.pinned, prescribed)
    assert 0 < np.count_nonzero(prescribed) < len(prescribed) or n < 7
    if to_solve:
        expected = expected.take(~prescribed)
    own, counts, n_vertex_face, proofs = detected(scene, to_solve, n_pairs=20_000, n_contacts=2000)
    for column, other in zip(own.found, expected, strict=True):
        assert np.array_equal(column[: len(other)], other)
        assert not column[len(other) :].any()
    assert counts[places.FOUND] == len(expected.toi)
    assert counts[places.BLOCKED] == to_solve * np.count_nonzero(prescribed)
    assert counts[places.AT_START] == 0
    least = own.counts[places.LEAST_TOI :].view(np.float64)[0]
    assert least == expected.toi.min(initial=1.0)
    assert proofs <= (detector.counts.steps, detector.counts.most_steps)
    edge_edge = counts[places.PAIRS] - n_vertex_face
    assert detector.counts.pairs == {"vertex_face": n_vertex_face, "edge_edge": edge_edge}
    assert np.isnan(own.path.seen).all(), "the host says which path was the last one"


@pytest.mark.parametrize("n", [3, 12])
def test_most_pairs_are_settled_and_without_that_the_contacts_and_proofs_are_those_of_the_cpu(
    rng, n
):
    scene = scene_of(rng, n, 0.2)
    detector = Detector.of_scene(scene, ALL)
    detector.find(scene.positions_t1)
    own, counts, _, proofs = detected(scene, n_pairs=20_000, n_contacts=2000)
    n_pairs, n_open, n_contacts = (counts[k] for k in (places.PAIRS, places.OPEN, places.CONTACTS))
    assert n_contacts <= n_open < n_pairs
    assert n_open - n_contacts <= 0.2 * (n_pairs - n_contacts)
    contacts = sorted(own.contacts.keys[:n_contacts].tolist())
    pairs = own.pairs[:n_pairs].tolist()
    assert all(pair in pairs for pair in own.open[:n_open].tolist())
    own.open, own.counts[places.OPEN], own.counts[places.CONTACTS] = own.pairs, n_pairs, 0
    every = own.list_contacts(ALONE)
    assert every == (detector.counts.steps, detector.counts.most_steps) >= proofs
    assert sorted(own.contacts.keys[:n_contacts].tolist()) == contacts
    assert own.counts[places.CONTACTS] == n_contacts


@pytest.mark.parametrize(("n_pairs", "n_contacts"), [(0, 500), (10, 500), (20_000, 0), (20_000, 3)])
def test_a_list_that_is_too_short_is_counted_to_its_end(rng, n_pairs, n_contacts):
    scene = scene_of(rng, 5)
    _, expected, *_ = detected(scene, n_pairs=20_000)
    own, counts, *_ = detected(scene, n_pairs=n_pairs, n_contacts=n_contacts)
    assert counts[places.PAIRS] == expected[places.PAIRS] > 10
    if n_pairs > 10:
        assert counts[places.CONTACTS] == expected[places.CONTACTS] > 3
    assert counts[places.MOVED] == expected[places.MOVED] == len(scene.masses)
    assert counts[places.FOUND] == 0
    assert np.isnan(own.path.seen).all(), "the same path can be detected again"


def test_with_a_contact_at_the_start_nothing_is_found_before_it_is_decided():
    scene = vertex_over_face(0.1)
    scene.positions_t0[3, 2] = 5e-324
    scene.positions_t1[3, 2] = -0.1
    for to_solve in (False, True):
        _, counts, *_ = detected(scene, to_solve)
        assert counts[places.CONTACTS] >= counts[places.AT_START] == 1
        assert counts[places.FOUND] == (0 if to_solve else counts[places.CONTACTS])

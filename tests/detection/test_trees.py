"""Trees of moving boxes: which pairs of elements they find."""

import numpy as np
import pytest

import izo_ref
from izo_ref.detection import trees as broad
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.serial.tree import box_of, meeting_lanes
from izo_ref.detection.trees import Elements, VertexBoxes, meeting_pairs
from tests.helpers.shapes import grid, two_sheets
from tests.naive.groups import moving_box_pairs

DTYPES = [np.float32, np.float64]
AXES_AND_SIDES = [(axis, side) for axis in range(3) for side in (-1.0, 1.0)]


def mesh(rng, n):
    """Return start, end and faces of a crumpled sheet of n x n vertices."""
    start, faces = grid(n, jitter=0.1 * rng.normal(size=(n * n, 3)))
    return start, start + 0.1 * rng.normal(size=start.shape), faces.astype(np.int32)


def trees(start, end, *nodes, moved=None, dtype=np.float32):
    """Return a tree for each array of elements.

    All elements issue queries, or, if `moved` is given, those with a moved vertex.
    """
    boxes = VertexBoxes(start, end, np.zeros(len(start)), dtype).boxes
    elements = [
        Elements(part, np.argsort(broad.morton_codes_of(start, part)).astype(np.int32), dtype)
        for part in nodes
    ]
    for part in elements:
        part.refit(boxes, np.ones(len(start), bool) if moved is None else moved, everything=True)
    return elements


def found(a, b):
    """Return the set of pairs that two trees find, and check that none comes twice."""
    pairs = meeting_pairs(a, b)
    rows = np.column_stack((a.tree.order[pairs[:, 0]], b.tree.order[pairs[:, 1]]))
    if a is b:
        rows.sort(axis=1)
    assert len(np.unique(rows, axis=0)) == len(rows), "a pair came twice"
    return {tuple(row) for row in rows.tolist()}


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("n", [2, 3, 6, 9, 16])
def test_pairs_are_those_of_a_search_of_all_against_all(rng, n, dtype):
    start, end, faces = mesh(rng, n)
    edges = edges_of(faces)
    vertices = np.arange(len(start), dtype=np.int32)[:, None]
    e, f, v = trees(start, end, edges, faces, vertices, dtype=dtype)
    assert found(e, e) == moving_box_pairs(edges, edges, start, end, True)
    assert found(v, f) == moving_box_pairs(vertices, faces, start, end, False)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    ("scale", "shift"),
    [(1e-310, 0.0), (1e-30, 1e3), (1.0, 0.0), (1.0, 1e3), (1.0, 1e9), (1e30, 1e9), (1e306, 0.0)],
)
def test_no_pair_is_lost_by_rounding(rng, scale, shift, dtype):
    """Far from the origin, many coordinates are equal in float32: that may only add pairs."""
    start, end, faces = mesh(rng, 5)
    start, end = (start + shift) * scale, (end + shift) * scale
    edges = edges_of(faces)
    (e,) = trees(start, end, edges, dtype=dtype)
    assert found(e, e) >= moving_box_pairs(edges, edges, start, end, True)


@pytest.mark.parametrize("where", ["start", "end", "both"])
def test_an_axis_separates_boxes_only_if_it_does_so_at_both_ends(where):
    """The vertex passes the face upwards or downwards, or stays below it at both ends."""
    below, above = np.array([0.2, 0.2, -1.0]), np.array([0.2, 0.2, 1.0])
    face = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    first = above if where == "end" else below
    last = above if where == "start" else below
    start, end = np.vstack((face, first)), np.vstack((face, last))
    v, f = trees(start, end, np.array([[3]], np.int32), np.array([[0, 1, 2]], np.int32))
    assert found(v, f) == (set() if where == "both" else {(0, 0)})


def test_pairs_cover_every_end_within_the_reach(rng):
    start, end, faces = mesh(rng, 6)
    edges = edges_of(faces)
    reach = 0.05 * rng.random(len(start))
    (e,) = trees(start, end, edges)
    e.refit(VertexBoxes(start, end, reach).boxes, np.ones(len(start), bool), True)
    pairs = found(e, e)
    for _ in range(20):
        other = end + reach[:, None] * rng.uniform(-1.0, 1.0, end.shape)
        assert pairs >= moving_box_pairs(edges, edges, start, other, True)


@pytest.mark.parametrize("n", [8, 20])
def test_only_pairs_with_a_moved_vertex_come_back(rng, n):
    start, end, faces = mesh(rng, n)
    edges = edges_of(faces)
    (every,) = trees(start, end, edges)
    moved = rng.random(len(start)) < 0.05
    (some,) = trees(start, end, edges, moved=moved)
    expected = {
        (i, j) for i, j in found(every, every) if moved[edges[i]].any() or moved[edges[j]].any()
    }
    assert 0 < len(expected) < len(found(every, every))
    assert found(some, some) == expected
    marks = np.unpackbits(some.tree.lanes[: some.tree.levels[1]], bitorder="little")
    assert marks[: len(edges)].tolist() == moved[some.tree.nodes].any(axis=1).tolist()


def test_a_tree_follows_the_vertices_that_moved(rng):
    start, end, faces = mesh(rng, 12)
    edges = edges_of(faces)
    (e,) = trees(start, start, edges)
    moved = rng.random(len(start)) < 0.1
    last = np.where(moved[:, None], end, start)
    boxes = VertexBoxes(start, last, np.zeros(len(start)))
    e.refit(boxes.boxes, moved, everything=False)
    (new,) = trees(start, last, edges, moved=moved)
    assert found(e, e) == found(new, new)


@pytest.mark.parametrize("dtype", DTYPES)
def test_boxes_that_only_touch_meet(dtype):
    start = np.array([[0, 0, 0], [1, 1, 0], [1, 1, 0], [2, 2, 0.0]])
    edges = np.array([[0, 1], [2, 3]], np.int32)
    (elements,) = trees(start, start, edges, dtype=dtype)
    assert found(elements, elements) == {(0, 1)}
    start[2, 0] = np.nextafter(1.0, 2.0)  # one ulp; the centre is subtracted before rounding
    (elements,) = trees(start, start, edges, dtype=dtype)
    assert found(elements, elements) == set()


def test_an_empty_tree_has_no_pairs():
    (empty,) = trees(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 2), np.int32))
    assert found(empty, empty) == set()


def test_a_tree_of_chosen_elements_finds_their_pairs_alone(rng):
    start, end, faces = mesh(rng, 6)
    edges = edges_of(faces)
    ids = rng.permutation(len(edges))[: len(edges) // 2].astype(np.int32)
    chosen = Elements(edges, ids)
    chosen.refit(
        VertexBoxes(start, end, np.zeros(len(start))).boxes, np.ones(len(start), bool), True
    )
    (every,) = trees(start, end, edges)
    own = set(ids.tolist())
    assert found(chosen, chosen) == {(i, j) for i, j in found(every, every) if {i, j} <= own}


@pytest.mark.parametrize("n", [0, 1, 2, 3, 10, 64, 101])
def test_each_chunk_is_searched_once(n):
    assert sorted(broad.scattered(n).tolist()) == list(range(n))


@pytest.mark.parametrize("room", [0, 1, 7])
def test_pairs_beyond_the_reserved_room_are_found(rng, monkeypatch, room):
    scene = two_sheets(rng)
    expected = izo_ref.find_impacts(scene)
    assert len(expected.toi) > 100
    monkeypatch.setattr(broad, "ROOM", room)
    for a, b in zip(expected, izo_ref.find_impacts(scene), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("axis", "side"), AXES_AND_SIDES)
@pytest.mark.parametrize("times", [(0, 6), (6, 0)], ids=["apart at the start", "at the end"])
def test_boxes_that_touch_meet_along_each_axis_from_both_sides(axis, side, dtype, times):
    block = np.empty((1, 12, 8), dtype)
    block[0] = np.array([0.0, 0, 0, 1, 1, 1] * 2, dtype)[:, None]
    for row in range(axis, 12, 3):
        block[0, row, 5] += side
    for time in times:
        inner = axis + time + (0 if side > 0.0 else 3)  # the side of the box that touches
        assert meeting_lanes(box_of(block, 0, 0), block, 0) == 255
        block[0, inner, 5] = np.nextafter(block[0, inner, 5], dtype(2.0 * side))
    assert meeting_lanes(box_of(block, 0, 0), block, 0) == 255 - 32

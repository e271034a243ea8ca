import numpy as np
import pytest

import izo_ref
from izo_ref import broad
from izo_ref.broad import Elements
from izo_ref.scene import edges_of
from izo_ref.serial.tree import GROUP, next_pairs
from tests.naive.groups import box_pairs
from tests.shapes import grid, two_sheets


def mesh(rng, n):
    start, faces = grid(n, jitter=0.1 * rng.normal(size=(n * n, 3)))
    return start, start + 0.1 * rng.normal(size=start.shape), faces.astype(np.int32)


def boxes_of(nodes, start, end):
    both = np.concatenate((start[nodes], end[nodes]), axis=1)
    return np.hstack((both.min(axis=1), both.max(axis=1)))


def found(a, b, room):
    """All pairs, through a buffer with room for so many."""
    pairs, buffer = [], np.empty((room, 2), np.int32)
    for group in range(-(-len(a.tree.order) // GROUP)):
        node = -1
        while node != 0:
            count, node = next_pairs(group, max(node, 0), a.tree, b.tree, a is b, buffer)
            pairs += buffer[:count].tolist()
    pairs = np.array(pairs, int).reshape(-1, 2)
    rows = np.column_stack((a.tree.order[pairs[:, 0]], b.tree.order[pairs[:, 1]]))
    if a is b:
        rows.sort(axis=1)
    assert len(np.unique(rows, axis=0)) == len(rows), "a pair came twice"
    return {tuple(row) for row in rows.tolist()}


@pytest.mark.parametrize("n", [2, 3, 6, 9])
@pytest.mark.parametrize("room", [GROUP**2, 50, 10**4])
def test_pairs_are_those_of_all_against_all(rng, n, room):
    start, end, faces = mesh(rng, n)
    edges = edges_of(faces)
    vertices = np.arange(len(start), dtype=np.int32)[:, None]
    e, f, v = (Elements(nodes, start, end) for nodes in (edges, faces, vertices))
    boxes = {id(x): boxes_of(x, start, end) for x in (edges, faces, vertices)}
    expected = box_pairs(boxes[id(edges)], edges, boxes[id(edges)], edges, True)
    assert found(e, e, room) == expected
    expected = box_pairs(boxes[id(vertices)], vertices, boxes[id(faces)], faces, False)
    assert found(v, f, room) == expected


def test_only_pairs_with_a_moved_vertex_come_back(rng):
    start, end, faces = mesh(rng, 8)
    edges = edges_of(faces)
    elements = Elements(edges, start, end)
    every = found(elements, elements, 1000)
    moved = rng.random(len(start)) < 0.1
    elements.refit(start, end, moved)
    expected = {(i, j) for i, j in every if moved[edges[i]].any() or moved[edges[j]].any()}
    assert found(elements, elements, 1000) == expected


def test_boxes_that_only_touch_meet():
    start = np.array([[0, 0, 0], [1, 1, 0], [1, 1, 0], [2, 2, 0.0]])
    elements = Elements(np.array([[0, 1], [2, 3]], np.int32), start, start)
    assert found(elements, elements, 100) == {(0, 1)}
    start[2, 0] = np.nextafter(1.0, 2.0)
    elements = Elements(np.array([[0, 1], [2, 3]], np.int32), start, start)
    assert found(elements, elements, 100) == set()


def test_nothing_in_nothing_out():
    empty = Elements(np.empty((0, 2), np.int32), np.empty((0, 3)), np.empty((0, 3)))
    assert found(empty, empty, 100) == set()


@pytest.mark.parametrize("n", [0, 1, 2, 3, 10, 64, 101])
def test_each_chunk_is_searched_once(n):
    assert sorted(broad._scattered(n).tolist()) == list(range(n))


@pytest.mark.parametrize("room", [0, 1, 7])
def test_what_finds_no_room_is_found_all_the_same(rng, monkeypatch, room):
    scene = two_sheets(rng)
    expected = izo_ref.find_impacts(scene)
    assert len(expected.toi) > 100
    monkeypatch.setattr(broad, "ROOM", room)
    for a, b in zip(expected, izo_ref.find_impacts(scene), strict=True):
        np.testing.assert_array_equal(a, b)

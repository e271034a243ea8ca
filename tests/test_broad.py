import numpy as np
import pytest

from izo_ref.broad import Elements, candidate_batches
from izo_ref.scene import edges_of
from tests.naive.groups import box_pairs
from tests.shapes import grid


def mesh(rng, n):
    start, faces = grid(n, jitter=0.1 * rng.normal(size=(n * n, 3)))
    return start, start + 0.1 * rng.normal(size=start.shape), faces.astype(np.int32)


def boxes_of(nodes, start, end):
    both = np.concatenate((start[nodes], end[nodes]), axis=1)
    return np.hstack((both.min(axis=1), both.max(axis=1)))


def found(a, b, batch):
    pairs = [np.empty((0, 2), int), *candidate_batches(a, b, batch)]
    pairs = np.concatenate(pairs)
    rows = np.column_stack((a.order[pairs[:, 0]], b.order[pairs[:, 1]]))
    if a is b:
        rows.sort(axis=1)
    assert len(np.unique(rows, axis=0)) == len(rows), "a pair came twice"
    return {tuple(row) for row in rows.tolist()}


@pytest.mark.parametrize("n", [2, 3, 6, 9])
@pytest.mark.parametrize("batch", [1, 50, 10**6])
def test_pairs_are_those_of_all_against_all(rng, n, batch):
    start, end, faces = mesh(rng, n)
    edges = edges_of(faces)
    vertices = np.arange(len(start), dtype=np.int32)[:, None]
    e, f, v = (Elements(nodes, start, end) for nodes in (edges, faces, vertices))
    boxes = {id(x): boxes_of(x, start, end) for x in (edges, faces, vertices)}
    expected = box_pairs(boxes[id(edges)], edges, boxes[id(edges)], edges, True)
    assert found(e, e, batch) == expected
    expected = box_pairs(boxes[id(vertices)], vertices, boxes[id(faces)], faces, False)
    assert found(v, f, batch) == expected


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
    assert found(elements, elements, 10) == {(0, 1)}
    start[2, 0] = np.nextafter(1.0, 2.0)
    elements = Elements(np.array([[0, 1], [2, 3]], np.int32), start, start)
    assert found(elements, elements, 10) == set()


def test_nothing_in_nothing_out():
    empty = Elements(np.empty((0, 2), np.int32), np.empty((0, 3)), np.empty((0, 3)))
    assert found(empty, empty, 10) == set()

"""Stage S1 by our own functions: the pairs of elements whose moving boxes meet."""

from typing import Any

import numpy as np

from izo_ref.base.arrays import Ints
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.trees import Elements, VertexBoxes, meeting_pairs, tree_orders
from izo_ref.porting.judge.superset import EDGE_EDGE, VERTEX_FACE, pair_key, rows_of
from validation.ladders.stage_answer import Answer, Inputs


def candidate_pairs(inputs: Inputs, kind: type[Any] = np.float64) -> Answer:
    """Stage S1, with boxes of a type of floats; it only decides."""
    return Answer({}, pair_keys(**listed_pairs(inputs, kind)))


def pair_keys(vertex_face: list[int], edge_edge: list[int]) -> frozenset[Any]:
    """Return what all ways to write these pairs have in common.

    Args:
        vertex_face: The vertex, then the corners of the face, of each pair, flat.
        edge_edge: The ends of one edge, then of the other, of each pair, flat.
    """
    lists = {VERTEX_FACE: vertex_face, EDGE_EDGE: edge_edge}
    keys = ((kind, pair_key(kind, row)) for kind, flat in lists.items() for row in rows_of(flat))
    return frozenset(keys)


def listed_pairs(inputs: Inputs, kind: type[Any]) -> dict[str, list[int]]:
    """Return the vertices of the pairs whose moving boxes meet, flat, by the names of the stage.

    Args:
        inputs: The inputs of the stage.
        kind: Type of the floats of the boxes; positions are float64.
    """
    start = np.array(inputs["positions_t0"], np.float64).reshape(-1, 3)
    end = np.array(inputs["positions_t1"], np.float64).reshape(-1, 3)
    faces = np.array(inputs["faces"], np.int32).reshape(-1, 3)
    edges = edges_of(faces)
    vertices = np.arange(len(start), dtype=np.int32)[:, None]
    boxes = VertexBoxes(start, end, np.zeros(len(start)), kind, edges)
    orders = tree_orders(start, edges, faces)
    trees = [
        Elements(nodes, order, kind)
        for nodes, order in zip((vertices, edges, faces), orders, strict=True)
    ]
    for tree in trees:
        tree.refit(boxes.boxes, np.ones(len(start), bool), everything=True)
    return {
        "vertex_face": _nodes_of_pairs(trees[0], trees[2]),
        "edge_edge": _nodes_of_pairs(trees[1], trees[1]),
    }


def _nodes_of_pairs(first: Elements, second: Elements) -> list[int]:
    pairs: Ints = meeting_pairs(first, second)
    nodes = first.tree.nodes[pairs[:, 0]], second.tree.nodes[pairs[:, 1]]
    return np.hstack(nodes).ravel().tolist()

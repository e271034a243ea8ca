"""Stage S1 by our own functions."""

from typing import Any

import numpy as np

from izo_ref.base.arrays import Ints
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.trees import Elements, VertexBoxes, meeting_pairs, tree_orders

DTYPES = {"f8": np.float64, "f4": np.float32}


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the pairs whose moving boxes meet; the type of floats is that of the boxes."""
    start = np.array(inputs["positions_t0"], np.float64).reshape(-1, 3)
    end = np.array(inputs["positions_t1"], np.float64).reshape(-1, 3)
    faces = np.array(inputs["faces"], np.int32).reshape(-1, 3)
    edges = edges_of(faces)
    vertices = np.arange(len(start), dtype=np.int32)[:, None]
    boxes = VertexBoxes(start, end, np.zeros(len(start)), DTYPES[dtype], edges)
    orders = tree_orders(start, edges, faces)
    trees = [
        Elements(nodes, order, DTYPES[dtype])
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

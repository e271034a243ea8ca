"""Try to settle pairs in float32, before float64 proves the rest.

Only a GPU does so. The float32 positions are those of the boxes of vertices, which a GPU has in any
case: it reads half as many bytes a pair, and computes nothing in float64 for a pair that is
settled. On the CPU float64 is as fast as float32, and in deep contact the filter costs more than it
saves elsewhere (`reports/cuda/` has the times).

The filter has a launch, or a part of a launch, of its own. Threads of a GPU run in groups of 32,
and nearly every group has a pair that is left open. If each thread went on in float64 with its own
pair, nearly all groups would run at the speed of float64.
"""

from izo_ref.base.arrays import AnyFloats, AnyInt, Vec3
from izo_ref.base.compile import compiled
from izo_ref.detection.formulas.filter import FourVec3, is_surely_apart


@compiled
def _ends(vertex_boxes: AnyFloats, i: AnyInt, first: int) -> Vec3:
    """Return three columns of row i, from column `first` on."""
    return (vertex_boxes[i, first], vertex_boxes[i, first + 1], vertex_boxes[i, first + 2])


@compiled
def _ends_of_nodes(
    vertex_boxes: AnyFloats, nodes: tuple[int, int, int, int], first: int
) -> FourVec3:
    """Return the positions of four vertices at the start (first = 0) or at the end (first = 3)."""
    return (
        _ends(vertex_boxes, nodes[0], first),
        _ends(vertex_boxes, nodes[1], first),
        _ends(vertex_boxes, nodes[2], first),
        _ends(vertex_boxes, nodes[3], first),
    )


@compiled
def is_settled(
    is_edge_edge: bool, nodes: tuple[int, int, int, int], vertex_boxes: AnyFloats
) -> bool:
    """Return whether float32 proves that a pair stays apart; False says nothing.

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        nodes: The four vertices of the pair, as `pair_nodes` returns them.
        vertex_boxes: (n_vertices, 9) f4, of `vertex_box` with a reach of zero: then the lowest and
            the highest end of a vertex are where it ends.
    """
    start, end = _ends_of_nodes(vertex_boxes, nodes, 0), _ends_of_nodes(vertex_boxes, nodes, 3)
    return is_surely_apart(is_edge_edge, start, end)

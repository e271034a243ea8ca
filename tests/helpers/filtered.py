"""Which pairs the float32 filter settles, for pairs that were drawn."""

import numpy as np

from izo_ref.base.compile import light_kernel
from izo_ref.detection.serial.boxes import vertex_box
from izo_ref.detection.trees import box_frame
from validation.study.gpu_filter import flag_settled


@light_kernel
def fill_boxes(
    # In:
    start,  # (n, 3) f8
    end,  # (n, 3) f8
    origin,  # (3,) f8
    scale,  # f8
    # Out:
    boxes_out,  # (n, 9) f4
) -> None:
    """Compute the float32 positions of vertices, as a GPU does."""
    for i in range(start.shape[0]):
        vertex_box(i, start, end, 0.0, origin, scale, boxes_out)


def boxes_of(start, end, frame):
    """Return the float32 positions of points (n, 3), in a frame: its origin (3,) and its scale."""
    boxes = np.empty((len(start), 9), np.float32)
    fill_boxes(start, end, *frame, boxes)
    return boxes


def settled_pairs(is_edge_edge, start, end, frame=None):
    """Return which pairs of one kind the filter settles.

    Args:
        is_edge_edge: kind of all pairs.
        start, end: (n, 4, 3) positions of their nodes.
        frame: origin (3,) and scale of the coordinates of boxes, of all pairs together; None for
            that of a mesh that is made of all of them.
    """
    n = len(start)
    own = [np.ascontiguousarray(part.reshape(-1, 3)) for part in (start, end)]
    boxes = boxes_of(*own, frame or box_frame(own[0]))
    nodes, order = np.arange(4 * n, dtype=np.int32).reshape(n, 4), np.arange(n, dtype=np.int32)
    size = 2 if is_edge_edge else 1
    first, second = (np.ascontiguousarray(part) for part in np.split(nodes, [size], axis=1))
    settled = np.empty(n, bool)
    flag_settled(np.column_stack((order, order)), order, first, order, second, boxes, settled)
    return settled


def each_in_its_frame(is_edge_edge, start, end):
    """Return which pairs the filter settles if each of them is a mesh of its own."""
    parts = ((start[i : i + 1], end[i : i + 1]) for i in range(len(start)))
    return np.array([settled_pairs(is_edge_edge, *part)[0] for part in parts])

"""Fit the boxes of elements and of the trees over them."""

from izo_ref.base.arrays import AnyFloats, Bits, Flags, Floats, Indices, Ints, Offsets, Positions
from izo_ref.base.compile import light_kernel
from izo_ref.detection.serial.boxes import (
    element_block,
    morton_code,
    moved_lanes_of,
    parent_block,
    vertex_box,
)
from izo_ref.detection.serial.tree import WIDTH


@light_kernel
def compute_vertex_boxes(
    # In:
    wanted: Flags,  # (n_vertices,) b1
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    centres: Positions,  # (n_vertices, 3) f8  [m], about which the vertices end
    reach: Floats,  # (n_vertices,) f8  [m], how far from them, along each axis
    origin: Floats,  # (3,) f8  [m]
    scale: float,  # f8  [1/m], a power of two
    # Out:
    boxes_out: AnyFloats,  # (n_vertices, 9) f4, start, lowest end, highest end; without unit
) -> None:
    """Compute the start and the box of the end of each wanted vertex."""
    for i in range(positions_t0.shape[0]):
        if wanted[i]:
            # A vertex is within its reach only up to the rounding of the difference that was
            # compared; the factor covers that.
            own = reach[i] * (1.0 + 2.0**-50)
            vertex_box(i, positions_t0, centres, own, origin, scale, boxes_out)


@light_kernel
def compute_morton_codes(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Ints,  # (n, k) i4
    origin: Floats,  # (3,) f8  [m]
    cells_per_m: float,  # f8  [1/m], 2^21 cells over the widest extent
    # Out:
    codes_out: Indices,  # (n,) i8, of the mean of the nodes: 21 bits an axis, interleaved
) -> None:
    """Compute the Morton code of each element."""
    for i in range(nodes.shape[0]):
        codes_out[i] = morton_code(i, positions, nodes, origin, cells_per_m)


@light_kernel
def fit_tree(
    # In:
    vertex_moved: Flags,  # (n_vertices,) b1
    vertex_boxes: AnyFloats,  # (n_vertices, 9) f4
    everything: bool,  # b1, whether to fit all boxes, or only those with a mark
    nodes: Ints,  # (n_elements, k) i4
    levels: Offsets,  # (n_levels + 1,) i8, the first block of each level, and the end
    # Out:
    lanes_out: Bits,  # (m,) u1, bit k: a vertex in or below lane k of the block moved
    blocks_out: AnyFloats,  # (m, ROWS, WIDTH) f4
) -> None:
    """Mark the elements that have a moved vertex, and fit boxes and those above them."""
    for block in range((nodes.shape[0] + WIDTH - 1) // WIDTH):
        lanes_out[block] = moved_lanes_of(block, vertex_moved, nodes)
        if everything or lanes_out[block] != 0:
            element_block(block, vertex_boxes, nodes, blocks_out)
    for level in range(levels.shape[0] - 2):
        first, end = levels[level], levels[level + 1]
        for parent in range((end - first + WIDTH - 1) // WIDTH):
            parent_block(parent, first, end, everything, lanes_out, blocks_out)

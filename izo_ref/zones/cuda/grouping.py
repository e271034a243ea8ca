"""Group impacts that share an unpinned vertex, and choose zones, on a GPU.

Impacts that share an unpinned vertex, directly or through other impacts, get one label. Each vertex
starts with its own number as its label. The least label at an impact goes to the roots of its
vertices, again and again until nothing changes. Then the label of a vertex is the least vertex of
its zone, in whatever order the threads ran.
"""

from numba import cuda

from izo_ref.base.arrays import Flags, Indices, Nodes, Offsets
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.serial.search import block_of


@cuda_kernel
def join_labels(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    # Out:
    labels_out: Indices,  # (n_vertices,) i8, a vertex of the same zone, at most the own number
    changed_out: Indices,  # (1,) i8, becomes 1 if a label changed
) -> None:
    """Give the least label at each impact to all of its unpinned vertices and to their roots."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        least = labels_out.shape[0]
        for k in range(4):
            if not pinned[nodes[j, k]]:
                least = min(least, labels_out[nodes[j, k]])
        for k in range(4):
            if not pinned[nodes[j, k]]:
                label = labels_out[nodes[j, k]]
                if label > least:
                    cuda.atomic.min(labels_out, label, least)
                    cuda.atomic.min(labels_out, nodes[j, k], least)
                    changed_out[0] = 1


@cuda_kernel
def shorten_labels(
    # In:
    labels: Indices,  # (n_vertices,) i8
    # Out:
    labels_out: Indices,  # (n_vertices,) i8
) -> None:
    """Replace each label by the last one on the way from label to label."""
    v = cuda.grid(1)
    if v < labels.shape[0]:
        label = labels[v]
        while labels[label] < label:
            label = labels[label]
        labels_out[v] = label


@cuda_kernel
def label_impacts(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    labels: Indices,  # (n_vertices,) i8
    # Out:
    components_out: Indices,  # (n_impacts,) i8, least vertex of the zone; -1 if all are pinned
    joined_out: Flags,  # (n_vertices,) b1, becomes true for the unpinned vertices of impacts
) -> None:
    """Give each impact the label of its unpinned vertices, and mark these vertices."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        components_out[j] = -1
        for k in range(4):
            if not pinned[nodes[j, k]]:
                components_out[j] = labels[nodes[j, k]]
                joined_out[nodes[j, k]] = True


@cuda_kernel
def flag_grouped(
    # In:
    components: Indices,  # (n_impacts,) i8
    # Out:
    grouped_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that belong to a zone."""
    j = cuda.grid(1)
    if j < components.shape[0]:
        grouped_out[j] = components[j] >= 0


@cuda_kernel
def flag_first(
    # In:
    keys: Indices,  # (n,) i8, ascending
    # Out:
    first_out: Flags,  # (n + 1,) b1
) -> None:
    """Mark where a key differs from the one before it, and the end of the keys."""
    i = cuda.grid(1)
    if i <= keys.shape[0]:
        first_out[i] = i == 0 or i == keys.shape[0] or keys[i] != keys[i - 1]


@cuda_kernel
def find_blocks(
    # In:
    offsets: Offsets,  # (n_blocks + 1,) i8, where each block begins, and the end
    # Out:
    blocks_out: Indices,  # (offsets[n_blocks],) i8
) -> None:
    """Find the block that each entry is in."""
    i = cuda.grid(1)
    if i < blocks_out.shape[0]:
        blocks_out[i] = block_of(i, offsets)


@cuda_kernel
def flag_members(
    # In:
    block_of_each: Indices,  # (n,) i8
    chosen: Flags,  # (n_blocks,) b1
    # Out:
    members_out: Flags,  # (n,) b1
) -> None:
    """Mark the entries whose block is chosen."""
    i = cuda.grid(1)
    if i < block_of_each.shape[0]:
        members_out[i] = chosen[block_of_each[i]]


@cuda_kernel
def count_members(
    # In:
    offsets: Offsets,  # (n_blocks + 1,) i8, where each block begins, and the end
    # Out:
    sizes_out: Indices,  # (n_blocks,) i8
) -> None:
    """Count the entries of each block."""
    i = cuda.grid(1)
    if i < sizes_out.shape[0]:
        sizes_out[i] = offsets[i + 1] - offsets[i]

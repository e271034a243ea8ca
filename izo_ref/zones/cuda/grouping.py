"""Zones: which impacts are of one, their rows in scaled variables, and the small ones solved.

Impacts that share an unpinned vertex, directly or through others, get one number. Each vertex
begins with its own, and the least one at an impact is handed to the roots of its vertices until
nothing changes: what is left is the least vertex of each zone, whatever the order of threads was.
"""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel


@cuda_kernel
def join_labels(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    # Out:
    labels_out,  # (n_vertices,) i8, a vertex of the same zone, not above the own number
    changed_out,  # (1,) i8, not 0 if one did
):
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
    labels,  # (n_vertices,) i8
    # Out:
    labels_out,  # (n_vertices,) i8, the end of the way from label to label
):
    v = cuda.grid(1)
    if v < labels.shape[0]:
        label = labels[v]
        while labels[label] < label:
            label = labels[label]
        labels_out[v] = label


@cuda_kernel
def label_impacts(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    labels,  # (n_vertices,) i8
    # Out:
    components_out,  # (n_impacts,) i8, the smallest unpinned vertex joined, -1 if all pinned
    joined_out,  # (n_vertices,) b1, true for unpinned ones of impacts
):
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
    components,  # (n_impacts,) i8
    # Out:
    free_out,  # (n_impacts,) b1, has a component
):
    j = cuda.grid(1)
    if j < components.shape[0]:
        free_out[j] = components[j] >= 0


@cuda_kernel
def flag_first(
    # In:
    keys,  # (n,) i8, ascending
    # Out:
    first_out,  # (n + 1,) b1, not the same as before; and behind the last
):
    i = cuda.grid(1)
    if i <= keys.shape[0]:
        first_out[i] = i == 0 or i == keys.shape[0] or keys[i] != keys[i - 1]

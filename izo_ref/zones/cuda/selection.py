"""Select which of the impacts found enter the zones, in rounds over all impacts at once.

Each round takes every impact that is the earliest undecided one at all of its unpinned vertices,
and drops the impacts that share an unpinned vertex with an impact that was taken. The result is the
same as in `zones/serial/selection.py`, which takes one impact after the other. Vertices are claimed
by integer minima, so the order in which the threads run does not matter.

In deep zones (`zones/serial/deep_selection.py`), impacts claim their main vertices only, and those
that have to wait are dropped before the first round.
"""

from numba import cuda

from izo_ref.base.arrays import (
    Codes,
    Flags,
    Floats,
    Indices,
    Ints,
    Nodes,
    Normals,
    Offsets,
    Positions,
    Weights,
)
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.zones.serial.deep_selection import (
    decide_depth,
    is_early,
    main_vertices,
    relative_depth,
)

UNDECIDED, TAKEN, DROPPED = 0, 1, 2
# Added to the sorting keys of edge-edge impacts, so that they come behind all vertex-face impacts.
# The bits of a time up to 1, read as an integer, are below it.
BEHIND = 1 << 62


@cuda_kernel
def rank_impacts(
    # In:
    order: Indices,  # (n_impacts,) i8, impacts by time of impact
    # Out:
    ranks_out: Indices,  # (n_impacts,) i8
) -> None:
    """Write the rank of each impact, its place in the order of times."""
    i = cuda.grid(1)
    if i < order.shape[0]:
        ranks_out[order[i]] = i


@cuda_kernel
def claim_vertices(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    ranks: Indices,  # (n_impacts,) i8
    states: Codes,  # (n_impacts,) i1
    # Out:
    owners_out: Indices,  # (n_vertices,) i8, n_impacts before, and where no impact is undecided
) -> None:
    """Write the lowest rank of the undecided impacts at each unpinned vertex."""
    j = cuda.grid(1)
    if j < nodes.shape[0] and states[j] == UNDECIDED:
        for k in range(4):
            if not pinned[nodes[j, k]]:
                cuda.atomic.min(owners_out, nodes[j, k], ranks[j])


@cuda_kernel
def take_owners(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    ranks: Indices,  # (n_impacts,) i8
    owners: Indices,  # (n_vertices,) i8
    all_new: bool,  # b1, whether it has to own every unpinned vertex (`independent`), not only one
    # Out:
    states_out: Codes,  # (n_impacts,) i1
    seen_out: Flags,  # (n_vertices,) b1, becomes true for the vertices of impacts that are taken
) -> None:
    """Take the undecided impacts that own their unpinned vertices."""
    j = cuda.grid(1)
    if j < nodes.shape[0] and states_out[j] == UNDECIDED:
        n_unpinned, n_own = 0, 0
        for k in range(4):
            if not pinned[nodes[j, k]]:
                n_unpinned += 1
                n_own += owners[nodes[j, k]] == ranks[j]
        if (n_own == n_unpinned) if all_new else (n_own > 0):
            states_out[j] = TAKEN
            for k in range(4):
                seen_out[nodes[j, k]] = True


@cuda_kernel
def drop_others(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    seen: Flags,  # (n_vertices,) b1
    # Out:
    states_out: Codes,  # (n_impacts,) i1
    undecided_out: Flags,  # (n_impacts,) b1
) -> None:
    """Drop the undecided impacts at an unpinned vertex that was seen, and mark the others."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        for k in range(4):
            if states_out[j] == UNDECIDED and seen[nodes[j, k]] and not pinned[nodes[j, k]]:
                states_out[j] = DROPPED
        undecided_out[j] = states_out[j] == UNDECIDED


@cuda_kernel
def flag_taken(
    # In:
    states: Codes,  # (n_impacts,) i1
    # Out:
    taken_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that were taken."""
    j = cuda.grid(1)
    if j < states.shape[0]:
        taken_out[j] = states[j] == TAKEN


@cuda_kernel
def compute_relative_depths(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    is_edge_edge: Flags,  # (n_impacts,) b1
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    # Out:
    depths_out: Floats,  # (n_impacts,) f8, in longest edges
) -> None:
    """Compute how deep each impact ends, over the longest edge of its elements."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        depths_out[j] = relative_depth(
            j, positions_t0, positions, nodes, is_edge_edge, weights, normals
        )


@cuda_kernel
def decide_depths(
    # In:
    impacts: Indices,  # (n,) i8, zone by zone
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    depths: Floats,  # (n_impacts,) f8, in longest edges
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    # Out:
    known_out: Ints,  # (n_vertices,) i4, of the vertices of impacts; read, too
    deep_out: Flags,  # (n_impacts,) b1
) -> None:
    """Decide which zones are deep, a thread for each, and mark their impacts and vertices."""
    zone = cuda.grid(1)
    if zone < impact_offsets.shape[0] - 1:
        decide_depth(zone, impacts, impact_offsets, depths, nodes, pinned, known_out, deep_out)


@cuda_kernel
def drop_impacts(
    # In:
    flags: Flags,  # (n_impacts,) b1
    # Out:
    states_out: Codes,  # (n_impacts,) i1, of the impacts that are marked
) -> None:
    """Drop the impacts that are marked."""
    j = cuda.grid(1)
    if j < flags.shape[0] and flags[j]:
        states_out[j] = DROPPED


@cuda_kernel
def claim_first_times(
    # In:
    time_bits: Indices,  # (n_impacts,) i8, bits of the times of impact
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    pinned: Flags,  # (n_vertices,) b1
    # Out:
    mains_out: Nodes,  # (n_impacts, 4) i4, each of the two main vertices twice
    first_bits_out: Indices,  # (n_vertices,) i8, bits of infinity before
) -> None:
    """Write the main vertices of each impact, and the first time at which a vertex is one."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        first, second = main_vertices(j, nodes, weights, pinned)
        mains_out[j, 0], mains_out[j, 1] = first, first
        mains_out[j, 2], mains_out[j, 3] = second, second
        cuda.atomic.min(first_bits_out, first, time_bits[j])
        cuda.atomic.min(first_bits_out, second, time_bits[j])


@cuda_kernel
def drop_late_impacts(
    # In:
    toi: Floats,  # (n_impacts,) f8
    time_bits: Indices,  # (n_impacts,) i8, bits of the times of impact
    is_edge_edge: Flags,  # (n_impacts,) b1
    mains: Nodes,  # (n_impacts, 4) i4
    first_times: Floats,  # (n_vertices,) f8
    deep: Flags,  # (n_impacts,) b1
    # Out:
    keys_out: Indices,  # (n_impacts,) i8, sort impacts by kind and time
    states_out: Codes,  # (n_impacts,) i1, of the impacts of deep zones
) -> None:
    """Drop the deep impacts that have to wait, and write the keys by which impacts are sorted."""
    j = cuda.grid(1)
    if j < mains.shape[0]:
        keys_out[j] = time_bits[j] + (BEHIND if is_edge_edge[j] else 0)
        if deep[j]:
            states_out[j] = UNDECIDED if is_early(j, toi, mains, first_times) else DROPPED

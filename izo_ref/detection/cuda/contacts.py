"""Pairs of two trees whose boxes meet, and those that meet themselves."""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.detection.serial.contacts import contacts_of_pairs, pair_key, pair_nodes
from izo_ref.detection.serial.tree import WIDTH, pairs_of_block

# Queries, or pairs, that a thread takes.
CHUNK = 1
# What makes a key of elements, which is not negative, come before all that are not.
BEFORE = -(2**63)


@cuda_kernel
def find_pairs(
    # In:
    chunks,  # (n,) i8, which queries: chunk c has CHUNK of them, from CHUNK * c on
    starts,  # (n + 1,) i8, where each chunk writes, and how much room it has
    queries,  # Tree
    leaves,  # Tree
    against_itself,  # b1, they are the same
    # Out:
    counts_out,  # (n,) i8, pairs of each chunk, also those without room
    pairs_out,  # (starts[n], 2) i4, places of the elements of each pair
):
    k = cuda.grid(1)
    if k < chunks.shape[0]:
        block, lane = chunks[k] // WIDTH, chunks[k] % WIDTH
        counts_out[k] = pairs_of_block(
            block, 1 << lane, queries, leaves, against_itself, starts[k], starts[k + 1], pairs_out
        )


@cuda_kernel
def find_contacts(
    # In:
    chunks,  # (n,) i8, which pairs: chunk c has CHUNK of them, from CHUNK * c on
    pairs,  # (n_pairs, 2) i4, places
    first_order,  # (n_queries,) i4
    first_nodes,  # (n_queries, k) i4, of vertices or edges
    second_order,  # (n_leaves,) i4
    second_nodes,  # (n_leaves, l) i4, of faces or edges
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    reach,  # (n_vertices,) f8  [m], each may end so far from positions_t1, along each axis
    max_steps,  # i8, proofs before a pair is given up, which then counts as a contact
    # Out:
    tallies_out,  # (n, 3) i8, contacts, proofs, the most proofs for one
    index_out,  # (n_pairs,) i8, contacts of chunk c stand from CHUNK * c on
    toi_out,  # (n_pairs,) f8
    directions_out,  # (n_pairs, 3) f8
):
    k = cuda.grid(1)
    if k < chunks.shape[0]:
        c = chunks[k]
        tallies_out[c, 0], tallies_out[c, 1], tallies_out[c, 2] = contacts_of_pairs(
            c,
            c + 1,
            pairs,
            first_order,
            first_nodes,
            second_order,
            second_nodes,
            positions_t0,
            positions_t1,
            reach,
            max_steps,
            index_out,
            toi_out,
            directions_out,
        )


@cuda_kernel
def gather_contacts(
    # In:
    index,  # (n,) i8, which of the pairs
    pairs,  # (n_pairs, 2) i4, places
    pair_toi,  # (n_pairs,) f8
    pair_directions,  # (n_pairs, 3) f8
    first,  # Tree, of vertices or edges
    second,  # Tree, of faces or edges
    # Out:
    keys_out,  # (n,) i8, by elements, vertex-face pairs before edge-edge pairs
    nodes_out,  # (n, 4) i4, vertex then face, or edge then edge
    is_edge_edge_out,  # (n,) b1
    toi_out,  # (n,) f8
    directions_out,  # (n, 3) f8
):
    i = cuda.grid(1)
    if i < index.shape[0]:
        j = index[i]
        a, b = pairs[j, 0], pairs[j, 1]
        is_edge_edge = first.nodes.shape[1] == 2
        key = pair_key(a, b, first.order, first.nodes, second.order)
        keys_out[i] = key if is_edge_edge else key + BEFORE
        is_edge_edge_out[i], toi_out[i] = is_edge_edge, pair_toi[j]
        nodes = pair_nodes(a, b, first.order, first.nodes, second.order, second.nodes)
        for k in range(4):
            nodes_out[i, k] = nodes[k]
        for axis in range(3):
            directions_out[i, axis] = pair_directions[j, axis]

"""Find the pairs of two trees whose boxes meet, and the contacts among them."""

# The types of numba-cuda say that `cuda.grid` takes other arguments than it does.
# pyright: reportCallIssue=false

from numba import cuda

from izo_ref.base.arrays import Flags, Floats, Indices, Ints, Nodes, Offsets, Positions, Times
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.detection.serial.contacts import contacts_of_pairs, pair_key, pair_nodes
from izo_ref.detection.serial.tree import WIDTH, Tree, pairs_of_block

# Number of queries, or of pairs, that a thread takes.
CHUNK = 1


@cuda_kernel
def find_pairs(
    # In:
    chunks: Indices,  # (n,) i8, chunks of queries; chunk c has CHUNK of them, from CHUNK * c on
    starts: Offsets,  # (n + 1,) i8, where each chunk writes, and where its room ends
    queries: Tree,  # Tree
    leaves: Tree,  # Tree
    against_itself: bool,  # b1, both are the same tree
    # Out:
    counts_out: Indices,  # (n,) i8, pairs of each chunk, also those without room
    pairs_out: Ints,  # (starts[n], 2) i4, places of the elements of each pair
) -> None:
    """Find the pairs of some chunks of queries whose moving boxes meet a leaf's."""
    k = cuda.grid(1)
    if k < chunks.shape[0]:
        block, lane = chunks[k] // WIDTH, chunks[k] % WIDTH
        counts_out[k] = pairs_of_block(
            block, 1 << lane, queries, leaves, against_itself, starts[k], starts[k + 1], pairs_out
        )


@cuda_kernel
def find_contacts(
    # In:
    chunks: Indices,  # (n,) i8, chunks of pairs; chunk c has CHUNK of them, from CHUNK * c on
    pairs: Ints,  # (n_pairs, 2) i4, places
    first_order: Ints,  # (m,) i4, element in each place of the tree of vertices or edges
    first_nodes: Ints,  # (m, k) i4, its vertices
    second_order: Ints,  # (m,) i4, of the tree of faces or edges
    second_nodes: Ints,  # (m, k) i4
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    # Out:
    tallies_out: Indices,  # (n, 3) i8, contacts, steps of all proofs, steps of the longest
    index_out: Indices,  # (n_pairs,) i8, the pair of each contact; chunk c writes from CHUNK * c on
    toi_out: Times,  # (n_pairs,) f8, time until which the contact is proved apart
    directions_out: Floats,  # (n_pairs, 3) f8, the last direction that separated its sides
    margins_out: Floats,  # (n_pairs,) f8  [m], how far its vertices may end from positions_t1
) -> None:
    """Find the contacts among the pairs of some chunks: those that are not proved apart."""
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
            index_out,
            toi_out,
            directions_out,
            margins_out,
        )


@cuda_kernel
def gather_contacts(
    # In:
    index: Indices,  # (n,) i8, the pair of each contact
    pairs: Ints,  # (n_pairs, 2) i4, places
    pair_toi: Times,  # (n_pairs,) f8
    pair_directions: Floats,  # (n_pairs, 3) f8
    first: Tree,  # Tree, of vertices or edges
    second: Tree,  # Tree, of faces or edges
    # Out:
    keys_out: Indices,  # (n,) i8, to sort by elements, vertex-face pairs before edge-edge pairs
    nodes_out: Nodes,  # (n, 4) i4, vertex then face, or edge then edge
    is_edge_edge_out: Flags,  # (n,) b1
    toi_out: Times,  # (n,) f8
    directions_out: Floats,  # (n, 3) f8
) -> None:
    """Gather the keys, vertices, kinds, times and directions of the contacts."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        j = index[i]
        a, b = pairs[j, 0], pairs[j, 1]
        keys_out[i] = pair_key(a, b, first.order, first.nodes, second.order)
        is_edge_edge_out[i], toi_out[i] = first.nodes.shape[1] == 2, pair_toi[j]
        nodes = pair_nodes(a, b, first.order, first.nodes, second.order, second.nodes)
        for k in range(4):
            nodes_out[i, k] = nodes[k]
        for axis in range(3):
            directions_out[i, axis] = pair_directions[j, axis]

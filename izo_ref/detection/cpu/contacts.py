"""Pairs of two trees whose boxes meet, and those that meet themselves."""

from numba import prange

from izo_ref.base.compile import cpu_kernel, light_kernel
from izo_ref.detection.serial.contacts import (
    contacts_of_pairs,
    crossings_of_pairs,
    pair_key,
    pair_nodes,
)
from izo_ref.detection.serial.tree import ALL_LANES, WIDTH, pairs_of_block

# Queries, or pairs, that a thread takes at a time.
CHUNK = 256
BLOCKS = CHUNK // WIDTH


@cpu_kernel
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
    for k in prange(chunks.shape[0]):
        first = BLOCKS * chunks[k]
        last = min(first + BLOCKS, (queries.nodes.shape[0] + WIDTH - 1) // WIDTH)
        count = 0
        for block in range(first, last):
            at = starts[k] + count
            count += pairs_of_block(
                block, ALL_LANES, queries, leaves, against_itself, at, starts[k + 1], pairs_out
            )
        counts_out[k] = count


@cpu_kernel
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
    for k in prange(chunks.shape[0]):
        c = chunks[k]
        tallies_out[c, 0], tallies_out[c, 1], tallies_out[c, 2] = contacts_of_pairs(
            CHUNK * c,
            min(CHUNK * (c + 1), pairs.shape[0]),
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


@light_kernel
def gather_contact_nodes(
    # In:
    pairs,  # (n_pairs, 2) i4, places
    first_order,  # (n_queries,) i4
    first_nodes,  # (n_queries, k) i4, of vertices or edges
    second_order,  # (n_leaves,) i4
    second_nodes,  # (n_leaves, l) i4, of faces or edges
    # Out:
    keys_out,  # (n_pairs,) i8, by elements
    nodes_out,  # (n_pairs, 4) i4, vertex then face, or edge then edge
):
    for i in prange(pairs.shape[0]):
        a, b = pairs[i, 0], pairs[i, 1]
        keys_out[i] = pair_key(a, b, first_order, first_nodes, second_order)
        nodes = pair_nodes(a, b, first_order, first_nodes, second_order, second_nodes)
        for k in range(4):
            nodes_out[i, k] = nodes[k]


@cpu_kernel
def find_crossings(
    # In:
    pairs,  # (n_pairs, 2) i4, places of edges and faces
    edges,  # (n_edges, 2) i4
    faces,  # (n_faces, 3) i4
    positions,  # (n_vertices, 3) f8  [m]
    # Out:
    statuses_out,  # (n_pairs,) i1, of detection/formulas/advance.py
):
    for chunk in prange((pairs.shape[0] + CHUNK - 1) // CHUNK):
        first = CHUNK * chunk
        last = min(first + CHUNK, pairs.shape[0])
        crossings_of_pairs(first, last, pairs, edges, faces, positions, statuses_out)

"""Find the pairs of two trees whose boxes meet, and the contacts among them."""

from izo_ref.base.arrays import Codes, Floats, Indices, Ints, Offsets, Positions, Times
from izo_ref.base.compile import cpu_kernel
from izo_ref.detection.serial.contacts import contacts_of_pairs, crossings_of_pairs
from izo_ref.detection.serial.tree import WIDTH, Tree, pairs_of_block

# Number of queries, or of pairs, that a thread takes at a time.
CHUNK = 256
BLOCKS = CHUNK // WIDTH
# Chunks that are worth sharing among threads: each takes 20 to 60 us, and a launch 20 to 30. With
# all launches shared, a step of 400 triangles takes 9 ms on two threads, and 6 on one.
FEW_CHUNKS = 12


@cpu_kernel
def find_pairs(
    # Share:
    begin: int,  # i8, the first chunk of this share
    end: int,  # i8, behind the last one
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
    for k in range(begin, end):
        first = BLOCKS * chunks[k]
        last = min(first + BLOCKS, (queries.nodes.shape[0] + WIDTH - 1) // WIDTH)
        count = 0
        for block in range(first, last):
            at = starts[k] + count
            count += pairs_of_block(
                block, queries, leaves, against_itself, at, starts[k + 1], pairs_out
            )
        counts_out[k] = count


@cpu_kernel
def find_contacts(
    # Share:
    begin: int,  # i8, the first chunk of this share
    end: int,  # i8, behind the last one
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
    for k in range(begin, end):
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
            index_out,
            toi_out,
            directions_out,
            margins_out,
        )


@cpu_kernel
def find_crossings(
    # Share:
    begin: int,  # i8, the first chunk of pairs of this share
    end: int,  # i8, behind the last one
    # In:
    pairs: Ints,  # (n_pairs, 2) i4, places of edges and faces
    edges: Ints,  # (n_edges, 2) i4
    faces: Ints,  # (n_faces, 3) i4
    positions: Positions,  # (n_vertices, 3) f8  [m]
    # Out:
    statuses_out: Codes,  # (n_pairs,) i1, statuses of detection/formulas/advance.py
) -> None:
    """Decide whether edges cross faces at rest, where floats can tell."""
    for chunk in range(begin, end):
        first = CHUNK * chunk
        last = min(first + CHUNK, pairs.shape[0])
        crossings_of_pairs(first, last, pairs, edges, faces, positions, statuses_out)

"""Pairs of two trees that meet, each thread with some groups of queries at a time."""

from numba import prange

from izo_ref._jit import cpu_kernel
from izo_ref.serial.contacts import contacts_of_groups, crossings_of_groups
from izo_ref.serial.tree import GROUP

# Groups a thread takes at a time.
CHUNK = 64


@cpu_kernel
def find_contacts(
    # In:
    chunks,  # (n,) i8, which groups: chunk c has CHUNK of them, from CHUNK * c on
    starts,  # (n + 1,) i8, where each chunk writes, and how much room it has
    queries,  # Tree, of vertices or edges
    leaves,  # Tree, of faces or edges
    against_itself,  # b1, they are the same
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    # Out:
    counts_out,  # (n,) i8, contacts of each chunk, also those without room
    tallies_out,  # (n, 3) i8, candidates, proofs, the most proofs for one
    pairs_out,  # (starts[n], 2) i4, places of the elements of each contact
    nodes_out,  # (starts[n], 4) i4, its vertices
    toi_out,  # (starts[n],) f8
    directions_out,  # (starts[n], 3) f8
):
    groups = (queries.boxes.shape[0] + GROUP - 1) // GROUP
    for k in prange(chunks.shape[0]):
        first = CHUNK * chunks[k]
        counts_out[k], tallies_out[k, 0], tallies_out[k, 1], tallies_out[k, 2] = contacts_of_groups(
            first,
            min(first + CHUNK, groups),
            queries,
            leaves,
            against_itself,
            positions_t0,
            positions_t1,
            starts[k],
            starts[k + 1],
            pairs_out,
            nodes_out,
            toi_out,
            directions_out,
        )


@cpu_kernel
def find_crossings(
    # In:
    chunks,  # as of find_contacts, like all below
    starts,  # (n + 1,) i8
    queries,  # Tree, of edges
    leaves,  # Tree, of faces
    positions,  # (n_vertices, 3) f8  [m]
    # Out:
    counts_out,  # (n,) i8
    tallies_out,  # (n, 3) i8, candidates, 0, 0
    pairs_out,  # (starts[n], 2) i4, places of edges and faces not proved apart
    statuses_out,  # (starts[n],) i1, of scalar/advance.py
):
    groups = (queries.boxes.shape[0] + GROUP - 1) // GROUP
    for k in prange(chunks.shape[0]):
        first = CHUNK * chunks[k]
        counts_out[k], tallies_out[k, 0] = crossings_of_groups(
            first,
            min(first + CHUNK, groups),
            queries,
            leaves,
            positions,
            starts[k],
            starts[k + 1],
            pairs_out,
            statuses_out,
        )

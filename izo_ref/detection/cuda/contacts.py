"""List the contacts among candidate pairs, and their impacts."""

from numba import cuda

from izo_ref.base.arrays import AnyFloats, Flags, Floats, Indices, Ints, Positions, Times
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.base.records import Impacts
from izo_ref.base.serial.thread_group import group_maxima, group_sum
from izo_ref.detection.serial.found_counts import MOST_STEPS, STEPS
from izo_ref.detection.serial.group_contacts import (
    append_contacts,
    append_open_pairs,
    count_open_crossings,
    sort_impacts,
)
from izo_ref.detection.serial.records import ContactList, PathArrays, SortSpace
from izo_ref.detection.serial.tree import Tree


@cuda_kernel
def list_open_pairs(
    # In:
    vertex_boxes: AnyFloats,  # (n_vertices, 9) f4, start, end, end; without unit
    vertices: Tree,  # Tree
    edges: Tree,  # Tree
    faces: Tree,  # Tree
    pairs: Ints,  # (n, 2) i4, of `list_pairs`
    # Out:
    counts_out: Indices,  # (n_counts,) i8, the count of open pairs is added to
    open_out: Ints,  # (n, 2) i4, pairs, in any order
) -> None:
    """List the pairs that float32 does not prove apart."""
    append_open_pairs(grid(None), vertex_boxes, vertices, edges, faces, pairs, counts_out, open_out)


@cuda_kernel
def list_contacts(
    # In:
    path: PathArrays,  # PathArrays
    vertices: Tree,  # Tree
    edges: Tree,  # Tree
    faces: Tree,  # Tree
    pairs: Ints,  # (n, 2) i4, of `list_open_pairs`
    excluded: Indices,  # (m,) i8, keys of the pairs to ignore, ascending
    # Out:
    counts_out: Indices,  # (n_counts,) i8, the counts of contacts and proofs are added to
    contacts_out: ContactList,  # ContactList, in any order; the frames are not written
) -> None:
    """List the pairs that are not proved apart, as far as there is room."""
    # the threads of all blocks append to the list, and never wait for each other
    steps, most = append_contacts(
        grid(None), path, vertices, edges, faces, pairs, excluded, counts_out, contacts_out
    )
    total = group_sum(block(), float(steps))
    highest, _ = group_maxima(block(), float(most), 0.0)
    if cuda.threadIdx.x == 0:
        cuda.atomic.add(counts_out, STEPS, int(total))
        cuda.atomic.max(counts_out, MOST_STEPS, int(highest))


@cuda_kernel
def list_impacts(
    # In:
    path: PathArrays,  # PathArrays
    n_room: int,  # i8, number of pairs for which there was room
    pinned: Flags,  # (n_vertices,) b1
    to_solve: bool,  # b1, leave out the impacts between pinned points
    # Out:
    contacts_out: ContactList,  # ContactList, of `list_contacts`; the frames are written
    sort_out: SortSpace,  # SortSpace
    least_toi_out: Times,  # (1,) f8, the memory of counts_out[LEAST_TOI]
    counts_out: Indices,  # (n_counts,) i8, the counts of impacts are written
    found_out: Impacts,  # Impacts
    parts_out: Floats,  # (n_blocks, 7) f8, zeros at first, work space
) -> None:
    """Compute the frames of the contacts, and list them as impacts, sorted by their elements."""
    sort_impacts(
        grid(parts_out),
        path,
        n_room,
        pinned,
        to_solve,
        contacts_out,
        sort_out,
        least_toi_out,
        counts_out,
        found_out,
    )


@cuda_kernel
def count_crossings(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    edges: Tree,  # Tree
    faces: Tree,  # Tree
    pairs: Ints,  # (n, 2) i4, of `list_edge_faces`
    # Out:
    counts_out: Indices,  # (n_counts,) i8, the count of open pairs is added to
) -> None:
    """Count the edges and faces that are not certainly apart at rest."""
    count_open_crossings(grid(None), positions, edges, faces, pairs, counts_out)

"""What moves on a path, and which contacts that leaves."""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.serial.search import is_among
from izo_ref.detection.cuda.tree import differs


@cuda_kernel
def flag_moved_vertices(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    # Out:
    moved_out,  # (n_vertices,) b1, the two differ
):
    i = cuda.grid(1)
    if i < moved_out.shape[0]:
        moved_out[i] = differs(positions_t0, positions_t1, i)


@cuda_kernel
def flag_kept_contacts(
    # In:
    keys,  # (n,) i8, by kind and elements
    nodes,  # (n, 4) i4
    moved,  # (n_vertices,) b1, of others nothing is looked at
    excluded,  # (m,) i8, keys that are left out, ascending
    # Out:
    kept_out,  # (n,) b1
):
    i = cuda.grid(1)
    if i < keys.shape[0]:
        moves = moved[nodes[i, 0]] or moved[nodes[i, 1]] or moved[nodes[i, 2]]
        moves = moves or moved[nodes[i, 3]]
        kept_out[i] = moves and not is_among(keys[i], excluded)


@cuda_kernel
def flag_contacts(
    # In:
    tallies,  # (n, 3) i8, of find_contacts
    # Out:
    touching_out,  # (n,) b1, the pair counts as a contact
):
    i = cuda.grid(1)
    if i < tallies.shape[0]:
        touching_out[i] = tallies[i, 0] > 0

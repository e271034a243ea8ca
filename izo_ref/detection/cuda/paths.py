"""Flag the vertices that move on a path, and the contacts that count."""

# The types of numba-cuda say that `cuda.grid` takes other arguments than it does.
# pyright: reportCallIssue=false

from numba import cuda

from izo_ref.base.arrays import Flags, Indices, Nodes, Positions
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.serial.search import is_among
from izo_ref.detection.cuda.tree import differs


@cuda_kernel
def flag_moved_vertices(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    # Out:
    moved_out: Flags,  # (n_vertices,) b1, the two positions differ
) -> None:
    """Flag the vertices that move."""
    i = cuda.grid(1)
    if i < moved_out.shape[0]:
        moved_out[i] = differs(positions_t0, positions_t1, i)


@cuda_kernel
def flag_kept_contacts(
    # In:
    keys: Indices,  # (n,) i8, by kind and elements
    nodes: Nodes,  # (n, 4) i4
    moved: Flags,  # (n_vertices,) b1
    excluded: Indices,  # (m,) i8, keys of the pairs to ignore, ascending
    # Out:
    kept_out: Flags,  # (n,) b1, has a moved vertex and is not excluded
) -> None:
    """Flag the contacts that are impacts."""
    i = cuda.grid(1)
    if i < keys.shape[0]:
        moves = moved[nodes[i, 0]] or moved[nodes[i, 1]] or moved[nodes[i, 2]]
        moves = moves or moved[nodes[i, 3]]
        kept_out[i] = moves and not is_among(keys[i], excluded)


@cuda_kernel
def flag_contacts(
    # In:
    tallies: Indices,  # (n, 3) i8, of find_contacts
    # Out:
    touching_out: Flags,  # (n,) b1, the pair counts as a contact
) -> None:
    """Flag the pairs that `find_contacts` did not prove apart."""
    i = cuda.grid(1)
    if i < tallies.shape[0]:
        touching_out[i] = tallies[i, 0] > 0

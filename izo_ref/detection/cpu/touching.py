"""Decide what becomes of the pairs that touch at t = 0, as far as floats can tell."""

from izo_ref.base.arrays import Codes, Flags, Nodes, Positions
from izo_ref.base.compile import light_kernel
from izo_ref.detection.formulas.touching import is_apart_after_start, volume_sign_after_start
from izo_ref.detection.serial.contacts import relative_nodes, row4


@light_kernel
def find_pairs_apart(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n, 4) i4, pairs that touch at t = 0
    # Out:
    apart_out: Flags,  # (n,) b1, the pair is certainly apart after t = 0
) -> None:
    """Mark the pairs that are certainly apart after t = 0."""
    for i in range(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, row4(nodes, i))
        b1, b2, b3 = relative_nodes(positions_t1, row4(nodes, i))
        apart_out[i] = is_apart_after_start(a1, a2, a3, b1, b2, b3)


@light_kernel
def compute_volume_signs(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n, 4) i4
    signs_t0: Codes,  # (n,) i1, exact signs of the volumes at t = 0
    # Out:
    signs_out: Codes,  # (n,) i1, their signs right after t = 0, or UNKNOWN
) -> None:
    """Compute the sign of the volume of four nodes right after t = 0."""
    for i in range(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, row4(nodes, i))
        b1, b2, b3 = relative_nodes(positions_t1, row4(nodes, i))
        signs_out[i] = volume_sign_after_start(signs_t0[i], a1, a2, a3, b1, b2, b3)

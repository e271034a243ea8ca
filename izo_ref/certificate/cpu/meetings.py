"""Decide which pairs certainly meet."""

from izo_ref.base.arrays import Flags, Nodes, Positions, Times
from izo_ref.base.compile import light_kernel
from izo_ref.certificate.formulas.meeting import certainly_meets
from izo_ref.detection.serial.contacts import relative_nodes, row4


@light_kernel
def decide_meetings(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n_pairs, 4) i4
    is_edge_edge: Flags,  # (n_pairs,) b1
    toi: Times,  # (n_pairs,) f8, time until which the pair is proved apart
    # Out:
    meets_out: Flags,  # (n_pairs,) b1, True if the pair meets, False if that is not certain
) -> None:
    """Decide which pairs certainly meet, near their time of impact."""
    for i in range(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, row4(nodes, i))
        b1, b2, b3 = relative_nodes(positions_t1, row4(nodes, i))
        meets_out[i] = certainly_meets(is_edge_edge[i], a1, a2, a3, b1, b2, b3, toi[i])

"""Compute the frames of impacts: their weights and normals."""

from izo_ref.base.arrays import Flags, Nodes, Normals, Positions, Times, Weights
from izo_ref.base.compile import light_kernel
from izo_ref.detection.formulas.frame import closest_frame, impact_frame
from izo_ref.detection.serial.contacts import relative_nodes, row3, row4
from izo_ref.detection.serial.tight import is_tight


@light_kernel
def compute_impact_frames(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    is_edge_edge: Flags,  # (n_impacts,) b1
    toi: Times,  # (n_impacts,) f8
    directions: Normals,  # (n_impacts, 3) f8, the last ones that separated the sides
    # Out:
    weights_out: Weights,  # (n_impacts, 4) f8
    normals_out: Normals,  # (n_impacts, 3) f8
) -> None:
    """Compute the frame of each impact at its time of impact."""
    for i in range(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, row4(nodes, i))
        b1, b2, b3 = relative_nodes(positions_t1, row4(nodes, i))
        weights, normal = impact_frame(
            is_edge_edge[i], a1, a2, a3, b1, b2, b3, toi[i], row3(directions, i)
        )
        for k in range(4):
            weights_out[i, k] = weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]


@light_kernel
def renew_tight_frames(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    is_edge_edge: Flags,  # (n_impacts,) b1
    thickness: float,  # f8  [m]
    # Out:
    weights_out: Weights,  # (n_impacts, 4) f8, those of other impacts stay
    normals_out: Normals,  # (n_impacts, 3) f8, those of other impacts stay
) -> None:
    """Give each tight impact the frame at its closest points."""
    for i in range(nodes.shape[0]):
        if is_tight(i, positions, nodes, weights_out, normals_out, thickness):
            q1, q2, q3 = relative_nodes(positions, row4(nodes, i))
            weights, normal = closest_frame(is_edge_edge[i], q1, q2, q3)
            for k in range(4):
                weights_out[i, k] = weights[k]
            for axis in range(3):
                normals_out[i, axis] = normal[axis]

"""Contacts at t = 0 of pairs that start apart: floats cannot tell, so exact arithmetic decides.

The start is known to be free, so such a pair starts closer to itself than rounding can tell beside
its size and its motion. A sheet that lies 1e-15 m above a table is an example, and so are the
neighbours of a vertex that is thrown 1e11 m away.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Nodes, Normals, Positions, Times
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.exact_closest import exact_normal
from izo_ref.base.exact_path import first_meeting


def settle_doubts(
    positions_t0: Positions,
    positions_t1: Positions,
    nodes: Nodes,
    is_edge_edge: Flags,
    toi: Times,
    directions: Normals,
    deadline: Deadline = UNLIMITED,
) -> Flags:
    """Decide the contacts at t = 0 exactly.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start of the path.
        positions_t1: (n_vertices, 3) f8 [m], its end.
        nodes: (n, 4) i4, pairs that are apart at the start, or touch there.
        is_edge_edge: (n,) b1.
        toi: (n,) f8, time until which each pair is proved apart; where it is 0, it becomes the
            exact time of the first meeting, rounded down.
        directions: (n, 3) f8; where `toi` was 0, it becomes the exact unit vector between the
            closest points at the start, unless the pair touches there.
        deadline: When the decisions have to end; each takes a millisecond.

    Returns:
        (n,) b1, False for pairs that never meet.
    """
    meets = np.ones(len(toi), bool)
    for i in deadline.checked(np.flatnonzero(toi == 0.0)):
        start, end, kind = positions_t0[nodes[i]], positions_t1[nodes[i]], bool(is_edge_edge[i])
        time = first_meeting(kind, start, end)
        if time is None:
            meets[i] = False
            continue
        normal = exact_normal(kind, start)
        if normal is not None:
            toi[i], directions[i] = time, normal
    return meets

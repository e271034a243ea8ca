"""Keys by which pairs are recognised."""

import numpy as np

from izo_ref.base.records import ExcludedPairs, Impacts, Pairs, TouchingPairs


def pair_keys(pairs: Pairs | ExcludedPairs | TouchingPairs | Impacts) -> list[bytes]:
    """Return a key for each pair, which does not depend on the order in which it is written.

    The corners of the face, the ends of an edge and two edges may come in any order.
    """
    nodes = pairs.nodes.astype(np.int32, copy=True)
    ee = pairs.is_edge_edge
    nodes[~ee, 1:] = np.sort(nodes[~ee, 1:], axis=1)
    a, b = np.sort(nodes[ee, :2], axis=1), np.sort(nodes[ee, 2:], axis=1)
    swap = (a[:, 0] > b[:, 0]) | ((a[:, 0] == b[:, 0]) & (a[:, 1] > b[:, 1]))
    nodes[ee] = np.where(swap[:, None], np.hstack((b, a)), np.hstack((a, b)))
    return [row.tobytes() for row in np.column_stack((ee.astype(np.int32), nodes))]

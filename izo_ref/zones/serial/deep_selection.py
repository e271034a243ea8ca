"""Select the impacts that enter deep zones, where impacts are far deeper than edges are long.

A vertex that no impact holds goes on to its proposed position. If its neighbours are held, the
edges between them become as long as impacts are deep. That is harmless while impacts are as deep as
an edge is long. If they are a hundred times as deep, what these stretched triangles meet, and with
which normals, says nothing about the contact of the surfaces. So in a deep zone

* each vertex of a surface that arrives has to be held at once: an impact counts for the vertex of
  the largest weight on each of its two sides, its *main vertices*, and not for all four;
* an impact is left for later if one of its main vertices meets something else much earlier, because
  that will deflect it: the surfaces that are met later wait for their turn;
* impacts of vertices with faces come first, because they hold surfaces with the fewest impacts.

Whether a zone is deep is decided when one of its vertices meets something for the first time, and
holds for these vertices from then on. The zones are those of all impacts found, so a contact
elsewhere in the scene changes nothing.

Source: docs/method section 6.
"""

import math

from izo_ref.base.arrays import Flags, Floats, Indices, Ints, Nodes, Normals, Positions, Weights
from izo_ref.base.compile import compiled

# A zone is deep if the impacts found are deeper than this many edges on average. In the steps on
# which this was developed the mean is 0.7 at most. It is 3.7 for a sheet whose vertices are thrown
# at random by 20 edges; there, the selection of deep zones ends at an objective 3 % higher. It is
# 400 for a sheet that falls by 500 edges through nine others.
DEEP_EDGES = 8.0
UNDECIDED, SHALLOW, DEEP = 0, 1, 2  # what is known of a vertex; a deep zone makes others deep
# An impact may be later than the first one of its main vertices by this factor. Sheets of one stack
# are met at times 1, 2, 3 ... , and the vertices of an uneven sheet at times that differ less.
SOON = 1.5


@compiled
def relative_depth(
    j: int,
    positions_t0: Positions,
    positions: Positions,
    nodes: Nodes,
    is_edge_edge: Flags,
    weights: Weights,
    normals: Normals,
) -> float:
    """Return how deep impact j ends, over the longest edge of its elements at the start.

    Args:
        j: Index of the impact.
        positions_t0: (n_vertices, 3) f8 [m], start of the path.
        positions: (n_vertices, 3) f8 [m], end of the path.
        nodes: (n_impacts, 4) i4.
        is_edge_edge: (n_impacts,) b1.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
    """
    gap, longest_sq = 0.0, 0.0
    for axis in range(3):
        between = 0.0
        for k in range(4):
            # relative to the first node, which changes nothing: the weights sum to zero
            arm = positions[nodes[j, k], axis] - positions[nodes[j, 0], axis]
            between += weights[j, k] * arm
        gap += normals[j, axis] * between
    for k in range(3):
        if is_edge_edge[j] and k == 1:
            continue  # nodes 1 and 2 belong to different edges
        a = nodes[j, k] if is_edge_edge[j] else nodes[j, k + 1]
        b = nodes[j, k + 1] if is_edge_edge[j] else nodes[j, (k + 1) % 3 + 1]
        length_sq = 0.0
        for axis in range(3):
            length_sq += (positions_t0[b, axis] - positions_t0[a, axis]) ** 2
        longest_sq = max(longest_sq, length_sq)
    return -gap / math.sqrt(longest_sq) if longest_sq > 0.0 else 0.0


@compiled
def relative_depths(
    positions_t0: Positions,  # (n_vertices, 3) f8 [m]
    positions: Positions,  # (n_vertices, 3) f8 [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    is_edge_edge: Flags,  # (n_impacts,) b1
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    depths_out: Floats,  # (n_impacts,) f8, in longest edges
) -> None:
    """Compute `relative_depth` of all impacts."""
    for j in range(nodes.shape[0]):
        depths_out[j] = relative_depth(
            j, positions_t0, positions, nodes, is_edge_edge, weights, normals
        )


@compiled
def depth_of_zone(
    begin: int,
    end: int,
    impacts: Indices,
    depths: Floats,
    nodes: Nodes,
    pinned: Flags,
    known: Ints,
) -> int:
    """Return whether the zone of impacts[begin..end] is SHALLOW or DEEP.

    Args:
        begin: Where the impacts of the zone begin.
        end: Where they end.
        impacts: (n,) i8, the impacts, zone by zone.
        depths: (n_impacts,) f8, in longest edges.
        nodes: (n_impacts, 4) i4.
        pinned: (n_vertices,) b1.
        known: (n_vertices,) i4, what is known of each vertex.
    """
    most, total = UNDECIDED, 0.0
    for i in range(begin, end):
        j = impacts[i]
        total += depths[j]
        for k in range(4):
            if not pinned[nodes[j, k]]:
                most = max(most, int(known[nodes[j, k]]))
    if most != UNDECIDED:
        return most
    return DEEP if total > DEEP_EDGES * (end - begin) else SHALLOW


@compiled
def decide_depth(
    zone: int,
    impacts: Indices,  # (n,) i8, zone by zone
    impact_offsets: Indices,  # (n_zones + 1,) i8
    depths: Floats,  # (n_impacts,) f8, in longest edges
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    known_out: Ints,  # (n_vertices,) i4, of the vertices of impacts; read, too
    deep_out: Flags,  # (n_impacts,) b1; of the impacts of zones
) -> None:
    """Decide whether a zone is deep, and mark its impacts and its vertices."""
    begin, end = impact_offsets[zone], impact_offsets[zone + 1]
    depth = depth_of_zone(begin, end, impacts, depths, nodes, pinned, known_out)
    for i in range(begin, end):
        deep_out[impacts[i]] = depth == DEEP
        for k in range(4):
            if not pinned[nodes[impacts[i], k]]:
                known_out[nodes[impacts[i], k]] = depth


@compiled
def decide_depths(
    impacts: Indices,
    impact_offsets: Indices,
    depths: Floats,
    nodes: Nodes,
    pinned: Flags,
    known_out: Ints,
    deep_out: Flags,
) -> None:
    """Call `decide_depth` for each zone."""
    own = impacts, impact_offsets, depths, nodes, pinned, known_out, deep_out
    for zone in range(impact_offsets.shape[0] - 1):
        decide_depth(zone, *own)


@compiled
def main_vertices(j: int, nodes: Nodes, weights: Weights, pinned: Flags) -> tuple[int, int]:
    """Return the unpinned vertex of the largest weight on each side of impact j.

    If one side has no unpinned vertex of a weight, the vertex of the other side is returned twice.
    """
    first, second, largest, least = -1, -1, 0.0, 0.0
    for k in range(4):
        if pinned[nodes[j, k]]:
            continue
        if weights[j, k] > largest:
            first, largest = nodes[j, k], weights[j, k]
        elif weights[j, k] < least:
            second, least = nodes[j, k], weights[j, k]
    if first < 0:
        return second, second
    return first, (second if second >= 0 else first)


@compiled
def is_early(j: int, toi: Floats, mains: Nodes, first_times: Floats) -> bool:
    """Return whether impact j is not much later than the first one at its main vertices.

    Args:
        j: Index of the impact.
        toi: (n_impacts,) f8, times of impact.
        mains: (n_impacts, 4) i4, the first main vertex twice, then the second one twice.
        first_times: (n_vertices,) f8, the first time at which each vertex is a main vertex.
    """
    return toi[j] <= SOON * min(first_times[mains[j, 0]], first_times[mains[j, 2]])


@compiled
def early_impacts(
    toi: Floats,  # (n_impacts,) f8
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    pinned: Flags,  # (n_vertices,) b1
    first_times: Floats,  # (n_vertices,) f8, work space, all infinite
    mains_out: Nodes,  # (n_impacts, 4) i4, each of the two main vertices twice
    early_out: Flags,  # (n_impacts,) b1
) -> None:
    """Find the main vertices of each impact, and mark the impacts that need not wait."""
    for j in range(nodes.shape[0]):
        first, second = main_vertices(j, nodes, weights, pinned)
        mains_out[j, 0], mains_out[j, 1] = first, first
        mains_out[j, 2], mains_out[j, 3] = second, second
        first_times[first] = min(first_times[first], toi[j])
        first_times[second] = min(first_times[second], toi[j])
    for j in range(nodes.shape[0]):
        early_out[j] = is_early(j, toi, mains_out, first_times)

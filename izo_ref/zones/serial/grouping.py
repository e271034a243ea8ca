"""Group impacts into zones: give each impact and each vertex the number of its zone, and sort."""

import numpy as np

from izo_ref.base.arrays import Flags, Indices, Nodes, Offsets
from izo_ref.base.compile import compiled
from izo_ref.base.serial.components import find_root, impact_components


@compiled
def number_zones(
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    parent: Indices,  # (n_vertices,) i8, work space
    zone_of_impact_out: Indices,  # (n_impacts,) i8; -1 if all vertices are pinned
    zone_of_vertex_out: Indices,  # (n_vertices,) i8; -1 if pinned or without impact
) -> int:
    """Number the zones by their smallest vertex, and return how many there are."""
    impact_components(nodes, pinned, parent, zone_of_impact_out)
    for vertex in range(len(pinned)):
        zone_of_vertex_out[vertex] = -1
    for j in range(nodes.shape[0]):
        for k in range(4):
            if not pinned[nodes[j, k]]:
                zone_of_vertex_out[nodes[j, k]] = 0
    # the root of a zone is its smallest vertex, so it gets its number before the others
    n_zones = 0
    for vertex in range(len(pinned)):
        if zone_of_vertex_out[vertex] >= 0:
            root = find_root(parent, np.int64(vertex))
            if root == vertex:
                zone_of_vertex_out[vertex] = n_zones
                n_zones += 1
            else:
                zone_of_vertex_out[vertex] = zone_of_vertex_out[root]
    for j in range(nodes.shape[0]):
        if zone_of_impact_out[j] >= 0:
            zone_of_impact_out[j] = zone_of_vertex_out[zone_of_impact_out[j]]
    return n_zones


@compiled
def sort_by_zone(
    zone_of: Indices,  # (n,) i8, the zone of each thing; -1 if it is in none
    offsets_out: Offsets,  # (n_zones + 1,) i8, where the things of each zone begin, and the end
    sorted_out: Indices,  # (n,) i8, the things, zone by zone, ascending in each; the rest is free
) -> None:
    """Sort things by their zone, by counting."""
    n_zones = len(offsets_out) - 1
    for zone in range(n_zones + 1):
        offsets_out[zone] = 0
    for i in range(len(zone_of)):
        if zone_of[i] >= 0:
            offsets_out[zone_of[i] + 1] += 1
    for zone in range(n_zones):
        offsets_out[zone + 1] += offsets_out[zone]
    # each entry is moved on to its end, which is where the next zone begins
    for i in range(len(zone_of)):
        if zone_of[i] >= 0:
            sorted_out[offsets_out[zone_of[i]]] = i
            offsets_out[zone_of[i]] += 1
    for zone in range(n_zones, 0, -1):
        offsets_out[zone] = offsets_out[zone - 1]
    offsets_out[0] = 0

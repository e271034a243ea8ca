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
def sort_by_zone(zone_of: Indices, n_zones: int) -> tuple[Indices, Offsets]:
    """Sort things by their zone, by counting.

    Args:
        zone_of: (n,) i8, the zone of each thing; -1 if it is in none.
        n_zones: Number of zones.

    Returns:
        The things, zone by zone, ascending in each; and (n_zones + 1,) i8, where the things of each
        zone begin, and the end.
    """
    offsets = np.zeros(n_zones + 1, np.int64)
    for i in range(len(zone_of)):
        if zone_of[i] >= 0:
            offsets[zone_of[i] + 1] += 1
    for zone in range(n_zones):
        offsets[zone + 1] += offsets[zone]
    things = np.empty(offsets[n_zones], np.int64)
    # each entry is moved on to its end, which is where the next zone begins
    for i in range(len(zone_of)):
        if zone_of[i] >= 0:
            things[offsets[zone_of[i]]] = i
            offsets[zone_of[i]] += 1
    for zone in range(n_zones, 0, -1):
        offsets[zone] = offsets[zone - 1]
    offsets[0] = 0
    return things, offsets


@compiled
def group_by_zone(nodes: Nodes, pinned: Flags) -> tuple[Indices, Offsets, Indices, Offsets]:
    """Return the impacts and the unpinned vertices of each zone, and where those of each begin.

    Args:
        nodes: (n_impacts, 4) i4.
        pinned: (n_vertices,) b1.
    """
    n_impacts, n_vertices = nodes.shape[0], pinned.shape[0]
    zone_of_impact, zone_of_vertex = np.empty(n_impacts, np.int64), np.empty(n_vertices, np.int64)
    parent = np.empty(n_vertices, np.int64)
    n_zones = number_zones(nodes, pinned, parent, zone_of_impact, zone_of_vertex)
    impacts, impact_offsets = sort_by_zone(zone_of_impact, n_zones)
    vertices, vertex_offsets = sort_by_zone(zone_of_vertex, n_zones)
    return impacts, impact_offsets, vertices, vertex_offsets


@compiled
def take_zones(things: Indices, offsets: Offsets, chosen: Indices) -> tuple[Indices, Offsets]:
    """Return the things of chosen zones, zone by zone, and where those of each begin.

    Args:
        things: (n,) i8, zone by zone.
        offsets: (n_zones + 1,) i8, where the things of each zone begin, and the end.
        chosen: (m,) i8, the zones.
    """
    own_offsets = np.zeros(chosen.shape[0] + 1, np.int64)
    for i in range(chosen.shape[0]):
        own_offsets[i + 1] = own_offsets[i] + offsets[chosen[i] + 1] - offsets[chosen[i]]
    own = np.empty(own_offsets[-1], np.int64)
    for i in range(chosen.shape[0]):
        for k in range(own_offsets[i + 1] - own_offsets[i]):
            own[own_offsets[i] + k] = things[offsets[chosen[i]] + k]
    return own, own_offsets


@compiled
def number_vertices(
    nodes: Nodes, impacts: Indices, vertices: Indices, pinned: Flags
) -> tuple[Indices, Nodes]:
    """Number the vertices of zones: the unpinned ones in their order, then the pinned ones.

    Args:
        nodes: (n_impacts, 4) i4, of all impacts.
        impacts: (n,) i8, the impacts of the zones.
        vertices: (k,) i8, the unpinned vertices of the zones.
        pinned: (n_vertices,) b1.

    Returns:
        (m,) i8, the vertex of each number; and (n, 4) i4, the numbers of the vertices of each
        impact.
    """
    number = np.empty(pinned.shape[0], np.int32)
    for i in range(vertices.shape[0]):
        number[vertices[i]] = i
    n_pinned = 0
    for j in impacts:
        for k in range(4):
            if pinned[nodes[j, k]]:
                number[nodes[j, k]] = -1
                n_pinned += 1
    numbered, n = np.empty(vertices.shape[0] + n_pinned, np.int64), vertices.shape[0]
    for i in range(n):
        numbered[i] = vertices[i]
    own = np.empty((impacts.shape[0], 4), np.int32)
    for i in range(impacts.shape[0]):
        for k in range(4):
            vertex = nodes[impacts[i], k]
            if number[vertex] < 0:
                number[vertex], numbered[n] = n, vertex
                n += 1
            own[i, k] = number[vertex]
    return numbered[:n], own

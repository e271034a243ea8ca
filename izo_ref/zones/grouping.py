"""Zones: impacts that share an unpinned vertex, in contiguous blocks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Indices, Offsets
from izo_ref.base.ranges import distinct
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.base.serial.components import impact_components


class Zones(NamedTuple):
    """Impact zones of a scene.

    Zone z owns the impacts `impacts[impact_offsets[z] : impact_offsets[z + 1]]`. Its unpinned
    vertices are `vertices[vertex_offsets[z] : vertex_offsets[z + 1]]`, and no other zone shares
    them.

    Attributes:
        impacts: (n_impacts,) i8, indices into the `Impacts`, zone by zone.
        impact_offsets: (n_zones + 1,) i8, where the impacts of each zone begin, and the end.
        vertices: (n_zone_vertices,) i8, unpinned vertices, zone by zone, ascending in each.
        vertex_offsets: (n_zones + 1,) i8, where the vertices of each zone begin, and the end.
    """

    impacts: Indices
    impact_offsets: Offsets
    vertices: Indices
    vertex_offsets: Offsets

    def __len__(self) -> int:
        """Return the number of zones (not of fields)."""
        return len(self.impact_offsets) - 1

    def impacts_of(self, zone: int) -> Indices:
        """Return the impacts of one zone.

        Args:
            zone: Number of the zone, from 0.

        Returns:
            (n,) i8, indices into the `Impacts` from which the zones were built, ascending.
        """
        return self.impacts[self.impact_offsets[zone] : self.impact_offsets[zone + 1]]

    def vertices_of(self, zone: int) -> Indices:
        """Return the unpinned vertices of one zone.

        Args:
            zone: Number of the zone, from 0.

        Returns:
            (n,) i8, vertices of the scene, ascending.
        """
        return self.vertices[self.vertex_offsets[zone] : self.vertex_offsets[zone + 1]]


def build_zones(scene: SceneArrays, impacts: Impacts) -> Zones:
    """Group impacts into zones.

    Two impacts belong to the same zone if they share an unpinned vertex, or if a chain of impacts
    that do so connects them. The number and the size of zones have no limit. Impacts that have
    pinned vertices only belong to no zone.

    Args:
        scene: The scene, for its pinned vertices.
        impacts: Impacts of the scene.

    Returns:
        The zones, sorted by their smallest unpinned vertex; the impacts of a zone keep the order
        in which they were given.

    Source: docs/method section 2.
    """
    component = np.empty(len(impacts.nodes), np.int64)
    parent = np.empty(len(scene.pinned), np.int64)
    impact_components(impacts.nodes, scene.pinned, parent, component)
    order = np.argsort(component, kind="stable")
    order = order[np.count_nonzero(component < 0) :]
    _, counts = np.unique(component[order], return_counts=True)
    offsets = np.concatenate(([0], np.cumsum(counts)))

    zone_of = np.repeat(np.arange(len(counts)), counts)
    nodes = impacts.nodes[order]
    # zone and vertex in one number, because sorting rows takes longer
    keys = np.repeat(zone_of, 4) << 32 | nodes.ravel()
    keys = distinct(keys[~scene.pinned[nodes.ravel()]])
    vertex_offsets = np.searchsorted(keys >> 32, np.arange(len(counts) + 1))
    return Zones(order, offsets, keys & 0xFFFFFFFF, vertex_offsets)

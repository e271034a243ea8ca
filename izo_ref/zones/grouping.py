"""Zones: impacts that share an unpinned vertex, in contiguous blocks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Indices, Offsets
from izo_ref.base.ranges import members
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.zones.serial.grouping import number_zones, sort_by_zone


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

    def part(self, chosen: Indices) -> Zones:
        """Return some of the zones, as zones of the same impacts.

        Args:
            chosen: (n,) i8, numbers of the zones, ascending.
        """
        if len(chosen) == len(self):
            return self
        impacts, impact_offsets = members(self.impacts, self.impact_offsets, chosen)
        vertices, vertex_offsets = members(self.vertices, self.vertex_offsets, chosen)
        return Zones(impacts, impact_offsets, vertices, vertex_offsets)


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
    zone_of_impact = np.empty(len(impacts.nodes), np.int64)
    zone_of_vertex, parent = np.empty((2, len(scene.pinned)), np.int64)
    n_zones = number_zones(impacts.nodes, scene.pinned, parent, zone_of_impact, zone_of_vertex)
    return Zones(*_sorted(zone_of_impact, n_zones), *_sorted(zone_of_vertex, n_zones))


def _sorted(zone_of: Indices, n_zones: int) -> tuple[Indices, Offsets]:
    """Return what is in each zone, zone by zone, and where that of each zone begins."""
    offsets, things = np.empty(n_zones + 1, np.int64), np.empty(len(zone_of), np.int64)
    sort_by_zone(zone_of, offsets, things)
    return things[: offsets[-1]].copy(), offsets

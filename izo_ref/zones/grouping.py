"""Zones: impacts that share an unpinned vertex, in contiguous blocks."""

from __future__ import annotations

from typing import NamedTuple

from izo_ref.base.arrays import Indices, Offsets
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.zones.serial.grouping import group_by_zone, take_zones


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
        return Zones(
            *take_zones(self.impacts, self.impact_offsets, chosen),
            *take_zones(self.vertices, self.vertex_offsets, chosen),
        )


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
    return Zones(*group_by_zone(impacts.nodes, scene.pinned))

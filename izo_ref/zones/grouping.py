"""Zones: impacts that share an unpinned vertex, in contiguous blocks."""

from typing import NamedTuple

import numpy as np

from izo_ref.base.ranges import distinct
from izo_ref.base.records import Impacts
from izo_ref.base.serial.components import impact_components


class Zones(NamedTuple):
    """Impact zones of a scene. Zone z owns the impacts
    impacts[impact_offsets[z] : impact_offsets[z + 1]], and no other zone shares its
    unpinned vertices, vertices[vertex_offsets[z] : vertex_offsets[z + 1]]."""

    impacts: np.ndarray  # (n_impacts,) i8, indices into the Impacts, zone by zone
    impact_offsets: np.ndarray  # (n_zones + 1,) i8
    vertices: np.ndarray  # (n_zone_vertices,) i8, unpinned, zone by zone, ascending in each
    vertex_offsets: np.ndarray  # (n_zones + 1,) i8

    def __len__(self):  # of zones, not of fields
        return len(self.impact_offsets) - 1

    def impacts_of(self, zone):
        return self.impacts[self.impact_offsets[zone] : self.impact_offsets[zone + 1]]

    def vertices_of(self, zone):
        return self.vertices[self.vertex_offsets[zone] : self.vertex_offsets[zone + 1]]


def build_zones(scene, impacts: Impacts) -> Zones:
    """Group impacts into zones.

    Two impacts belong to the same zone if they share an unpinned vertex, or a chain of
    impacts that do leads from one to the other. There is no limit on number or size.
    Impacts of pinned vertices only belong to no zone.

    Args:
        scene: `Scene`; `pinned` is used.
        impacts: `Impacts` of the scene.

    Returns:
        `Zones`, by their smallest vertex; impacts in the order given.

    Source: SPEC section 2.
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
    # zone and vertex in one number: rows take long to sort
    keys = np.repeat(zone_of, 4) << 32 | nodes.ravel()
    keys = distinct(keys[~scene.pinned[nodes.ravel()]])
    vertex_offsets = np.searchsorted(keys >> 32, np.arange(len(counts) + 1))
    return Zones(order, offsets, keys & 0xFFFFFFFF, vertex_offsets)

"""Zone problems: one on its own, and many side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Indices, Masses, Nodes, Normals, Offsets, Positions, Weights
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.zones.grouping import Zones
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.serial.grouping import number_vertices


def zone_problem(
    scene: SceneArrays, impacts: Impacts, zones: Zones, zone: int, thickness: float
) -> ZoneProblem:
    """Return the problem of one zone on its own; its pinned vertices have infinite masses.

    Args:
        scene: The scene, with the proposed positions, the masses and the pinned vertices.
        impacts: Impacts of the scene.
        zones: The zones of these impacts.
        zone: Number of the zone, from 0.
        thickness: Distance that impacts keep at the end [m].

    Returns:
        The problem. Its impacts are `zones.impacts_of(zone)`, and its vertices are all vertices
        of these impacts, ascending.
    """
    own = impacts.take(zones.impacts_of(zone))
    vertices, nodes = np.unique(own.nodes, return_inverse=True)
    masses = np.where(scene.pinned[vertices], np.inf, scene.masses[vertices])
    return ZoneProblem(
        nodes.reshape(-1, 4).astype(np.int32),
        own.weights,
        own.normals,
        scene.positions_t1[vertices],
        masses,
        thickness,
    )


class ZoneSystem(NamedTuple):
    """Zones side by side, ready for the kernels; vertices are local to the system."""

    impact_offsets: Offsets  # (n_zones + 1,) i8
    vertex_offsets: Offsets  # (n_zones + 1,) i8, unpinned vertices only
    nodes: Nodes  # (n_impacts, 4) i4, zone by zone
    weights: Weights  # (n_impacts, 4) f8
    normals: Normals  # (n_impacts, 3) f8
    proposed: Positions  # (n_vertices, 3) f8 [m], unpinned vertices zone by zone, then pinned ones
    masses: Masses  # (n_vertices,) f8 [kg], infinite for pinned vertices
    thickness: float  # [m]


def zone_system(scene: SceneArrays, impacts: Impacts, zones: Zones, thickness: float) -> ZoneSystem:
    """Return the problems of zones side by side.

    Args:
        scene: The scene, with the proposed positions, the masses and the pinned vertices.
        impacts: Impacts of the scene.
        zones: Some or all zones of these impacts.
        thickness: Distance that impacts keep at the end [m].

    Returns:
        The system; its impacts and unpinned vertices are those of the zones, in order.
    """
    own = zones.impacts
    vertices, nodes = number_vertices(impacts.nodes, own, zones.vertices, scene.pinned)
    return ZoneSystem(
        zones.impact_offsets,
        zones.vertex_offsets,
        nodes,
        impacts.weights.take(own, axis=0),
        impacts.normals.take(own, axis=0),
        scene.positions_t1.take(vertices, axis=0),
        np.where(scene.pinned[vertices], np.inf, scene.masses[vertices]),
        thickness,
    )


def problem_system(problems: Sequence[ZoneProblem]) -> tuple[ZoneSystem, Indices]:
    """Put problems that share no vertex side by side, as the zones of a step are.

    Args:
        problems: Problems of the same thickness, each with an impact and an unpinned vertex.

    Returns:
        The system, and (n,) i8, the place in the system of each vertex of the problems, one
        problem after the other.
    """
    sizes = np.array([len(problem.masses) for problem in problems])
    masses = np.concatenate([problem.masses for problem in problems])
    pinned = np.isinf(masses)
    order = np.argsort(pinned, kind="stable")
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order))
    firsts = np.cumsum(sizes) - sizes
    n_unpinned = np.add.reduceat(~pinned, firsts)
    n_impacts = [len(problem.nodes) for problem in problems]
    nodes = np.concatenate([p.nodes + first for p, first in zip(problems, firsts, strict=True)])
    system = ZoneSystem(
        np.concatenate(([0], np.cumsum(n_impacts))),
        np.concatenate(([0], np.cumsum(n_unpinned))),
        places[nodes].astype(np.int32),
        np.concatenate([problem.weights for problem in problems]),
        np.concatenate([problem.normals for problem in problems]),
        np.concatenate([problem.proposed for problem in problems])[order],
        masses[order],
        problems[0].thickness,
    )
    return system, places

"""Zone problems, one on its own and many side by side."""

from typing import NamedTuple

import numpy as np

from izo_ref.base.ranges import members
from izo_ref.base.records import Impacts
from izo_ref.zones.grouping import Zones
from izo_ref.zones.problem import ZoneProblem


def zone_problem(scene, impacts: Impacts, zones: Zones, zone: int, thickness: float) -> ZoneProblem:
    """The problem of one zone on its own; pinned vertices enter with infinite mass."""
    part = impacts.take(zones.impacts_of(zone))
    vertices, nodes = np.unique(part.nodes, return_inverse=True)
    masses = np.where(scene.pinned[vertices], np.inf, scene.masses[vertices])
    return ZoneProblem(
        nodes.reshape(-1, 4).astype(np.int32),
        part.weights,
        part.normals,
        scene.positions_t1[vertices],
        masses,
        thickness,
    )


class ZoneSystem(NamedTuple):
    """Zones side by side, ready for the kernels. Vertices are local to the system."""

    impact_offsets: np.ndarray  # (n_zones + 1,) i8
    vertex_offsets: np.ndarray  # (n_zones + 1,) i8, unpinned vertices only
    nodes: np.ndarray  # (n_impacts, 4) i4, zone by zone
    weights: np.ndarray  # (n_impacts, 4) f8
    normals: np.ndarray  # (n_impacts, 3) f8
    proposed: np.ndarray  # (n_vertices, 3) f8 [m], unpinned zone by zone, then pinned ones
    masses: np.ndarray  # (n_vertices,) f8 [kg], infinite for pinned
    thickness: float  # [m]


def zone_system(scene, impacts: Impacts, zones: Zones, chosen, thickness: float) -> ZoneSystem:
    """The problems of some zones side by side.

    Returns:
        `ZoneSystem`; its impacts and unpinned vertices are those of the zones, in order.
    """
    own_impacts, impact_offsets = members(zones.impacts, zones.impact_offsets, chosen)
    free, vertex_offsets = members(zones.vertices, zones.vertex_offsets, chosen)
    part = impacts.take(own_impacts)
    pinned = np.unique(part.nodes[scene.pinned[part.nodes]])
    vertices = np.concatenate((free, pinned))
    local = np.empty(len(scene.pinned), np.int32)
    local[vertices] = np.arange(len(vertices))
    return ZoneSystem(
        impact_offsets,
        vertex_offsets,
        local[part.nodes],
        part.weights,
        part.normals,
        scene.positions_t1[vertices],
        np.where(scene.pinned[vertices], np.inf, scene.masses[vertices]),
        thickness,
    )


def problem_system(problems) -> tuple[ZoneSystem, np.ndarray]:
    """Problems that share no vertex side by side, as the zones of a step are.

    Args:
        problems: `ZoneProblem`s of the same thickness, each with a vertex that is not pinned
            and an impact.

    Returns:
        `ZoneSystem`, and (n,) i8: where in the system each vertex of the problems is, one
        problem after the other.
    """
    sizes = np.array([len(problem.masses) for problem in problems])
    masses = np.concatenate([problem.masses for problem in problems])
    pinned = np.isinf(masses)
    order = np.argsort(pinned, kind="stable")
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order))
    firsts = np.cumsum(sizes) - sizes
    free = np.add.reduceat(~pinned, firsts)
    counts = [len(problem.nodes) for problem in problems]
    nodes = np.concatenate([p.nodes + first for p, first in zip(problems, firsts, strict=True)])
    system = ZoneSystem(
        np.concatenate(([0], np.cumsum(counts))),
        np.concatenate(([0], np.cumsum(free))),
        places[nodes].astype(np.int32),
        np.concatenate([problem.weights for problem in problems]),
        np.concatenate([problem.normals for problem in problems]),
        np.concatenate([problem.proposed for problem in problems])[order],
        masses[order],
        problems[0].thickness,
    )
    return system, places

"""Solve zones that the launches of a step left: the CPU states their problems."""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, GpuArray, Indices
from izo_ref.base.deadline import Deadline
from izo_ref.base.gpu_arrays import as_column, to_cpu, to_gpu
from izo_ref.base.gpu_impacts import impacts_to_cpu
from izo_ref.base.options import LAGRANGIAN, Options
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.loop.cuda import step as kernels
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.zone_buffers import StepState
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.grouping import Zones
from izo_ref.zones.serial.listed_zones import ListedZones
from izo_ref.zones.system import zone_system


def device_of_left(options: Options) -> str:
    """Return where the zones are solved that the launches of a step leave.

    The CPU solves them. But if the options name a method of the augmented Lagrangian or a preset,
    all zones are left, and a GPU runs that method.
    """
    return "cuda" if options.method in LAGRANGIAN or options.preset is not None else "cpu"


def zones_to_cpu(zones: ListedZones, counts: Any) -> Zones:
    """Return all zones on the CPU.

    Args:
        zones: The zones, on the GPU.
        counts: (>= N_COUNTS,) i8, what the launches of `ZoneStage` counted, on the CPU.
    """
    n_zones, m, n = (
        int(counts[k]) for k in (at.ZONES_NEEDED, at.IMPACTS_NEEDED, at.VERTICES_NEEDED)
    )
    return Zones(
        to_cpu(zones.impacts[:m]),
        to_cpu(zones.impact_offsets[: n_zones + 1]),
        to_cpu(zones.vertices[:n]),
        to_cpu(zones.vertex_offsets[: n_zones + 1]),
    )


def solve_left(
    zones: Zones,
    scene: SceneArrays,
    impacts: Impacts,
    thickness: float,
    options: Options,
    deadline: Deadline,
    state: StepState,
    stuck_out: GpuArray,
) -> None:
    """Solve zones, and write what comes out to the arrays of a step on a GPU.

    Args:
        zones: The zones, on the CPU.
        scene: The scene.
        impacts: All impacts of the step, on the GPU.
        thickness: [m].
        options: The method and the tolerances.
        deadline: When the solvers have to end.
        state: The step, on the GPU; entries of these zones are written.
        stuck_out: (n_vertices,) b1 on the GPU; the vertices of zones that are not solved get true.
    """
    own = impacts_to_cpu(impacts).take(zones.impacts)
    # not by `_make` or `_replace`: they ask for the number of fields, and `Zones` counts zones
    local = Zones(np.arange(len(own.toi)), *zones[1:])
    system = zone_system(scene, own, local, thickness)
    n = impacts.toi.shape[0]
    start, active = (to_cpu(column[:n])[zones.impacts] for column in state[1:])
    start[~active] = 0.0
    device = device_of_left(options)
    solution = solve_system(system, options, start=start, device=device, deadline=deadline)
    solved = np.repeat(solution.feasible, np.diff(zones.vertex_offsets))
    vertices = zones.vertices
    positions = solution.positions[: len(vertices)]
    _put(vertices[solved], positions[solved], state.positions)
    stuck = vertices[~solved]
    _put(stuck, np.ones((len(stuck), 1), bool), as_column(stuck_out))
    for values, values_out in (
        (solution.multipliers, state.multipliers),
        (solution.active, state.active),
    ):
        _put(zones.impacts, as_column(values), as_column(values_out))


def _put(index: Indices, rows: AnyArray, values_out: Any) -> None:
    """Write rows of an array of the CPU to the places of an index in an array of the GPU."""
    kernels.put_rows[len(index)](to_gpu(index), to_gpu(rows), values_out)

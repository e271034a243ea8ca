"""The zones of a step on a GPU: what launches solve, and what they leave to the CPU."""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, GpuArray, Indices
from izo_ref.base.deadline import Deadline
from izo_ref.base.gpu_arrays import put_rows, to_cpu, to_gpu
from izo_ref.base.gpu_launch import by_grid
from izo_ref.base.options import LAGRANGIAN, Options
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.loop.cuda import update as kernels
from izo_ref.solvers.gpu_solve import Launch, ZoneSolver
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.grouping import Zones
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones
from izo_ref.zones.system import zone_system


def launches_of_zones(
    solver: ZoneSolver, zones: ListedZones, step: StepArrays, left: GpuArray, counts: GpuArray
) -> list[Launch]:
    """Return the launches that solve the zones of the lists and update the step.

    Args:
        solver: If its buffers have too little room, no zone is solved and nothing is updated.
        zones: The zones, on the GPU.
        step: The step, on the GPU; entries of solved zones are written.
        left: (room for zones,) i8 on the GPU, zones that are left to the CPU, in any order.
        counts: (>= N_COUNTS,) i8 on the GPU, of `solvers/serial/zone_buffers.py`.
    """
    own = zones, solver.rows.lengths, solver.answers, solver.sizes, step, left
    update = by_grid(kernels.update_step, *own, counts, counts.view(np.float64))
    return [*solver.launches(zones, step, counts), update]


def launch_to_measure(solver: ZoneSolver, step: StepArrays, counts: GpuArray) -> Launch:
    """Return the launch that measures a step again, after the CPU has changed it."""
    return by_grid(kernels.measure_step, step, solver.sizes, counts, counts.view(np.float64))


def zones_left(zones: ListedZones, left: GpuArray, counts: Indices) -> Zones:
    """Return the zones that the launches left, on the CPU, in the order of all zones.

    Args:
        zones: The zones, on the GPU.
        left: (room for zones,) i8 on the GPU, of `launches_of_zones`.
        counts: (>= N_COUNTS,) i8, what the launches counted, on the CPU.
    """
    n_zones, m, n = (
        int(counts[k]) for k in (at.ZONES_NEEDED, at.IMPACTS_NEEDED, at.VERTICES_NEEDED)
    )
    every = Zones(
        to_cpu(zones.impacts[:m]),
        to_cpu(zones.impact_offsets[: n_zones + 1]),
        to_cpu(zones.vertices[:n]),
        to_cpu(zones.vertex_offsets[: n_zones + 1]),
    )
    return every.part(np.sort(to_cpu(left[: int(counts[at.LEFT])])))


def device_of_left(options: Options) -> str:
    """Return where the zones are solved that the launches of a step leave.

    The CPU solves them. But if the options name a method of the augmented Lagrangian or a preset,
    all zones are left, and a GPU runs that method.
    """
    return "cuda" if options.method in LAGRANGIAN or options.preset is not None else "cpu"


def solve_left(
    zones: Zones,
    scene: SceneArrays,
    impacts: Impacts,
    options: Options,
    deadline: Deadline,
    step: StepArrays,
) -> None:
    """Solve zones, and write what comes out to the arrays of a step on a GPU.

    Args:
        zones: The zones, on the CPU.
        scene: The scene.
        impacts: All impacts of the step, on the GPU.
        options: The method and the tolerances.
        deadline: When the solvers have to end.
        step: The step, on the GPU; entries of these zones are written, and the vertices of zones
            that are not solved become stuck.
    """
    own, n = to_cpu(impacts).take(zones.impacts), impacts.toi.shape[0]
    # not by `_make` or `_replace`: they ask for the number of fields, and `Zones` counts zones
    local = Zones(np.arange(len(own.toi)), *zones[1:])
    system = zone_system(scene, own, local, step.thickness)
    start, active = (to_cpu(a[:n])[zones.impacts] for a in (step.multipliers, step.active))
    start[~active] = 0.0
    device = device_of_left(options)
    solution = solve_system(system, options, start=start, device=device, deadline=deadline)
    vertices = zones.vertices
    solved = np.repeat(solution.feasible, np.diff(zones.vertex_offsets))
    _put(vertices[solved], solution.positions[: len(vertices)][solved], step.positions)
    _put(vertices[~solved], np.ones(np.count_nonzero(~solved), bool), step.stuck)
    _put(zones.impacts, solution.multipliers, step.multipliers)
    _put(zones.impacts, solution.active, step.active)


def _put(index: Indices, values: AnyArray, values_out: Any) -> None:
    """Write rows of an array of the CPU to the places of an index in an array of the GPU."""
    put_rows(to_gpu(index), to_gpu(values), values_out)

"""The augmented-Lagrangian methods on a system of zones: convert, launch, convert back.

`descend` runs them. The loop over the steps of one zone is in `solvers/serial/descent.py`.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from izo_ref.base.arrays import AnyArray, Multipliers
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.options import Options
from izo_ref.solvers.cpu import lagrangian as kernels
from izo_ref.solvers.presets import choose_settings, preset_of
from izo_ref.solvers.scaled_constraints import ScaledConstraints, SystemSolution
from izo_ref.solvers.serial.lagrangian import N_STATES
from izo_ref.solvers.serial.records import Inputs, Results, WorkSpace
from izo_ref.solvers.serial.settings import Settings
from izo_ref.solvers.variables import choose_variables, lay_out, make_inputs
from izo_ref.zones.system import ZoneSystem

# Runs the kernels on some inputs and writes the results.
SolveOn: TypeAlias = Callable[[Inputs, Settings, Results], Any]


def make_work_space(
    inputs: Inputs, n_memory: int, n_threads: int, zeros: Callable[..., AnyArray]
) -> WorkSpace:
    """Return the work space of the kernels.

    Args:
        inputs: The inputs of the kernels.
        n_memory: How many numbers the directions of all zones keep.
        n_threads: How many threads work on a zone.
        zeros: Makes an array of zeros from its shape and its dtype.
    """
    n, m, dtype = inputs.curvatures.shape[0], inputs.nodes.shape[0], inputs.curvatures.dtype
    return WorkSpace(
        zeros((4, n), dtype),
        zeros((3, m), dtype),
        zeros((n_memory,), dtype),
        zeros((inputs.zones.shape[0], n_threads, N_STATES), np.float64),
        zeros((1,), np.bool_),
    )


def run_on_cpu(
    inputs: Inputs, settings: Settings, results: Results, deadline: Deadline = UNLIMITED
) -> None:
    """Run the kernel of the CPU until the deadline: one thread a zone."""
    work = make_work_space(inputs, inputs.memory_offsets[-1], 1, np.zeros)
    work = work._replace(stop=deadline.stop)
    kernels.solve_lagrangian(range(len(inputs.zones)), inputs, settings, results, work)
    deadline.check()


def descend(
    system: ZoneSystem,
    options: Options,
    constraints: ScaledConstraints,
    trace: bool = False,
    solve: SolveOn = run_on_cpu,
) -> SystemSolution:
    """Solve every zone of a system with an augmented-Lagrangian method or a preset.

    A method works in scaled variables, a preset in the variables of the system that it is from.

    Args:
        system: The zones.
        options: The method or the preset, and the tolerances.
        constraints: The constraints of the system in scaled variables.
        trace: Whether to record the objective and the violation of the first zone.
        solve: Runs the kernel of the CPU or the kernels of a GPU.

    Source: XRTailor documentation, "Impact Zone Optimization"; docs/method sections 3 and 4.
    """
    n_zones = len(system.impact_offsets) - 1
    preset = preset_of(options)
    settings = choose_settings(options, system.thickness)
    variables = choose_variables(system, constraints, preset)
    layout = lay_out(system, constraints, settings.direction)
    dtype = np.dtype(options.precision)
    results = Results(
        np.zeros(layout.unknown_offsets[-1], dtype),
        np.zeros(len(layout.nodes), dtype),
        np.zeros(n_zones, np.int32),
        np.zeros(n_zones),
        np.zeros(n_zones),
        np.zeros((n_zones, settings.max_steps if trace else 0, 2)),
    )
    solve(make_inputs(system, options, constraints, variables, layout), settings, results)
    x, steps = results.x[layout.place], results.steps
    displacements = np.zeros_like(system.proposed)
    displacements[: len(x)] = variables.lengths[:, None] * x
    multipliers: Multipliers = variables.forces * results.multipliers
    return SystemSolution(
        system.proposed + displacements,
        displacements,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(constraints.hopeless, system.impact_offsets[:-1]),
        steps,
        np.full(n_zones, preset.method if preset else options.method),
        results.trace[0, : steps[0]] if trace else None,
    )

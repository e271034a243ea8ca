"""The augmented-Lagrangian solver: one thread a zone."""

from izo_ref.base.compile import cpu_kernel
from izo_ref.base.serial.thread_group import alone
from izo_ref.solvers.serial.descent import minimise_zone
from izo_ref.solvers.serial.records import Inputs, Results, WorkSpace
from izo_ref.solvers.serial.settings import Settings


@cpu_kernel
def solve_lagrangian(
    # Share:
    begin: int,  # i8, the first of the zones of this share
    end: int,  # i8, behind the last one
    # In:
    inputs: Inputs,  # Inputs in f8 or f4, of solvers/serial/records.py
    settings: Settings,  # Settings
    # Out:
    results_out: Results,  # Results in f8 or f4
    work_out: WorkSpace,  # WorkSpace in f8 or f4
) -> None:
    """Solve zones, one thread a zone."""
    for k in range(begin, end):
        minimise_zone(
            inputs.zones[k], work_out.states[k, 0], alone(), inputs, settings, results_out, work_out
        )

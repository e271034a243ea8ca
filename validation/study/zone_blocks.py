"""Measure block pivoting on a GPU, by one block a zone and by all blocks: a part of the study."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from izo_ref import Options, solve_zone
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.constraints import residuals
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import ZoneSystem, problem_system
from validation.rows import Rows
from validation.scenes.piles import stack_zone
from validation.scenes.zones import random_zone
from validation.study.gpu_parts import Clock
from validation.study.gpu_timing import event_ms
from validation.study.parts import Say
from validation.study.timing import measure

SEED = 20261130
RANDOM = (8, 16, 32, 64, 128, 256, 400, 1000)  # impacts; the constraints are far from dependent
STACKS = ((3, 5), (4, 6), (5, 7), (6, 8), (5, 13), (6, 30))  # layers, and vertices of a side
THREADS = (32, 64, 128, 256)  # of a block
SHARED_KIB = (16, 96, 200)  # most shared memory of a block
COPIES = 100  # of a zone, which are solved at the same time
REPEATS, CPU_BUDGET_S = 5, 2.0


def measure_blocks(folder: Path, gpu: str, say: Say, clock: Clock) -> None:
    """Solve zones by one block each, one zone alone and many at the same time, and by all blocks.

    Args:
        folder: Folder of the rows.
        gpu: Name of the GPU.
        say: Takes lines of progress.
        clock: Cuts the zones off when the time is used up.
    """
    from izo_ref.solvers import gpu_pivoting

    rows = Rows(folder, "blocks", ("zone", "impacts", "threads", "shared_kib"))
    cases = clock.cases(_zones(), lambda zone: f"{zone[0]} {len(zone[1].nodes)}", say)
    for name, problem in cases:
        is_large = len(problem.nodes) > gpu_pivoting.LARGEST  # no block has room for it
        for threads in THREADS[:1] if is_large else THREADS:
            for shared_kib in SHARED_KIB[:1] if is_large else SHARED_KIB:
                sizes = {"threads": threads, "shared_kib": shared_kib}
                key = {"zone": name, "impacts": len(problem.nodes), **sizes}
                if rows.has(**key):
                    continue
                with (
                    patch.object(gpu_pivoting, "THREADS", threads),
                    patch.object(gpu_pivoting, "SHARED", shared_kib << 10),
                ):
                    rows.add(**key, gpu=gpu, **_solved(problem))
        say(f"blocks: {name} {len(problem.nodes)}: by all {rows.all()[-1]['all_ms']:.3f} ms")


def _zones() -> Iterator[tuple[str, ZoneProblem]]:
    """Yield the name of a family, and a zone of it."""
    for n in RANDOM:
        yield "random", random_zone(np.random.default_rng([SEED, n]), n, fresh_only=True)
    for sizes in STACKS:
        yield "stack", stack_zone(np.random.default_rng([SEED, *sizes]), *sizes)


def _solved(problem: ZoneProblem) -> dict[str, float | int | bool | None]:
    """Solve one zone, and copies of it, and return what a row says."""
    from izo_ref.base.gpu_arrays import to_cpu
    from izo_ref.solvers.gpu_pivoting import LARGEST
    from izo_ref.solvers.gpu_solve import SMALL

    system, solver, (by_thread, by_block, by_all) = _prepared(problem, 1)
    is_large = len(problem.nodes) > LARGEST
    by_all()
    all_ms = event_ms(by_all, REPEATS)
    all_solved = bool(to_cpu(solver.answers.solved)[0])
    if not is_large:
        by_block()
    one_ms = None if is_large else event_ms(by_block, REPEATS)
    u, z, solved, steps = map(to_cpu, solver.answers)
    rows = scale_constraints(system)
    own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
    violation, gap = residuals(0, *own, u, z)
    many_ms, all_same = None, None
    if not is_large:
        _, copies, (_, each_by_block, _) = _prepared(problem, COPIES)
        many_ms = event_ms(each_by_block, REPEATS)
        all_same = bool((to_cpu(copies.answers.solved) == solved[0]).all())
    is_small = len(problem.nodes) <= SMALL
    thread_ms = event_ms(by_thread, REPEATS) if is_small else None
    cpu = measure(lambda: solve_zone(problem), REPEATS, CPU_BUDGET_S)
    return {
        "solved": bool(solved[0]),
        "active": int(np.count_nonzero(u)),
        "solves": int(steps[0]),
        "gap": gap,
        "violation": violation / problem.thickness,
        "one_ms": one_ms,
        "many_ms": many_ms,
        "thread_ms": thread_ms,
        "all_ms": all_ms,
        "solved_by_all": all_solved,
        "all_same": all_same,
        "cpu_ms": 1e3 * cpu.seconds,
    }


def _prepared(problem: ZoneProblem, n_copies: int) -> tuple[ZoneSystem, Any, Any]:
    """Put copies of a zone on the GPU, side by side.

    Returns:
        The copies on the CPU, the solver of the GPU, and three functions that solve the copies: by
        one thread a zone, by one block a zone, and by all blocks, one zone after the other.
    """
    from izo_ref.base.gpu_arrays import to_gpu
    from izo_ref.solvers.gpu_system import solver_of_system

    system, _ = problem_system([problem] * n_copies)
    solver: Any = solver_of_system(system, Options(), scale_constraints(system))
    sizes = np.zeros(at.N_SIZES, np.int64)
    sizes[[at.SMALL, at.MIDDLE, at.LARGE]] = n_copies
    begin, copies = to_gpu(sizes), to_gpu(np.arange(n_copies))
    offsets = to_gpu(system.impact_offsets), to_gpu(system.vertex_offsets)

    def from_the_start(launch: Callable[[], None]) -> Callable[[], None]:
        def run() -> None:
            solver.sizes.copy_to_device(begin)  # the tickets begin anew
            solver.answers.multipliers.clear()  # there is no last solution
            launch()

        return run

    launches = solver.launches_of_lists(copies, copies, copies, *offsets)
    return system, solver, [from_the_start(launch) for launch in launches]

"""Measure zones that a block of a GPU solves by block pivoting: a part of the study of CUDA."""

from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import numpy as np

from izo_ref import Options, solve_zone
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.constraints import residuals
from izo_ref.solvers.serial.small_zone import Limits
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
RANDOM = (8, 16, 32, 64, 128, 256, 400)  # impacts; the constraints are far from dependent
STACKS = ((3, 5), (4, 6), (5, 7), (6, 8))  # layers, and vertices of a side
THREADS = (32, 64, 128, 256)  # of a block
SHARED_KIB = (16, 96, 200)  # most shared memory of a block
COPIES = 100  # of a zone, which are solved at the same time
REPEATS, CPU_BUDGET_S = 5, 2.0


def measure_blocks(folder: Path, gpu: str, say: Say, clock: Clock) -> None:
    """Solve zones by one block each: one zone alone, and many at the same time.

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
        for threads in THREADS:
            for shared_kib in SHARED_KIB:
                sizes = {"threads": threads, "shared_kib": shared_kib}
                key = {"zone": name, "impacts": len(problem.nodes), **sizes}
                if rows.has(**key):
                    continue
                with (
                    patch.object(gpu_pivoting, "THREADS", threads),
                    patch.object(gpu_pivoting, "SHARED", shared_kib << 10),
                ):
                    rows.add(**key, gpu=gpu, **_solved(problem))
        say(f"blocks: {name} {len(problem.nodes)}: {rows.all()[-1]['one_ms']:.3f} ms")


def _zones() -> Iterator[tuple[str, ZoneProblem]]:
    """Yield the name of a family, and a zone of it."""
    for n in RANDOM:
        yield "random", random_zone(np.random.default_rng([SEED, n]), n, fresh_only=True)
    for sizes in STACKS:
        yield "stack", stack_zone(np.random.default_rng([SEED, *sizes]), *sizes)


def _solved(problem: ZoneProblem) -> dict[str, float | int | bool | None]:
    """Solve one zone, and copies of it, and return what a row says."""
    from izo_ref.base.gpu_arrays import full, last_of, to_cpu, to_gpu, zeros
    from izo_ref.solvers.gpu_constraints import GpuConstraints, GpuSolution
    from izo_ref.solvers.gpu_pivoting import solve_in_blocks
    from izo_ref.solvers.gpu_solve import SMALL, solve_small

    options = Options()
    violation_m = options.violation_tolerance * problem.thickness

    def prepared(n_copies: int) -> tuple[ZoneSystem, GpuConstraints, GpuSolution]:
        """Return copies of the zone side by side, and room for their solution."""
        system, _ = problem_system([problem] * n_copies)
        rows = scale_constraints(system)
        offsets = system.impact_offsets, system.vertex_offsets
        own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
        constraints = GpuConstraints(*map(to_gpu, (*offsets, *own)))
        n, m = last_of(constraints.vertex_offsets), len(rows.rhs)
        solved = full(n_copies, False, np.bool_)
        u, z = (zeros((k,), np.float64) for k in (m, 3 * n))
        return system, constraints, GpuSolution(u, z, solved)

    limits = Limits(options.gap_tolerance, violation_m, FARTHEST, full(1, False, np.bool_))
    system, constraints, solution = prepared(1)
    steps = solve_in_blocks(constraints, 0, limits, solution)
    one_ms = event_ms(lambda: solve_in_blocks(constraints, 0, limits, solution), REPEATS)
    u, z, solved = map(to_cpu, solution)
    rows = scale_constraints(system)
    own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
    violation, gap = residuals(0, *own, u, z)
    _, all_constraints, copies = prepared(COPIES)
    many_ms = event_ms(lambda: solve_in_blocks(all_constraints, 0, limits, copies), REPEATS)
    thread_ms = None
    if len(problem.nodes) <= SMALL:
        thread_ms = event_ms(lambda: solve_small(constraints, limits, options, solution), REPEATS)
    cpu = measure(lambda: solve_zone(problem), REPEATS, CPU_BUDGET_S)
    return {
        "solved": bool(solved[0]),
        "active": int(np.count_nonzero(u)),
        "solves": int(to_cpu(steps)[0]),
        "gap": gap,
        "violation": violation / problem.thickness,
        "one_ms": one_ms,
        "many_ms": many_ms,
        "thread_ms": thread_ms,
        "all_same": bool((to_cpu(copies.solved) == solved[0]).all()),
        "cpu_ms": 1e3 * cpu.seconds,
    }

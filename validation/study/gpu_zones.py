"""Zones and memory on a GPU: two parts of the study of CUDA."""

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref import Options, solve_zone
from izo_ref.solvers.augmented_lagrangian import descend
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.records import Inputs, Results
from izo_ref.solvers.serial.settings import Settings
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import problem_system
from validation.rows import Row, Rows
from validation.scenes.piles import stack_zone
from validation.scenes.zones import random_zone
from validation.study.gpu_parts import CPU_BUDGET_S, REPEATS, SEED, Clock, gpu_name, seeded
from validation.study.gpu_timing import once_ms
from validation.study.parts import Say
from validation.study.timing import measure
from validation.study.zone_blocks import measure_blocks

ZONES = (64, 256, 1024, 4096)  # impacts
STACK = (6, 30)  # layers, and vertices of a side: a zone with more impacts than one block takes
SANITIZER_S = 22.0
# Of the augmented-Lagrangian methods, this one reaches 1e-9 on all families of zones but one
# (reports/inner.html), in 4 to 88 steps.
NEWTON: dict[str, Any] = {
    "method": "newton",
    "line_search": "exact",
    "multiplier_update": "inner-solve",
    "penalty": "grown",
}
# a program that runs every kernel of the loop: some zones by one thread, others by one block
SMALL = """
import numpy as np, izo_ref
from izo_ref.solvers import gpu_solve as solve
from validation.scenes.sheets import meeting_sheets
solve.SMALL = 4
scene = meeting_sheets(np.random.default_rng(1), 300)
print(izo_ref.resolve(scene, device="cuda").status)
"""


def zones(folder: Path, say: Say, clock: Clock) -> None:
    """Solve single zones on a GPU by the method for single zones, and on the CPU."""
    rows, gpu = Rows(folder, "zones", ("impacts",)), gpu_name("zones", say)
    if gpu is None:
        return
    problems = [random_zone(seeded(n), n) for n in ZONES]
    problems.append(stack_zone(np.random.default_rng(SEED), *STACK))
    for problem in clock.cases(problems, lambda own: f"{len(own.nodes)} impacts", say):
        n = len(problem.nodes)
        if not rows.has(impacts=n):
            rows.add(impacts=n, gpu=gpu, **solved(problem))
            say(f"zones: {n} impacts: {rows.all()[-1]['kernel_ms']:.3f} ms")


def solved(problem: ZoneProblem) -> Row:
    """Solve a zone on both, and return its row."""
    from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian

    own = NEWTON
    system, _ = problem_system([problem])
    scaled, kernel_ms = scale_constraints(system), list[float]()

    def solve(inputs: Inputs, settings: Settings, results: Results) -> None:
        # the time of the kernel alone, without copies to and from the GPU
        kernel_ms.append(lagrangian.run_on_gpu(inputs, settings, results, once_ms))

    for _ in range(REPEATS + 1):
        descend(system, Options(**own), scaled, solve=solve)
    found = solve_zone(problem, **own, device="cuda")
    solve_zone(problem)  # this may compile, for longer than the budget
    cpu = measure(lambda: solve_zone(problem), REPEATS, CPU_BUDGET_S)
    return {
        "steps": found.iterations,
        "gap": found.residuals.gap,
        "violation": found.residuals.violation,
        "kernel_ms": float(np.median(kernel_ms[1:])),
        "cpu_ms": 1e3 * cpu.seconds,
    }


def blocks(folder: Path, say: Say, clock: Clock) -> None:
    """Solve zones by one block each, by the method that the loop uses."""
    gpu = gpu_name("blocks", say)
    if gpu is not None:
        measure_blocks(folder, gpu, say, clock)


def memory(folder: Path, say: Say, clock: Clock) -> None:
    """Run `compute-sanitizer` on a small step, where it is installed."""
    rows, gpu = Rows(folder, "memory", ("tool",)), gpu_name("memory", say)
    program = shutil.which("compute-sanitizer")
    if gpu is None:
        return
    if program is None:
        say("memory: compute-sanitizer is not installed")
        return
    for tool in clock.cases(("memcheck", "racecheck"), str, say):
        if rows.has(tool=tool):
            continue
        command = [program, "--tool", tool, "--error-exitcode", "9", sys.executable, "-c", SMALL]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=SANITIZER_S)
        except subprocess.TimeoutExpired:
            passed, said = False, f"not done after {SANITIZER_S:.0f} s"
        else:
            lines = (done.stdout + done.stderr).strip().splitlines() or ["nothing said"]
            passed, said = done.returncode == 0, lines[-1].strip("= ")
        rows.add(tool=tool, gpu=gpu, passed=passed, said=said)
        say(f"memory: {tool}: {said}")

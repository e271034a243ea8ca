"""Lower bounds of the times of a step on a GPU: computed, not measured.

What a step has to move and compute follows from its sizes, which are measured on the CPU. The
arrays are those of the code: each input is read once and each output is written once, however many
kernels there are. Operations in float64 are those of the proofs (`operations.py`) and of one dense
factorisation of each zone.
"""

from functools import partial
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

from izo_ref import Result, resolve
from izo_ref.scene import Scene
from izo_ref.zones.problem import ZoneProblem
from validation.rows import Rows
from validation.scenes.piles import stack_zone
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone
from validation.study.gpu_counts import Counts
from validation.study.gpu_limits import LIMITS
from validation.study.gpu_machines import GRID_WAIT_S, Machine
from validation.study.gpu_parts import Clock, seeded
from validation.study.group_zones import GroupZone, count_waits, solve_by_one
from validation.study.operations import measured_operations
from validation.study.parts import Say
from validation.study.timing import measure

TRIANGLES = (10_000, 100_000, 1_000_000)
IMPACTS = 1000  # of a random zone
STACK = (5, 13)  # layers, and vertices of a side
BOX = 9 * 4  # bytes of the box of a path
PARENTS = 8 / 7  # boxes of a tree of width 8, over those of its elements
POINT, VERTEX = 24, 48  # bytes of a position, and of both ends of a path
IMPACT = 4 * 4 + 1 + 8 + 4 * 8 + 3 * 8  # bytes of an impact: nodes, kind, time, weights, normal
CONTACT = 8 + 4 * 4 + 1 + 8 + 3 * 8  # bytes of a contact: key, nodes, kind, time, direction
PAIR, KEY = 8, 16  # bytes of a pair, and of a key with its place
REPEATS, CPU_BUDGET_S = 5, 120.0  # of a step on the CPU


class Sizes(NamedTuple):
    """Sizes of a step, measured on the CPU."""

    triangles: int
    vertices: int
    edges: int
    pairs: int  # whose boxes meet in the first detection, without those at rest
    found: int  # impacts of the first detection
    impacts: int  # in zones at the end
    zones: int
    rows_cubed: int  # sum over the zones of the cube of their impacts that are active
    iterations: int  # of all rounds


class Stage(NamedTuple):
    """What a stage of an iteration has to move and compute at least."""

    name: str
    n_bytes: float
    operations: float  # in float64


def sizes_of(scene: Scene) -> Sizes:
    """Resolve a step on the CPU, and return its sizes."""
    return sizes_of_result(scene, resolve(scene))


def sizes_of_result(scene: Scene, result: Result) -> Sizes:
    """Return the sizes of a step that was resolved."""
    first = result.history[0]
    active = np.add.reduceat(
        (result.multipliers > 0.0)[result.zones.impacts], result.zones.impact_offsets[:-1]
    )
    return Sizes(
        triangles=len(scene.faces),
        vertices=len(scene.pinned),
        edges=len(scene.edges),
        pairs=first.candidates,
        found=first.found,
        impacts=len(result.impacts.toi),
        zones=len(result.zones),
        rows_cubed=int((active.astype(np.int64) ** 3).sum()),
        iterations=len(result.history),
    )


def stages_of(own: Sizes, operations_of_a_pair: float) -> list[Stage]:
    """Return the stages of an iteration with all impacts in the zones."""
    elements = own.vertices + own.edges + own.triangles
    corners = 4 * (own.vertices + 2 * own.edges + 3 * own.triangles)
    boxes = elements * BOX * PARENTS
    proofs = own.pairs * operations_of_a_pair
    return [
        Stage("boxes", own.vertices * (VERTEX + BOX) + corners + boxes, 0.0),
        Stage("pairs of boxes", boxes + own.pairs * PAIR, 0.0),
        Stage("proofs", own.pairs * (PAIR + 4 * 4) + own.found * CONTACT, proofs),
        Stage("order and frames", own.found * (CONTACT + 2 * KEY + IMPACT), 0.0),
        Stage("selection and zones", own.found * IMPACT + 2 * own.impacts * IMPACT, 0.0),
        Stage("solution of zones", own.impacts * (IMPACT + 9 + 4 * POINT), own.rows_cubed / 3.0),
        Stage("objective, what moved", own.vertices * (2 * VERTEX + POINT + 8), 0.0),
    ]


def stage_ms(stage: Stage, machine: Machine) -> float:
    """Return the time that a stage takes at least [ms]: to move its bytes, or to compute."""
    moved = stage.n_bytes / machine.bytes_per_s
    return 1e3 * max(moved, stage.operations / machine.float64_per_s)


def calls_ms(counts: Counts, machine: Machine) -> float:
    """Return the time in which the host asks for the work of an iteration, at least [ms]."""
    calls = counts.launches + counts.programs + counts.copies
    return 1e3 * (calls * machine.launch_s + counts.arrays * machine.array_s)


def iteration_ms(work_ms: float, counts: Counts, machine: Machine) -> float:
    """Return the time of an iteration, at least [ms].

    The host asks for work while the GPU does other work, so the longer of the two counts. A read
    is answered when the work before it is done, and takes its own time.

    Args:
        work_ms: Time of the stages [ms].
        counts: Counts of the iteration.
        machine: The GPU.
    """
    gpu = work_ms + 1e3 * counts.nodes * machine.node_s
    return max(calls_ms(counts, machine), gpu) + 1e3 * counts.reads * machine.read_s


def goal_counts() -> Counts:
    """Return the counts of an iteration that reaches the goal: all kernels in one program."""
    goals = {name: limit.goal for name, limit in LIMITS.items() if limit.goal is not None}
    return Counts(programs=goals["programs"], nodes=goals["kernels"], reads=goals["reads"])


def link_ms(own: Sizes, machine: Machine) -> float:
    """Return the time to send the proposed positions and to read the answer, at least [ms]."""
    return 1e3 * 2 * own.vertices * POINT / machine.link_bytes_per_s


def step_ms(own: Sizes, operations_of_a_pair: float, counts: Counts, machine: Machine) -> float:
    """Return the time of a whole step, at least [ms].

    Args:
        own: Sizes of the step.
        operations_of_a_pair: Operations of its proof in float64, on average.
        counts: Counts of an iteration.
        machine: The GPU.
    """
    stages = stages_of(own, operations_of_a_pair)
    work = sum(stage_ms(stage, machine) for stage in stages)
    certify = sum(stage_ms(stage, machine) for stage in stages[:3])  # proves all pairs once more
    whole = own.iterations * iteration_ms(work, counts, machine)
    return whole + certify + link_ms(own, machine)


def zone_ms(own: GroupZone, machine: Machine, n_multiprocessors: int) -> float:
    """Return the time to factorise a zone once a solve on some multiprocessors, at least [ms]."""
    rate = machine.float64_per_s * n_multiprocessors / machine.n_multiprocessors
    return 1e3 * own.solves * own.operations / rate


def waits_ms(own: GroupZone) -> float:
    """Return the time in which all blocks of an H200 wait for each other to solve a zone [ms]."""
    return 1e3 * count_waits(own) * GRID_WAIT_S


def bounds(folder: Path, say: Say, _clock: Clock) -> None:
    """Measure the sizes from which the page computes bounds; large sheets take minutes."""
    rows, operations = Rows(folder, "sizes", ("triangles",)), None
    for n in TRIANGLES:
        scene = meeting_sheets(seeded(n), n)
        if not rows.has(triangles=len(scene.faces)):
            operations = operations or measured_operations()
            cpu = measure(partial(resolve, scene), REPEATS, CPU_BUDGET_S)
            rows.add(
                **sizes_of_result(scene, cpu.result)._asdict(),
                operations_of_a_pair=operations.each,
                cpu_ms=1e3 * cpu.seconds,
                cpu_threads=numba.get_num_threads(),
            )
        say(f"bounds: {len(scene.faces)} triangles")
    rows = Rows(folder, "zone_sizes", ("zone", "impacts"))
    for name, problem in (("random", random_zone(seeded(0), IMPACTS)), ("stack", stack_of_1000())):
        key = {"zone": name, "impacts": len(problem.nodes)}
        if not rows.has(**key):
            own = solve_by_one(problem)
            rows.add(**key, **{k: v for k, v in own._asdict().items() if k not in key})
        say(f"bounds: {name} zone of {len(problem.nodes)} impacts")


def stack_of_1000() -> ZoneProblem:
    """Return a zone of about a thousand impacts, many of which depend on each other."""
    return stack_zone(seeded(0), *STACK)

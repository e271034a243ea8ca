"""Study of CUDA: what kernels need, whether a GPU finds the same as the CPU, and how long it takes.

It compiles every kernel by ptxas, which needs no GPU. With a GPU it compares detection, zones and
whole steps with the CPU, counts launches, and runs `compute-sanitizer`. It needs numba, numba-cuda,
numpy and scipy, and skips the parts for which ptxas or a GPU is missing.
`python -m validation study cuda` starts it.
"""

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from izo_ref import Options, find_impacts, resolve, solve_zone
from izo_ref.base.arrays import GpuArray
from izo_ref.base.devices import require_gpu
from izo_ref.base.errors import DeviceUnavailableError, InitialIntersectionError
from izo_ref.base.records import Impacts, PairCounts
from izo_ref.scene import Scene
from izo_ref.solvers.augmented_lagrangian import descend
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.records import Inputs, Results
from izo_ref.solvers.serial.settings import Settings
from izo_ref.zones.system import problem_system
from validation import ptx
from validation.rows import Rows
from validation.scenes.piles import stack_zone
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone
from validation.study import steps
from validation.study.gpu_timing import copied_bytes_per_ms, counted_launches, event_ms, once_ms
from validation.study.parts import Part, Say
from validation.study.timing import measure
from validation.study.zone_blocks import measure_blocks

REPEATS = 5  # the median of these is taken, after a first call that does not count
CPU_BUDGET_S, GPU_BUDGET_S = 5.0, 5.0  # for all calls of a step
SHEETS = (100_000, 1_000_000)  # triangles of the sheets that are made here as steps
ZONES = (64, 256, 1024, 4096)  # impacts
STACK = (6, 30)  # layers, and vertices of a side: a zone with more impacts than one block takes
COUNTED = (60, 200)  # triangles of the steps whose launches are counted
COPIED = 1 << 28  # bytes that are copied to measure the bandwidth
SEED = 20261128
SIMULATOR = "simulator"
SANITIZER_S = 120.0
# a program that runs every kernel of the loop: some zones by one thread, others by one block
SMALL = """
import numpy as np, izo_ref
from izo_ref.solvers import gpu_solve as solve
from validation.scenes.sheets import meeting_sheets
solve.SMALL = 4
scene = meeting_sheets(np.random.default_rng(1), 300)
print(izo_ref.resolve(scene, device="cuda").status)
"""


def _kernels(folder: Path, say: Say) -> None:
    """Compile every kernel by ptxas, and record what it needs."""
    rows = Rows(folder, "kernels", ("kernel", "types", "capability"))
    if ptx.ptxas() is None:
        say("kernels: ptxas is not installed (package nvidia-cuda-nvcc)")
        return
    for name, kernel in ptx.kernels():
        for types, signature in ptx.signatures(kernel).items():
            for major, minor in ptx.CAPABILITIES:
                key = {"kernel": name, "types": types, "capability": f"{major}.{minor}"}
                if not rows.has(**key):
                    rows.add(**key, **ptx.build(kernel, signature, (major, minor))._asdict())
        say(f"kernels: {name}")


def _detection(folder: Path, say: Say) -> None:
    """Detect all impacts of a step on a GPU and on the CPU: differences, and times of both."""
    rows, gpu = Rows(folder, "detection", ("step",)), _gpu("detection", say)
    if gpu is None:
        return
    from izo_ref.base.gpu_arrays import to_cpu, to_gpu
    from izo_ref.detection.gpu_detector import Detector

    per_ms = copied_bytes_per_ms(COPIED, REPEATS)
    for name, load in _all_steps():
        if rows.has(step=name):
            continue
        scene = load()
        detector, end = Detector(scene), to_gpu(scene.positions_t1)
        found = [to_cpu(column) for column in detector.find(end)]
        expected = find_impacts(scene)
        rows.add(
            step=name,
            gpu=gpu,
            triangles=len(scene.faces),
            impacts=len(expected.toi),
            **_differences(found, expected),
            gpu_ms=event_ms(lambda d=detector, e=end: d.find(e), REPEATS),
            floor_ms=_least_bytes(scene, detector.counts) / per_ms,
            cpu_ms=1e3 * measure(lambda s=scene: find_impacts(s), REPEATS, CPU_BUDGET_S).seconds,
        )
        say(f"detection: {name}: {rows.all()[-1]['gpu_ms']:.2f} ms")


def _steps(folder: Path, say: Say) -> None:
    """Resolve whole steps on a GPU and on the CPU: status, objective, distance and times."""
    rows, gpu = Rows(folder, "steps", ("step",)), _gpu("steps", say)
    if gpu is None:
        return
    for name, load in _all_steps():
        if rows.has(step=name):
            continue
        scene = load()
        try:
            resolve(scene, device="cuda")  # this may compile, for longer than the budget
        except InitialIntersectionError as error:
            say(f"steps: {name}: {error}")
            continue
        own = measure(lambda s=scene: resolve(s, device="cuda"), REPEATS, GPU_BUDGET_S)
        other = measure(lambda s=scene: resolve(s), REPEATS, CPU_BUDGET_S)
        found, expected = own.result, other.result
        repeated = resolve(scene, device="cuda")
        rows.add(
            step=name,
            gpu=gpu,
            triangles=len(scene.faces),
            status=found.status.name,
            cpu_status=expected.status.name,
            objective=found.objective / expected.objective if expected.objective else 1.0,
            apart_m=float(np.abs(found.positions - expected.positions).max(initial=0.0)),
            same_again=bool(np.array_equal(found.positions, repeated.positions)),
            left=found.left_to_cpu,
            solved=sum(line.solved for line in found.history),
            iterations=len(found.history),
            cpu_iterations=len(expected.history),
            loop_ms=1e3 * (repeated.timings["main"] + repeated.timings["relinearize"]),
            certify_ms=1e3 * repeated.timings["certify"],
            gpu_ms=1e3 * own.seconds,
            cpu_ms=1e3 * other.seconds,
        )
        say(f"steps: {name}: {rows.all()[-1]['gpu_ms']:.2f} ms")


def _launches(folder: Path, say: Say) -> None:
    """Count launches and arrays of whole steps, on a GPU or in the simulator."""
    rows, gpu = Rows(folder, "launches", ("triangles",)), _gpu("launches", say)
    if gpu is None:
        return
    if gpu == SIMULATOR:
        from validation.simulator import prepare

        prepare()
    for n in COUNTED:
        scene = meeting_sheets(_seeded(n), n)
        if rows.has(triangles=len(scene.faces)):
            continue
        with counted_launches() as counts:
            iterations = len(resolve(scene, device="cuda").history)
        rows.add(triangles=len(scene.faces), gpu=gpu, iterations=iterations, **counts)
        say(f"launches: {len(scene.faces)} triangles: {rows.all()[-1]['launches']}")


def _zones(folder: Path, say: Say) -> None:
    """Solve single zones on a GPU and on the CPU."""
    rows, gpu = Rows(folder, "zones", ("impacts",)), _gpu("zones", say)
    if gpu is None:
        return
    from izo_ref.solvers.presets import GPU_METHOD

    own = {name: value for name, value in GPU_METHOD.items() if name != "max_steps"}
    problems = [random_zone(_seeded(n), n) for n in ZONES]
    for problem in (*problems, stack_zone(np.random.default_rng(SEED), *STACK)):
        n = len(problem.nodes)
        if rows.has(impacts=n):
            continue
        system, _ = problem_system([problem])
        options = Options(**own)
        scaled = scale_constraints(system)
        kernel_ms: list[float] = []

        def solve(
            inputs: Inputs,
            settings: Settings,
            results: Results,
            times: list[float] = kernel_ms,
        ) -> None:
            times.append(_launch_ms(inputs, settings, results))

        for _ in range(REPEATS + 1):
            descend(system, options, scaled, solve=solve)
        found = solve_zone(problem, **own, device="cuda")
        solve_zone(problem)  # this may compile, for longer than the budget
        cpu = measure(lambda p=problem: solve_zone(p), REPEATS, CPU_BUDGET_S)
        rows.add(
            impacts=n,
            gpu=gpu,
            steps=found.iterations,
            gap=found.residuals.gap,
            violation=found.residuals.violation,
            kernel_ms=float(np.median(kernel_ms[1:])),
            cpu_ms=1e3 * cpu.seconds,
        )
        say(f"zones: {n} impacts: {rows.all()[-1]['kernel_ms']:.3f} ms")


def _blocks(folder: Path, say: Say) -> None:
    """Solve zones by one block each, by the method that the loop uses."""
    gpu = _gpu("blocks", say)
    if gpu is not None:
        measure_blocks(folder, gpu, say)


def _launch_ms(inputs: Inputs, settings: Settings, results: Results) -> float:
    """Measure the time of the kernel alone, without copies to and from the GPU [ms]."""
    from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian

    return lagrangian.run_on_gpu(inputs, settings, results, once_ms)


def _memory(folder: Path, say: Say) -> None:
    """Run `compute-sanitizer` on a small step, where it is installed."""
    rows, gpu = Rows(folder, "memory", ("tool",)), _gpu("memory", say)
    program = shutil.which("compute-sanitizer")
    if gpu is None:
        return
    if program is None:
        say("memory: compute-sanitizer is not installed")
        return
    for tool in ("memcheck", "racecheck"):
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


def _gpu(part: str, say: Say) -> str | None:
    """Return the name of the GPU; if there is none, say so and return None."""
    try:
        require_gpu()
    except DeviceUnavailableError as error:
        say(f"{part}: {error}")
        return None
    from numba import cuda

    name = getattr(cuda.get_current_device(), "name", SIMULATOR)
    return name.decode() if isinstance(name, bytes) else name


def _all_steps() -> Iterator[tuple[str, Callable[[], Scene]]]:
    """Yield name and loader of each step: step files that exist, and sheets made here."""
    for name in steps.step_names():
        yield name, lambda name=name: steps.load_step(name)
    for size in SHEETS:
        yield f"meeting-sheets-{size}", lambda n=size: meeting_sheets(_seeded(n), n)


def _seeded(size: int) -> np.random.Generator:
    return np.random.default_rng([SEED, size])


def _least_bytes(scene: Scene, counts: PairCounts) -> int:
    """Count the bytes that a detection has to move to or from the memory of the GPU at least once.

    For each vertex, both ends of its path are read, and its box is written and read. For each
    element, its vertices are read, and its box is written and read. Each pair is written and read.
    """
    box = 2 * 9 * 4
    n_elements = len(scene.pinned) + len(scene.edges) + len(scene.faces)
    indices = 4 * (len(scene.pinned) + 2 * len(scene.edges) + 3 * len(scene.faces))
    vertices = len(scene.pinned) * (2 * 24 + box)
    return vertices + indices + n_elements * box + 2 * 8 * sum(counts.pairs.values())


def _differences(found: Sequence[GpuArray], expected: Impacts) -> dict[str, float | int]:
    """Compare the impacts of a GPU with those of the CPU.

    Args:
        found: Columns of the impacts of the GPU, on the CPU.
        expected: Impacts of the CPU.

    Returns:
        The number of pairs that only one of them found, and the largest differences of times and
        normals of the pairs that both found.
    """
    nodes, kinds, toi, _, normals = found
    own, other = (
        {(bool(k), *map(int, row)): i for i, (k, row) in enumerate(zip(ks, ns, strict=True))}
        for ks, ns in ((kinds, nodes), (expected.is_edge_edge, expected.nodes))
    )
    both = sorted(own.keys() & other.keys())
    a, b = [own[key] for key in both], [other[key] for key in both]
    return {
        "only_gpu": len(own) - len(both),
        "only_cpu": len(other) - len(both),
        "toi_difference": float(np.abs(toi[a] - expected.toi[b]).max(initial=0.0)),
        "normal_difference": float(np.abs(normals[a] - expected.normals[b]).max(initial=0.0)),
    }


PARTS: dict[str, Part] = {
    "kernels": _kernels,
    "detection": _detection,
    "blocks": _blocks,
    "zones": _zones,
    "steps": _steps,
    "launches": _launches,
    "memory": _memory,
}

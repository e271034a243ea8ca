"""The device: what its kernels need, whether it finds the same, and how long it takes.

Needs numba, numba-cuda, numpy and scipy; ptxas, or a GPU, for what they are there for.
"""

import shutil
import subprocess
import sys
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from izo_ref import Options, find_impacts, resolve, solve_zone
from izo_ref.base.devices import require_gpu
from izo_ref.base.errors import DeviceUnavailableError
from izo_ref.solvers.augmented_lagrangian import descend
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.zones.system import problem_system
from validation import ptx
from validation.rows import Rows
from validation.scenes.piles import stack_zone
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone
from validation.study import steps
from validation.study.timing import measure

REPEATS = 5  # of which the median is taken, after one that does not count
CPU_BUDGET_S, GPU_BUDGET_S = 5.0, 5.0  # for the repeats of a step
SHEETS = (100_000, 1_000_000)  # triangles of steps made here
ZONES = (64, 256, 1024, 4096)  # impacts
STACK = (6, 30)  # layers, and vertices of a side: more impacts than a block takes
COUNTED = (60, 200)  # triangles of steps whose launches are counted
COPIED = 1 << 28  # bytes, to measure the bandwidth
SEED = 20261128
SIMULATOR = "simulator"
SANITIZER_S = 120.0
# a step with every kernel of the loop, zones by threads and by blocks
SMALL = """
import numpy as np, izo_ref
from izo_ref.solvers import gpu_solve as solve
from validation.scenes.sheets import meeting_sheets
solve.SMALL = 4
scene = meeting_sheets(np.random.default_rng(1), 300)
print(izo_ref.resolve(scene, device="cuda").status)
"""


def _kernels(folder, say):
    """What ptxas says of every kernel."""
    rows = Rows(folder, "kernels", ("kernel", "types", "capability"))
    if ptx.ptxas() is None:
        say("kernels: no ptxas (nvidia-cuda-nvcc)")
        return
    for name, kernel in ptx.kernels():
        for types, signature in ptx.signatures(kernel).items():
            for major, minor in ptx.CAPABILITIES:
                key = {"kernel": name, "types": types, "capability": f"{major}.{minor}"}
                if not rows.has(**key):
                    rows.add(**key, **ptx.build(kernel, signature, (major, minor))._asdict())
        say(f"kernels: {name}")


def _detection(folder, say):
    """All impacts of a step: the same as the processor's, and the time of both."""
    rows, gpu = Rows(folder, "detection", ("step",)), _gpu("detection", say)
    if gpu is None:
        return
    from izo_ref.base.gpu_arrays import to_cpu, to_gpu
    from izo_ref.detection.gpu_detector import Detector

    per_ms = _copied_bytes_per_ms()
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
            gpu_ms=_event_ms(lambda d=detector, e=end: d.find(e)),
            floor_ms=_least_bytes(scene, detector.counts) / per_ms,
            cpu_ms=1e3 * measure(lambda s=scene: find_impacts(s), REPEATS, CPU_BUDGET_S).seconds,
        )
        say(f"detection: {name}: {rows.all()[-1]['gpu_ms']:.2f} ms")


def _steps(folder, say):
    """Whole steps: status and objective of both, how far apart they end, and the time of both."""
    rows, gpu = Rows(folder, "steps", ("step",)), _gpu("steps", say)
    if gpu is None:
        return
    for name, load in _all_steps():
        if rows.has(step=name):
            continue
        scene = load()
        resolve(scene, device="cuda")  # it may compile, for longer than the budget
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


def _launches(folder, say):
    """What steps ask of a device; the simulator may count it as well."""
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
        with _counted() as counts:
            iterations = len(resolve(scene, device="cuda").history)
        rows.add(triangles=len(scene.faces), gpu=gpu, iterations=iterations, **counts)
        say(f"launches: {len(scene.faces)} triangles: {rows.all()[-1]['launches']}")


@contextmanager
def _counted():
    """Launches and arrays of the device that were made, a dict that is right at the end."""
    from numba import cuda

    from izo_ref.base.cuda.compile import Kernel

    counts, in_blocks, make = {"launches": 0, "arrays": 0}, Kernel.in_blocks, cuda.device_array

    def counting_blocks(kernel, n_blocks, *sizes):
        counts["launches"] += n_blocks > 0
        return in_blocks(kernel, n_blocks, *sizes)

    def counting_arrays(*arguments, **named):
        counts["arrays"] += 1
        return make(*arguments, **named)

    with (
        patch.object(Kernel, "in_blocks", counting_blocks),
        patch.object(cuda, "device_array", counting_arrays),
    ):
        yield counts


def _zones(folder, say):
    """One zone alone, by the device and by the processor."""
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
        kernel_ms = []

        def solve(inputs, results, times=kernel_ms):
            times.append(_launch_ms(inputs, results))

        for _ in range(REPEATS + 1):
            descend(system, options, scaled, solve=solve)
        found = solve_zone(problem, **own, device="cuda")
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


def _launch_ms(inputs, results):
    """Of the kernel alone; arrays are on the device before and after."""
    from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian

    return lagrangian.run_on_gpu(inputs, results, _once_ms)


def _memory(folder, say):
    """`compute-sanitizer` on a small step, where it is installed."""
    rows, gpu = Rows(folder, "memory", ("tool",)), _gpu("memory", say)
    program = shutil.which("compute-sanitizer")
    if gpu is None:
        return
    if program is None:
        say("memory: no compute-sanitizer")
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


def _gpu(part, say):
    """Its name; None, which is said, if there is none."""
    try:
        require_gpu()
    except DeviceUnavailableError as error:
        say(f"{part}: {error}")
        return None
    from numba import cuda

    name = getattr(cuda.get_current_device(), "name", SIMULATOR)
    return name.decode() if isinstance(name, bytes) else name


def _all_steps():
    """Name of each step, and what loads it: files that are there, and sheets made here."""
    for name in steps.step_names():
        yield name, lambda name=name: steps.load_step(name)
    for size in SHEETS:
        yield f"meeting-sheets-{size}", lambda n=size: meeting_sheets(_seeded(n), n)


def _seeded(size):
    return np.random.default_rng([SEED, size])


def _least_bytes(scene, counts):
    """What a detection cannot do without moving once, to the device's memory or from it.

    Both ends of the path of each vertex, read; its box, written and read; of each element its
    vertices, read, and its box, written and read; each pair, written and read.
    """
    box = 2 * 9 * 4
    n_elements = len(scene.pinned) + len(scene.edges) + len(scene.faces)
    indices = 4 * (len(scene.pinned) + 2 * len(scene.edges) + 3 * len(scene.faces))
    vertices = len(scene.pinned) * (2 * 24 + box)
    return vertices + indices + n_elements * box + 2 * 8 * sum(counts.pairs.values())


def _copied_bytes_per_ms():
    """Bytes read and written, of a copy from the device to itself."""
    from izo_ref.base.gpu_arrays import copy, full

    values = full(COPIED // 8, 0.0, np.float64)
    target = copy(values)
    return 2 * COPIED / _event_ms(lambda: target.copy_to_device(values))


def _differences(found, expected):
    """Pairs of one alone; of both, the farthest times and normals."""
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


def _event_ms(call):
    call()
    return float(np.median([_once_ms(call) for _ in range(REPEATS)]))


def _once_ms(call):
    from numba import cuda

    begin, end = cuda.event(), cuda.event()
    begin.record()
    call()
    end.record()
    end.synchronize()
    return begin.elapsed_time(end)


PARTS = {
    "kernels": _kernels,
    "detection": _detection,
    "zones": _zones,
    "steps": _steps,
    "launches": _launches,
    "memory": _memory,
}

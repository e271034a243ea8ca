"""Check on small cases that a GPU finds what the CPU finds; the first difference ends the study."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref import Options, certify_path, find_impacts, keep_on_gpu, resolve, solve_zone
from izo_ref.base.arrays import GpuArray
from izo_ref.base.devices import copy_to_cpu
from izo_ref.base.errors import InitialIntersectionError
from izo_ref.base.options import CHOICES, LAGRANGIAN
from izo_ref.base.records import Impacts
from izo_ref.detection.intersections import find_intersections
from izo_ref.scene import Scene
from izo_ref.solvers.presets import PRESETS
from validation.rows import Rows
from validation.scenes import stored
from validation.scenes.piles import stack_zone
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone
from validation.study.gpu_parts import Clock, gpu_name, seeded
from validation.study.parts import Say

# Sizes of arrays: one key, and more; keys of one block, its neighbours, and of many blocks.
LENGTHS = (1, 127, 1023, 1024, 1025, 5000, 1_100_000)
ZONES = (1, 2, 7, 33, 200)  # impacts
STACK = (4, 6)  # layers, and vertices of a side
SHEETS = 300  # triangles of the sheets that every option resolves
THICKNESS_M = 1e-3  # of these sheets
STARTS = 9  # positions on the way of a scene that are checked as starts
PROCESSES = 8  # that compile at the same time
LOOSE = 1e-5  # tolerances of the first-order methods, which take long to reach tight ones
# Times of impact are proved from below. Both devices bound the same roots, so they differ by
# roundings of them; a root that is nearly double has an error of the square root of a rounding.
TIME_APART = 2.0**-26


class Case(NamedTuple):
    """A comparison of a GPU with the CPU."""

    name: str
    differences: Callable[[], Iterable[str]]  # a sentence for each difference


def check(folder: Path, say: Say, clock: Clock) -> str | None:
    """Compare all cases; return the first difference, with the name of its case.

    Every run compares them all, whatever rows there are, because the code may have changed.
    """
    rows, gpu = Rows(folder, "check", ("case",)), gpu_name("check", say)
    if gpu is None:
        return None
    for case in clock.cases(cases(), lambda own: own.name, say):
        begin = time.perf_counter()
        said = next(iter(case.differences()), None)
        if said is not None:
            say(f"check: {case.name}: DIFFERS: {said}")
            return f"{case.name}: {said}"
        if not rows.has(case=case.name):
            rows.add(case=case.name, gpu=gpu, seconds=time.perf_counter() - begin)
        say(f"check: {case.name}: the same")
    return None


def warm(_folder: Path, say: Say, clock: Clock) -> None:
    """Let several processes run the cases, so that all code is compiled and kept on the disk."""
    if gpu_name("warm", say) is None:
        return
    n = min(os.cpu_count() or 1, PROCESSES)
    command = [sys.executable, "-m", __spec__.name]
    running = [subprocess.Popen([*command, str(i), str(n)]) for i in range(n)]
    for process in running:
        try:
            process.wait(max(clock.left_s(), 0.0))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    say(f"warm: {n} processes compiled for {clock.spent_s():.0f} s")


def run_share(share: int, n_shares: int) -> None:
    """Run some of the cases, whatever they say; `check` judges them later."""
    for case in islice(cases(), share, None, n_shares):
        with suppress(Exception):
            list(case.differences())


def cases() -> Iterator[Case]:
    """Yield all cases, those that need the least code first."""
    for n in LENGTHS:
        yield Case(f"arrays of {n}", lambda n=n: array_differences(n))
    yield Case("a program of launches", program_differences)
    scenes = [(name, lambda name=name: stored.load_step(name)) for name in stored.names("step")]
    for name, load in scenes:
        yield Case(f"detection of {name}", lambda load=load: detection_differences(load()))
    for name, load in scenes:
        yield Case(f"starts of {name}", lambda load=load: start_differences(load()))
    sheets = meeting_sheets(seeded(SHEETS), SHEETS)
    yield Case("a scene that stays on the GPU", lambda: kept_differences(sheets))
    for name, load in scenes:
        yield Case(f"step {name}", lambda load=load: step_differences(load(), None, Options()))
    for options in all_options():
        named = ", ".join(f"{k} {v}" for k, v in options.items())
        yield Case(f"step with {named}", lambda own=options: option_differences(own))
    for n in ZONES:
        yield Case(f"zone of {n} impacts", lambda n=n: zone_differences(random_zone(seeded(n), n)))
    yield Case("zone of a stack", lambda: zone_differences(stack_zone(seeded(1), *STACK)))


def all_options() -> Iterator[dict[str, Any]]:
    """Yield options of a step: each selection, plan, method and preset that runs on a GPU."""
    yield from ({"selection": name} for name in CHOICES["selection"])
    yield from ({"plan": plan} for plan in ("everything", ("incremental",)))
    yield from ({"method": name} for name in LAGRANGIAN)
    yield from ({"preset": name} for name in PRESETS)


def array_differences(n: int) -> Iterator[str]:
    """Compare the order of n numbers, and the numbers in this order, with those of numpy."""
    from izo_ref.base.gpu_arrays import empty, put_rows, to_cpu, to_gpu
    from validation.study.gpu_sort import stable_argsort

    rng = np.random.default_rng(n)
    keys, values, put = rng.integers(-5, max(n // 2, 1), n), rng.random(n), empty(n, np.float64)
    on_gpu, order = to_gpu(keys), np.argsort(keys, kind="stable")
    put_rows(to_gpu(order), to_gpu(values[order]), put)
    pairs = {
        "a copy": (on_gpu, keys),
        "a stable order": (stable_argsort(on_gpu), order),
        "rows of an index": (put, values),
    }
    for name, (found, expected) in pairs.items():
        if not np.array_equal(to_cpu(found), expected):
            yield f"{name} differ from those of numpy"


def program_differences() -> Iterator[str]:
    """Run launches as a program, twice, and compare what they write."""
    from izo_ref.base.cuda.arrays import take_rows
    from izo_ref.base.cuda.compile import THREADS
    from izo_ref.base.cuda.program import Program
    from izo_ref.base.gpu_arrays import to_cpu, to_gpu, zeros

    n = 3 * THREADS
    index, values = to_gpu(np.arange(n)), zeros((n, 1), np.float64)
    given = [to_gpu(np.full((n, 1), value)) for value in (7.0, 5.0)]
    program = Program([take_rows.prepare(3, THREADS, own, index, values) for own in given])
    if to_cpu(values).any():
        yield "a program ran before it was started"
    for _ in range(2):
        program.run()
        if (to_cpu(values) != 5).any():
            yield "the launches of a program did not run in their order"


def detection_differences(scene: Scene) -> Iterator[str]:
    """Compare the impacts of a path, and the certificate of it."""
    found, expected = find_impacts(scene, "cuda"), find_impacts(scene)
    own = impact_differences(found, expected)
    if own["only_gpu"] or own["only_cpu"]:
        yield f"{own['only_gpu']} impacts of the GPU only, {own['only_cpu']} of the CPU only"
    if own["toi_difference"] > TIME_APART:
        yield f"times of impact differ by {own['toi_difference']:.3g}"
    certificates = [certify_path(scene, scene.positions_t1, device=d) for d in ("cuda", "cpu")]
    if certificates[0].free != certificates[1].free:
        yield f"the certificate says free={certificates[0].free}, on the CPU the opposite"


def start_differences(scene: Scene) -> Iterator[str]:
    """Check positions on the way of a scene, from free to tangled, as starts of steps.

    No pair of the stored scenes is nearly as close as rounding there, so floats can tell all.
    """
    from izo_ref.base.gpu_arrays import overwrite
    from izo_ref.detection.gpu_detector import Detector
    from izo_ref.detection.gpu_start import StartCheck

    check, offsets = StartCheck(Detector(scene)), scene.positions_t1 - scene.positions_t0
    for share in np.linspace(0.0, 1.0, STARTS):
        start = scene.positions_t0 + share * offsets
        overwrite(check.start, start)
        own = find_intersections(start, scene.edges, scene.faces)
        if check.is_free() != (own.n_found == 0):
            yield f"the verdict about a start at {share:.3g}, with {own.n_found} intersections"


def kept_differences(scene: Scene) -> Iterator[str]:
    """Compare steps of a scene that stays on the GPU: one, one at rest, and the first again."""
    kept, starts = keep_on_gpu(scene, THICKNESS_M), scene.positions_t0
    first = kept.resolve(scene.positions_t1)
    expected = resolve(scene, THICKNESS_M)
    if first.status is not expected.status or first.n_impacts != len(expected.impacts.toi):
        yield f"a step ends {first.status.name} with {first.n_impacts} impacts, unlike on the CPU"
    ends = [copy_to_cpu("positions", kept.resolve(first.positions).positions)]
    ends += [copy_to_cpu("positions", kept.resolve(scene.positions_t1, starts).positions)]
    for name, end in zip(("a step at rest", "a step after a reset"), ends, strict=True):
        if not np.array_equal(end, copy_to_cpu("positions", first.positions)):
            yield f"{name} ends at other positions than the first step"


def impact_differences(
    found: Impacts | list[GpuArray], expected: Impacts
) -> dict[str, float | int]:
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


def option_differences(options: dict[str, Any]) -> Iterator[str]:
    """Compare a step of two sheets with some options."""
    loose: dict[str, Any] = {"gap_tolerance": LOOSE, "violation_tolerance": LOOSE}
    is_loose = options.get("method") in LAGRANGIAN or "preset" in options
    own = Options(**(options | (loose if is_loose else {})), relinearize=0)
    yield from step_differences(meeting_sheets(seeded(SHEETS), SHEETS), THICKNESS_M, own)


def step_differences(scene: Scene, thickness: float | None, options: Options) -> Iterator[str]:
    """Compare a whole step: statuses, impacts, positions, and the same bits again."""
    try:
        expected = resolve(scene, thickness, options=options)
    except InitialIntersectionError:
        return  # nothing runs on a GPU
    found, again = (resolve(scene, thickness, "cuda", options) for _ in range(2))
    if found.status is not expected.status:
        yield f"status {found.status.name}, on the CPU {expected.status.name}"
    if not np.array_equal(found.positions, again.positions):
        yield "two runs end at different positions"
    own = impact_differences(found.impacts, expected.impacts)
    if own["only_gpu"] or own["only_cpu"]:
        yield f"{own['only_gpu']} impacts in zones of the GPU only, {own['only_cpu']} of the CPU's"
    offsets = [result.positions - scene.positions_t1 for result in (found, expected)]
    size, apart = (
        np.sqrt((scene.masses[:, None] * vector**2).sum())
        for vector in (offsets[1], offsets[0] - offsets[1])
    )
    # Each end has a relative gap of at most g, so it is within sqrt(2 g) of the optimum, relative
    # to the distance of the optimum from the proposed positions.
    bound = 2.0 * np.sqrt(2.0 * options.gap_tolerance) * size
    if apart > bound:
        yield f"positions are {apart:.3g} apart, bound {bound:.3g} [m kg^1/2]"


def zone_differences(problem: Any) -> Iterator[str]:
    """Solve a zone by the method of the GPU, and judge it by its residuals."""
    found = solve_zone(problem, device="cuda")
    if not found.residuals.solved(1e-9, 1e-9):
        yield f"residuals {found.residuals}"
    expected = solve_zone(problem)
    apart = np.abs(found.positions - expected.positions).max(initial=0.0)
    size = np.abs(expected.positions - problem.proposed).max(initial=0.0)
    masses = problem.masses[np.isfinite(problem.masses)]
    mass_ratio = masses.max() / masses.min()
    # as for steps; a vertex with the least mass moves most in a distance that is weighted by mass
    bound = 2.0 * np.sqrt(2e-9 * mass_ratio * len(masses)) * size
    if apart > bound:
        yield f"positions are {apart:.3g} apart, bound {bound:.3g} [m]"


if __name__ == "__main__":
    run_share(int(sys.argv[1]), int(sys.argv[2]))

"""Count launches, arrays and copies of each iteration; this needs no GPU.

A process with the simulator runs a step, counts, and keeps what the host reads. Then the host code
that runs on a GPU runs here, over a driver that runs no kernels and gives the host the same to
read. Both counts have to be equal, and the types of all arguments have to be those that ptxas has
compiled. The time of the second run is that of Python alone.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from izo_ref import Options
from izo_ref.scene import Scene
from validation.provenance import ROOT
from validation.rows import Rows, read
from validation.scenes.sheets import meeting_sheets
from validation.study.gpu_counts import Counter, Counts, iteration_counts, typical
from validation.study.gpu_parts import Clock
from validation.study.parts import Say

SEED = 20261128
COUNTED = (60, 200)  # triangles of the sheets whose iterations are counted
SIMULATED_S = 240.0  # a simulator that does not end is stopped


class Recorded(NamedTuple):
    """What the simulator counted and read."""

    counts: list[Counts]  # of the making of the step, and of each iteration
    reads: list[bytes]  # of each copy to the host


class Replayed(NamedTuple):
    """What the host code of a GPU did over a driver that runs nothing."""

    counts: list[Counts]
    host_ms: list[float | None]  # Python's time of each, None up to the first iteration


def sheets(n_triangles: int) -> Scene:
    """Return sheets that meet."""
    return meeting_sheets(np.random.default_rng([SEED, n_triangles]), n_triangles)


def record(n_triangles: int, path: Path) -> None:
    """Run sheets that meet in the simulator of this process, and write what was counted.

    Args:
        n_triangles: Triangles of the sheets.
        path: A new numpy archive.
    """
    counter, scene = Counter(keeps_reads=True), sheets(n_triangles)
    counts = iteration_counts(scene, Options(), counter)
    sizes = [len(part) for part in counter.read]
    read = np.frombuffer(b"".join(counter.read), np.uint8)
    with open(path, "wb") as file:
        np.savez(file, counts=np.array(counts), sizes=sizes, read=read)


def recorded(n_triangles: int) -> Recorded:
    """Count sheets that meet in a process with the simulator."""
    simulator = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    paths = {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    with TemporaryDirectory() as folder:
        path = Path(folder, "counts.npz")
        command = [sys.executable, "-m", __spec__.name, str(n_triangles), str(path)]
        subprocess.run(command, env=os.environ | simulator | paths, check=True, timeout=SIMULATED_S)
        with np.load(path) as archive:
            ends = np.cumsum(archive["sizes"])[:-1]
            reads = [part.tobytes() for part in np.split(archive["read"], ends)]
            return Recorded([Counts(*map(int, row)) for row in archive["counts"]], reads)


def replayed(n_triangles: int, reads: list[bytes]) -> Replayed:
    """Run the host code of the same step over a driver that gives back what was read.

    Raises:
        ValueError: The host reads something else than in the simulator.
        TypeError: A kernel gets other types than those of its contract.
    """
    from validation.stand_in import Replay, driving

    scene, driver, counter, moments = sheets(n_triangles), Replay(reads), Counter(), list[float]()
    with driving(driver):
        counts = iteration_counts(
            scene, Options(), counter, lambda _: moments.append(time.perf_counter())
        )
    if driver.reads:
        raise ValueError(f"read: {len(driver.reads)} copies less than in the simulator")
    return Replayed(counts, [None, None, *(1e3 * np.diff(moments)).tolist()])


def differences(simulated: list[Counts], found: list[Counts]) -> list[str]:
    """Return what differs between two runs of a step."""
    return [
        f"iteration {i}: {name}: expected {old} as in the simulator, got {new}"
        for i, pair in enumerate(zip(simulated, found, strict=True))
        for name, old, new in zip(Counts._fields, *pair, strict=True)
        if old != new
    ]


def launches(folder: Path, say: Say, _clock: Clock) -> None:
    """Count what each iteration asks of a GPU, and measure the time of Python."""
    rows = Rows(folder, "counts", ("triangles", "iteration"))
    for n in COUNTED:
        if rows.has(triangles=n, iteration=0):
            continue
        simulated = recorded(n)
        found = replayed(n, simulated.reads)
        said = differences(simulated.counts, found.counts)
        if said:
            raise ValueError(f"launches: {n} triangles: {said[0]}")
        for i, counts in enumerate(found.counts):
            rows.add(
                triangles=n,
                iteration=i,
                **counts._asdict(),
                host_ms=found.host_ms[i],
            )
        say(f"launches: {n} triangles: {typical(found.counts).launches} launches an iteration")


def counted_typical(folder: Path, study: str = "counts") -> Counts | None:
    """Return the largest counts of an iteration in the rows of `launches`; None without rows."""
    rows = read(folder, study)
    if not rows:
        return None
    steps: dict[int, list[Counts]] = {}
    for row in sorted(rows, key=lambda row: row["iteration"]):
        own = Counts(*(row[name] for name in Counts._fields))
        steps.setdefault(row["triangles"], []).append(own)
    return Counts(*map(max, zip(*map(typical, steps.values()), strict=True)))


def typical_host_ms(folder: Path) -> float:
    """Return the median time of Python for an iteration after the first one [ms]."""
    return float(np.median([r["host_ms"] for r in read(folder, "counts") if r["iteration"] > 1]))


if __name__ == "__main__":
    from validation.simulator import prepare

    prepare()
    record(int(sys.argv[1]), Path(sys.argv[2]))

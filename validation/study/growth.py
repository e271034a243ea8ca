"""Solve larger and larger cases in one process, and print time and peak memory of each.

    python -m validation.study.growth sheets 1000 3000

The output is one line of JSON for each case. The sizes must rise, so that the peak memory of the
process is that of the last case.
"""

import json
import resource
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import izo_ref
from izo_ref.base.errors import IzoError
from izo_ref.zones.problem import ZoneProblem, ZoneSolution

Outcome = TypeVar("Outcome")

SEED = 20240607
THICKNESS_M = 1e-4
TOLERANCE = 1e-9
ENOUGH_S = 1.0  # a case is repeated until its calls took this long
MOST_REPEATS = 5
WARM = {"sheets": (2000,), "chain": (1, 8, 2000), "pinch": (2, 8, 600), "random": (1, 8, 300)}


def peak_mib() -> float:
    """Return the largest resident size of this process so far [MiB].

    It is read from /proc where that exists, since `ru_maxrss` can be that of the parent process
    after a fork.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024.0
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return largest / (1024.0**2 if sys.platform == "darwin" else 1024.0)


def sheets_row(size: int) -> dict[str, Any]:
    """Measure `resolve` on two sheets of this many triangles.

    Args:
        size: Triangles of both sheets together.

    Returns:
        Counts, and the seconds of each stage in the quickest run. `door_s` are the seconds that it
        takes to make the `Scene`.
    """
    from validation.scenes.sheets import meeting_sheets

    begin = time.perf_counter()
    scene = meeting_sheets(np.random.default_rng([SEED, size]), size)
    door = time.perf_counter() - begin
    result, repeats = _quickest(
        lambda: izo_ref.resolve(scene, THICKNESS_M), lambda result: result.timings["total"]
    )
    certify = result.timings["certify"]
    return {
        "triangles": len(scene.faces),
        "impacts": len(result.impacts.toi),
        "zones": len(result.zones),
        "largest_zone": int(np.diff(result.zones.impact_offsets).max(initial=0)),
        "iterations": len(result.history),
        "total_s": result.timings["total"],
        "detect_s": sum(line.detect_s for line in result.history),
        "solve_s": sum(line.solve_s for line in result.history),
        "certify_s": certify,
        "door_s": door,
        "repeats": repeats,
        "outcome": "converged" if result.converged else "not converged",
        "message": result.status.name,
    }


def zone_row(family: str, size: int) -> dict[str, Any]:
    """Measure `solve_zone` on one zone of this many impacts.

    Args:
        family: Name of a family, as for `zone_of`.
        size: Number of impacts.

    Returns:
        Counts, residuals, and the seconds of the quickest run.
    """
    problem = zone_of(family, size)

    def call() -> tuple[ZoneSolution, float]:
        begin = time.perf_counter()
        solution = izo_ref.solve_zone(problem, tolerance=TOLERANCE)
        return solution, time.perf_counter() - begin

    (solution, seconds), repeats = _quickest(call, lambda outcome: outcome[1])
    judged = solution.residuals
    return {
        "impacts": len(problem.nodes),
        "iterations": solution.iterations,
        "method": solution.method,
        "gap": judged.gap,
        "violation": judged.violation,
        "total_s": seconds,
        "solve_s": seconds,
        "repeats": repeats,
        "outcome": "converged" if judged.solved(TOLERANCE, TOLERANCE) else "not converged",
        "message": "",
    }


def zone_of(family: str, size: int) -> ZoneProblem:
    """Make a zone of a family, or load a recorded zone.

    Args:
        family: "chain", "pinch", "random", or the name of a file with a recorded zone.
        size: Number of impacts; ignored for a recorded zone.
    """
    from validation.scenes import piles, zones
    from validation.study import steps

    rng = np.random.default_rng([SEED, size])
    if family == "chain":
        return piles.chain_zone(rng, size)
    if family == "pinch":
        return piles.pinch_zone(rng, size)
    if family == "random":
        return zones.random_zone(rng, size, 1e3)
    return steps.load_zone(family)


def _quickest(
    call: Callable[[], Outcome], seconds: Callable[[Outcome], float]
) -> tuple[Outcome, int]:
    """Return the outcome of the quickest of some calls, and the number of calls."""
    outcomes, begin = [call()], time.perf_counter()
    spent = seconds(outcomes[0])
    while len(outcomes) < MOST_REPEATS and spent < ENOUGH_S:
        outcomes.append(call())
        spent = max(spent, time.perf_counter() - begin)
    return min(outcomes, key=seconds), len(outcomes)


def main(arguments: Sequence[str]) -> None:
    """Measure the cases of a command line and print a line of JSON for each.

    Args:
        arguments: Name of a family, and the sizes in rising order.
    """
    family, *sizes = arguments
    imported = peak_mib()

    def measured(size: int) -> dict[str, Any]:
        return sheets_row(size) if family == "sheets" else zone_row(family, size)

    for size in WARM.get(family, (600,)):  # compiles, or loads the compiled code
        sheets_row(size) if family == "sheets" else zone_row(
            family if family in WARM else "chain", size
        )
    warm = peak_mib()
    print(json.dumps({"ready": True}), flush=True)
    for size in map(int, sizes):
        try:
            row = measured(size)
        except (IzoError, MemoryError, np.linalg.LinAlgError) as error:
            row = {"outcome": "failed", "message": f"{type(error).__name__}: {error}"}
        row |= {"import_mib": imported, "warm_mib": warm, "peak_mib": peak_mib()}
        print(json.dumps({"size": size, **row}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

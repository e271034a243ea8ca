"""Resolve and judge a case: its steps one after the other."""

import dataclasses
import time

import numpy as np

from izo_ref import resolve
from izo_ref.base.errors import IzoError
from validation.oracles import fcl
from validation.stability_steps import exact, judge, refusals, zones
from validation.stability_steps.case import Case

SMALL = 12  # faces; brute force over all pairs takes long for larger meshes
# Shares of the steps that each judge is asked about, so that thousands of steps take minutes.
SHARES = {"oracle": 0.4, "oracle, large": 0.03, "exact": 0.3, "again": 0.25, "fcl": 0.2}


@dataclasses.dataclass
class Outcome:
    """What came out of a case.

    Attributes:
        statuses: Status of each step, or the class of the error that refused it.
        by_oracle: Steps that the second exact oracle judged.
        by_fcl: Ends that python-fcl judged.
        exact_zones: Zones whose exact optimum was compared.
        again: Results that were resolved again.
        violations: A line for each claim that is not true.
        seconds: Time of `resolve` [s].
    """

    statuses: list[str] = dataclasses.field(default_factory=list)
    by_oracle: int = 0
    by_fcl: int = 0
    exact_zones: int = 0
    again: int = 0
    violations: list[str] = dataclasses.field(default_factory=list)
    seconds: float = 0.0


def run_case(case: Case, rng: np.random.Generator | None = None) -> Outcome:
    """Resolve the steps of a case, and judge each.

    Args:
        case: The case.
        rng: Draws which judges are asked; None asks all.
    """
    out = Outcome()
    result = scene = None
    for number, end in enumerate(case.ends):
        begin = time.process_time()
        try:
            options = case.options()
            scene = case.scene() if scene is None else scene.after(result, end)
            result = resolve(scene, case.thickness, options=options)
        except IzoError as error:
            out.statuses.append(type(error).__name__)
            out.violations += refusals.judge_refusal(case, number, error)
            break
        except Exception as error:  # anything else is never right
            out.statuses.append("crashed")
            out.violations.append(f"crash {type(error).__name__}: {str(error)[:200]}")
            break
        finally:
            out.seconds += time.process_time() - begin
        out.statuses.append(result.status.name)
        out.violations += judge.judge_result(scene, result)
        out.violations += zones.judge_residuals(scene, result)
        _ask_oracles(out, case, scene, result, rng)
        if not result.certificate.free:
            break
    return out


def _ask_oracles(out: Outcome, case: Case, scene, result, rng) -> None:
    """Ask the judges that take time, all or some of them."""

    def asked(judge: str) -> bool:
        return rng is None or rng.random() < SHARES[judge]

    if asked("oracle" if len(scene.faces) <= SMALL else "oracle, large"):
        out.by_oracle += 1
        out.violations += exact.judge_path(result.certificate)
    if asked("exact"):
        counts = zones.judge_exactly(scene, result)
        out.exact_zones += counts.asked
        out.violations += counts.wrong
    if asked("again") and result.certificate.free:
        out.again += 1
        out.violations += judge.again(scene, result, case.thickness, result.options)
    whole = result.certificate.excluded is None and scene.touching is None and scene.copies is None
    if result.certificate.free and whole and asked("fcl"):
        out.by_fcl += 1
        out.violations += _end_by_fcl(result.positions, scene.faces)


def _end_by_fcl(positions: np.ndarray, faces: np.ndarray) -> list[str]:
    """Judge the end by python-fcl; a hit counts if rational arithmetic confirms it.

    Lengths are multiplied by a power of two, because python-fcl has no range.
    """
    size = float(np.abs(positions).max(initial=0.0))
    scaled = np.ldexp(positions, -int(np.frexp(size)[1])) if size > 0.0 else positions
    wrong = []
    for one, other in fcl.crossing_faces(scaled, faces):
        if _cross(scaled, faces[one], faces[other]):
            wrong.append(f"python-fcl: faces {one} and {other} cross at the end")
    return wrong[:3]


def _cross(positions: np.ndarray, one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether an edge of one of two faces meets the other one; exact."""
    for a, b in ((one, other), (other, one)):
        edges = np.array([[a[k], a[k - 1]] for k in range(3)])
        edges = edges[~np.isin(edges, b).any(axis=1)]
        if len(edges) and fcl.edges_meet(positions[edges], positions[[b] * len(edges)]).any():
            return True
    return False

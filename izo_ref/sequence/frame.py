"""A resolved frame of a sequence, and how it is put together from substeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Indices, Positions
from izo_ref.base.records import Exclusion, Pairs, PairState, Status
from izo_ref.certificate.certify import PathCertificate
from izo_ref.loop.resolve import Result
from izo_ref.scene import Scene
from izo_ref.sequence.pull import Tangle
from izo_ref.sequence.rounding import RoundedEnd
from izo_ref.zones.objective import objective

# From the best to the worst; a frame has the worst of its substeps.
ORDER = (Status.FREE, Status.FREE_BY_FALLBACK, Status.FREE_EXCEPT_EXCLUDED, Status.BLOCKED)


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A resolved frame of a sequence.

    Attributes:
        number: Number of the frame, from 0, which is the start.
        positions: (n, 3) f8 [m], end of the path of this frame; each number is a float of the
            precision that was asked for.
        status: The worst status of its substeps. `BLOCKED` if the frame ends before the proposed
            one is reached; the next frame goes on from there.
        reached: Fraction of the way to the proposed frame that was gone, 1 unless it is blocked.
        substeps: Number of steps into which the way was cut; 0 for the start.
        impacts: Number of impacts in the zones of all substeps.
        objective: sum m |x - y|^2 / sum m over the unpinned vertices [m^2].
        excluded: Number of pairs that are left out at the end of the frame, because they were never
            apart since the start. With a pull, the pairs that cross or touch at the end of the
            frame.
        crossings: Number of edges that meet a face at the end of the frame, other than between
            pinned vertices; None without a pull, which alone counts them.
        stayed: (k,) i8, vertices that were not tangle in this frame, because that would have added
            a crossing.
        nudged: (k,) i8, vertices that rounding alone would have put in contact, and that ended a
            few floats away.
        held: (k,) i8, vertices that stayed at the start of a substep, because rounding left them no
            free end near the answer.
        meeting: The pairs that block the frame; None if it is not blocked.
        meeting_toi: (k,) f8, fraction of the way at which each of them meets.
        result: Result of the last substep before rounding; None for the start.
        certificate: Certificate of the path of the last substep, to `positions`; None for the
            start.
    """

    number: int
    positions: Positions
    status: Status
    reached: float
    substeps: int
    impacts: int
    objective: float
    excluded: int
    crossings: int | None
    nudged: Indices
    held: Indices
    meeting: Pairs | None
    meeting_toi: Any
    result: Result | None
    certificate: PathCertificate | None

    @classmethod
    def of_start(cls, number: int, scene: Scene, tangle: Tangle | None) -> Frame:
        """Return the first frame, which is where a scene starts."""
        excluded, nothing = scene.excluded, np.empty(0, np.int64)
        return cls(
            number=number,
            positions=scene.positions_t0,
            status=Status.FREE if excluded is None else Status.FREE_EXCEPT_EXCLUDED,
            reached=1.0,
            substeps=0,
            impacts=0,
            objective=0.0,
            excluded=0 if excluded is None else len(excluded.nodes),
            crossings=None if tangle is None else tangle.crossings,
            nudged=nothing,
            held=nothing,
            meeting=None,
            meeting_toi=np.empty(0),
            result=None,
            certificate=None,
        )


class Substep(NamedTuple):
    """A step of a frame.

    Attributes:
        result: Its result before rounding.
        end: Its rounded end.
        size: Fraction of the way of the frame that it goes.
    """

    result: Result
    end: RoundedEnd
    size: float


class Parts:
    """The substeps of a frame that are free."""

    def __init__(self) -> None:
        """Begin with no substep."""
        self.reached, self._results, self._ends = 0.0, list[Result](), list[RoundedEnd]()

    def add(self, result: Result, end: RoundedEnd, size: float) -> None:
        """Add a substep that goes a fraction of the way."""
        self.reached += size
        self._results.append(result)
        self._ends.append(end)

    def followed_by(self, other: Parts) -> Parts:
        """Return the substeps, and behind them those of a way from their end on."""
        both = Parts()
        both.reached = self.reached
        both._results, both._ends = self._results + other._results, self._ends + other._ends
        return both

    def frame(
        self, number: int, whole: Scene, positions: Positions, last: Substep, tangle: Tangle | None
    ) -> Frame:
        """Return the frame.

        Args:
            number: Number of the frame.
            whole: The step without substeps, to the proposed positions of the caller.
            positions: (n, 3) f8 [m], end of the last free substep.
            last: The last substep, which is blocked if the frame is.
            tangle: What is tangled at the end; None without a pull.
        """
        result, end, size = last
        blocked = self.reached < 1.0
        statuses = [_status(*pair) for pair in zip(self._results, self._ends, strict=True)]
        if blocked:
            statuses.append(Status.BLOCKED)
        certificate = end.certificate
        return Frame(
            number=number,
            positions=positions,
            status=max(statuses, key=ORDER.index),
            reached=self.reached,
            substeps=len(self._results),
            impacts=sum(len(part.impacts.toi) for part in self._results),
            objective=objective(whole, positions),
            excluded=_left_out(self._ends) if tangle is None else tangle.pairs,
            crossings=None if tangle is None else tangle.crossings,
            nudged=_all_of([part.nudged for part in self._ends]),
            held=_all_of([part.held for part in self._ends]),
            meeting=certificate.meeting if blocked else None,
            meeting_toi=self.reached + size * certificate.meeting_toi if blocked else np.empty(0),
            result=result,
            certificate=certificate,
        )


def _status(result: Result, end: RoundedEnd) -> Status:
    """Return the status of a free substep after rounding."""
    if end.certificate.excluded is not None:
        return Status.FREE_EXCEPT_EXCLUDED
    if result.status is Status.FREE and not len(end.held):
        return Status.FREE
    return Status.FREE_BY_FALLBACK


def _left_out(ends: list[RoundedEnd]) -> int:
    """Return how many pairs are not apart at the last end, and have not been since the start."""
    certificate = ends[-1].certificate if ends else None
    excluded = None if certificate is None else certificate.excluded
    if certificate is None or excluded is None:
        return 0
    own = excluded.reasons != Exclusion.PRESCRIBED
    return int(np.count_nonzero(own & (certificate.excluded_ends != PairState.APART)))


def _all_of(parts: list[Indices]) -> Indices:
    return np.unique(np.concatenate(parts)) if parts else np.empty(0, np.int64)

"""Resolve a sequence of frames, so that the path through all of them is certified."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Indices, Positions
from izo_ref.base.devices import copy_to_cpu, detach
from izo_ref.base.errors import IzoError, OptionError, ShapeError
from izo_ref.base.options import Options
from izo_ref.base.records import Exclusion, Pairs, PairState, Status
from izo_ref.certificate.certify import PathCertificate
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from izo_ref.sequence.rounding import PRECISIONS, Precision, RoundedEnd, round_end, rounded
from izo_ref.zones.objective import objective

MAX_SUBSTEPS = 64  # limit that the caller may raise `max_substeps` to
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
            apart since the start.
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
    nudged: Indices
    held: Indices
    meeting: Pairs | None
    meeting_toi: Any
    result: Result | None
    certificate: PathCertificate | None


def resolve_sequence(
    frames: Iterable[Any],
    faces: Any,
    masses: Any = None,
    pinned: Any = None,
    *,
    thickness: float | None = None,
    device: str = "cpu",
    options: Options | None = None,
    precision: Precision = "float64",
    max_substeps: int = 16,
    first: int = 0,
    initial_intersections: str = "ratchet",
    prescribed: str = "exclude",
    weld: float | None = None,
) -> Iterator[Frame]:
    """Resolve each frame from the resolved frame before it.

    The first frame is where the sequence starts; it is only rounded. Each later frame is what
    `resolve` finds close to the proposed one, rounded to the precision, on a path that is certified
    after rounding. What nothing pushes ends at its proposed position, rounded. A frame that is
    blocked is cut into substeps, on whose path proposed positions and pinned vertices go evenly.
    Memory does not grow with the number of frames, since each is taken when it is asked for.

    A sequence can be resumed: with the last resolved frame in front of the proposed ones that
    follow, and `first` as its number, all later frames are the same, bit for bit.

    Args:
        frames: The frames, (n, 3) [m] each; from the second one on, proposed positions.
        faces: (m, 3), as for `Scene`.
        masses: (n,) [kg], as for `Scene`.
        pinned: (n,) bool, as for `Scene`; True for vertices of obstacles.
        thickness: Distance that impacts keep at the end of a step [m]. None takes
            `options.thickness_fraction` of the median edge length of the first frame.
        device: As for `resolve`.
        options: As for `resolve`.
        precision: `float64` or `float32`: the floats in which positions will be written. Or a
            function that takes positions, (n, 3) f8 [m], and returns the nearest ones that will be
            read back, which it leaves as they are.
        max_substeps: Largest number of substeps into which a blocked frame is cut; a power of two.
        first: Number of the first frame.
        initial_intersections: As for `Scene`. With `ratchet`, pairs that cross at the start are
            left out until they are apart at the end of a step; their number never grows.
        prescribed: As for `Scene`.
        weld: As for `Scene`.

    Yields:
        A `Frame` for each frame.

    Raises:
        OptionError: An option has another value.
        ShapeError: There is no frame, or a frame has another shape; the message names the frame.
        IzoError: As `Scene` and `resolve` do; the message names the frame.
    """
    if not callable(precision):
        checks.choice("precision", precision, PRECISIONS)
    if max_substeps not in [2**k for k in range(MAX_SUBSTEPS.bit_length())]:
        raise OptionError(
            f"max_substeps: expected a power of two up to {MAX_SUBSTEPS}, got {max_substeps!r}"
        )
    modes = {"initial_intersections": initial_intersections, "prescribed": prescribed, "weld": weld}
    run = _Run(faces, masses, pinned, modes, thickness, device, options, precision, max_substeps)
    empty = True
    for number, frame in enumerate(frames, first):
        try:
            yield run.start(number, frame) if empty else run.go_to(number, frame)
        except IzoError as error:
            error.args = (f"frame {number}: {error.args[0]}", *error.args[1:])
            raise
        empty = False
    if empty:
        raise ShapeError("frames: expected at least one frame, found none")


class _End:
    """Where the last free substep ended; `Scene.after` takes it as a result."""

    def __init__(self, scene: Scene, end: RoundedEnd) -> None:
        self.scene, self.positions, self.certificate = scene, end.positions, end.certificate


class _Run:
    """A run through the frames of a sequence."""

    def __init__(
        self,
        faces: Any,
        masses: Any,
        pinned: Any,
        modes: dict[str, Any],
        thickness: float | None,
        device: str,
        options: Options | None,
        precision: Precision,
        max_substeps: int,
    ) -> None:
        self._mesh, self._modes = (faces, masses, pinned), modes
        self._thickness, self._device, self._options = thickness, device, options
        self._precision, self._max_substeps = precision, max_substeps
        self._last: _End | None = None
        self._positions: Positions = np.empty((0, 3))

    def start(self, number: int, frame: Any) -> Frame:
        """Check the first frame, and return it rounded."""
        start = checks.floats("positions", copy_to_cpu("positions", detach(frame)), (None, 3))
        start = rounded(start, self._precision)
        scene = Scene(start, start, *self._mesh, **self._modes)
        self._positions = scene.positions_t0
        excluded = scene.excluded
        return Frame(
            number=number,
            positions=self._positions,
            status=Status.FREE if excluded is None else Status.FREE_EXCEPT_EXCLUDED,
            reached=1.0,
            substeps=0,
            impacts=0,
            objective=0.0,
            excluded=0 if excluded is None else len(excluded.nodes),
            nudged=np.empty(0, np.int64),
            held=np.empty(0, np.int64),
            meeting=None,
            meeting_toi=np.empty(0),
            result=None,
            certificate=None,
        )

    def go_to(self, number: int, frame: Any) -> Frame:
        """Resolve the way from the last end to a proposed frame, in as few substeps as needed."""
        begin = self._positions
        frame = checks.floats("positions", copy_to_cpu("positions", detach(frame)), begin.shape)
        target = rounded(frame, self._precision)
        whole, parts = self._scene(target), _Parts()
        size, scene = 1.0, whole
        while True:
            result = resolve(scene, self._thickness, self._device, self._options)
            self._thickness = result.thickness
            end = round_end(scene, result, self._precision, self._device)
            if end.certificate.free:
                self._last, self._positions = _End(scene, end), end.positions
                parts.add(result, end, size)
                if parts.reached == 1.0:
                    break
            elif size * self._max_substeps >= 2.0:
                size /= 2.0
            else:
                break
            goal = begin + (parts.reached + size) * (target - begin)
            at_end = parts.reached + size == 1.0
            scene = self._scene(target if at_end else rounded(goal, self._precision))
        return parts.frame(number, whole, self._positions, result, end, size)

    def _scene(self, proposed: Any) -> Scene:
        """Return the step from the last end to proposed positions."""
        if self._last is None:
            return Scene(self._positions, proposed, *self._mesh, **self._modes)
        return self._last.scene.after(self._last, proposed)


class _Parts:
    """The substeps of a frame that are free."""

    def __init__(self) -> None:
        self.reached, self._results, self._ends = 0.0, list[Result](), list[RoundedEnd]()

    def add(self, result: Result, end: RoundedEnd, size: float) -> None:
        """Add a substep that goes a fraction of the way."""
        self.reached += size
        self._results.append(result)
        self._ends.append(end)

    def frame(
        self,
        number: int,
        whole: Scene,
        positions: Positions,
        result: Result,
        end: RoundedEnd,
        size: float,
    ) -> Frame:
        """Return the frame.

        Args:
            number: Number of the frame.
            whole: The step without substeps.
            positions: (n, 3) f8 [m], end of the last free substep.
            result: The result of the last substep, which is blocked if the frame is.
            end: Its rounded end.
            size: Fraction of the way that it goes.
        """
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
            excluded=_left_out(self._ends[-1].certificate) if self._ends else 0,
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


def _left_out(certificate: PathCertificate) -> int:
    """Return how many pairs are not apart at the end, and have not been since the start."""
    excluded = certificate.excluded
    if excluded is None:
        return 0
    own = excluded.reasons != Exclusion.PRESCRIBED
    return int(np.count_nonzero(own & (certificate.excluded_ends != PairState.APART)))


def _all_of(parts: list[Indices]) -> Indices:
    return np.unique(np.concatenate(parts)) if parts else np.empty(0, np.int64)

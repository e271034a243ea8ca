"""Resolve a sequence of frames, so that the path through all of them is certified."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Positions
from izo_ref.base.devices import copy_to_cpu, detach
from izo_ref.base.errors import IzoError, OptionError, ShapeError
from izo_ref.base.options import Options
from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from izo_ref.sequence.frame import Frame, Parts, Substep
from izo_ref.sequence.pull import PARTS, Pull
from izo_ref.sequence.rounding import PRECISIONS, Precision, RoundedEnd, round_end, rounded

__all__ = ["Frame", "resolve_sequence"]

MAX_SUBSTEPS = 64  # limit that the caller may raise `max_substeps` to


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
    pull: float = 0.0,
    first_proposed: Any = None,
) -> Iterator[Frame]:
    """Resolve each frame from the resolved frame before it.

    The first frame is where the sequence starts; it is only rounded. Each later frame is what
    `resolve` finds close to the proposed one, rounded to the precision, on a path that is certified
    after rounding. What nothing pushes ends at its proposed position, rounded. A frame that is
    blocked is cut into substeps, on whose path proposed positions and pinned vertices go evenly.
    Memory does not grow with the number of frames, since each is taken when it is asked for.

    A sequence can be resumed: with the last resolved frame in front of the proposed ones that
    follow, and `first` as its number, all later frames are the same, bit for bit. With a pull,
    `first_proposed` has to be passed, too.

    With `pull`, what is tangled comes apart from frame to frame: proposed positions at contours
    are displaced so that the contours shrink (`sequence/pull.py`). No frame has more crossings
    than the frame before, unless the motion of pinned vertices adds them.

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
        pull: Largest distance by which the proposed position of a vertex is displaced in a frame,
            in addition to the frames before [m]; 0 for no pull. About half the length of an edge
            is usual. It needs `initial_intersections="ratchet"`. Pairs that come apart are then
            protected as long as no contour comes back to them.
        first_proposed: (n, 3) [m], what was proposed for the first frame, if that is the last
            resolved one of a run with a pull; None if it was proposed as it is, or was blocked.

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
    pull = _checked_pull(pull, initial_intersections)
    modes = {"initial_intersections": initial_intersections, "prescribed": prescribed, "weld": weld}
    run = _Run(faces, masses, pinned, modes, thickness, device, options, precision, max_substeps)
    run.pull, run.first_proposed = pull, first_proposed
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


def _checked_pull(pull: Any, initial_intersections: str) -> float:
    """Return the bound of a pull as a float, or raise an `OptionError`."""
    if not isinstance(pull, (int, float)) or isinstance(pull, bool) or not 0.0 <= pull < np.inf:
        raise OptionError(f"pull: expected a finite number of metres >= 0, got {pull!r}")
    if pull > 0.0 and initial_intersections != "ratchet":
        raise OptionError(
            "pull: expected initial_intersections='ratchet', which lets a start be tangled, got "
            f"{initial_intersections!r}"
        )
    return float(pull)


class _End:
    """Where the last free substep ended; `Scene.after` takes it as a result."""

    def __init__(self, scene: Scene, end: RoundedEnd) -> None:
        self.scene, self.positions, self.certificate = scene, end.positions, end.certificate


class _Way(NamedTuple):
    """The way from the end of a frame to the end of the next one."""

    whole: Scene  # the step without substeps
    parts: Parts
    last: Substep
    end: _End | None  # where the last free substep ended; None if there is none yet
    positions: Positions  # (n, 3) f8 [m], the same place


class _Run:
    """A run through the frames of a sequence.

    Attributes:
        pull: Largest displacement of a vertex in a frame [m].
        first_proposed: What was proposed for the first frame, or None.
    """

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
        self.pull, self.first_proposed = 0.0, None
        self._pull: Pull | None = None
        self._last: _End | None = None
        self._positions: Positions = np.empty((0, 3))

    def start(self, number: int, frame: Any) -> Frame:
        """Check the first frame, and return it rounded."""
        start = checks.floats("positions", copy_to_cpu("positions", detach(frame)), (None, 3))
        start = rounded(start, self._precision)
        if self.pull > 0.0:
            # each frame leaves out what crosses at its start; `Pull` lets no crossing be added
            self._modes["initial_intersections"] = "exclude"
        scene = Scene(start, start, *self._mesh, **self._modes)
        self._positions = scene.positions_t0
        if self.pull > 0.0:
            before = start if self.first_proposed is None else self.first_proposed
            before = copy_to_cpu("first_proposed", detach(before))
            before = checks.floats("first_proposed", before, start.shape)
            self._pull = Pull(scene, self.pull, rounded(before, self._precision))
        return Frame.of_start(number, scene, None if self._pull is None else self._pull.tangle)

    def go_to(self, number: int, frame: Any) -> Frame:
        """Resolve the way from the last end to a proposed frame, pulled apart if that is wanted."""
        shape = self._positions.shape
        frame = checks.floats("positions", copy_to_cpu("positions", detach(frame)), shape)
        target, pull, tangle = rounded(frame, self._precision), self._pull, None
        if pull is None:
            way = self._walk(target)
        else:
            way = self._pull_apart(pull, target) if pull.tangle.crossings else self._walk(target)
            tangle = pull.tangle_at(way.positions)
            pull.finish(target if way.parts.reached == 1.0 else way.positions, tangle)
        self._last, self._positions = way.end, way.positions
        whole = copy.copy(way.whole)
        whole.positions_t1 = target if whole.copies is None else target[whole.copies]
        return way.parts.frame(number, whole, way.positions, way.last, tangle)

    def _pull_apart(self, pull: Pull, target: Positions) -> _Way:
        """Return a way to a frame, displaced so that contours shrink, that adds no crossing.

        `sequence/pull.py` says how.
        """
        begin, before = self._positions, pull.tangle
        way = self._walk(pull.displaced(begin, before, pull.before, target, 1.0))
        if way.parts.reached == 1.0 and not pull.tangle_at(way.positions).adds_to(before):
            return way
        best = way = self._walk(pull.staying(begin, target))
        least = tangle = pull.tangle_at(way.positions)
        if least.adds_to(before) and not pull.pinned_move(begin, target):
            return self._walk(begin)
        for _ in range(PARTS):
            if way.parts.reached < 1.0 or not tangle.crossings:
                break
            goal = pull.displaced(way.positions, tangle, target, target, 1.0 / PARTS)
            more = self._walk(goal, way)
            if more.parts.reached < 1.0:
                break
            way = more._replace(whole=way.whole, parts=way.parts.followed_by(more.parts))
            tangle = pull.tangle_at(way.positions)
            if not tangle.adds_to(least):
                best, least = way, tangle
        return best

    def _walk(self, target: Positions, after: _Way | None = None) -> _Way:
        """Resolve the way to some positions, in as few substeps as needed.

        Args:
            target: (n, 3) f8 [m], of any precision.
            after: The way from whose end on to go; None for that of the last frame.
        """
        target = rounded(target, self._precision)
        last, begin = (
            (self._last, self._positions) if after is None else (after.end, after.positions)
        )
        positions, whole, parts = begin, self._scene(last, target), Parts()
        size, scene = 1.0, whole
        while True:
            result = resolve(scene, self._thickness, self._device, self._options)
            self._thickness = result.thickness
            end = round_end(scene, result, self._precision, self._device)
            if end.certificate.free:
                last, positions = _End(scene, end), end.positions
                parts.add(result, end, size)
                if parts.reached == 1.0:
                    break
            elif size * self._max_substeps >= 2.0:
                size /= 2.0
            else:
                break
            goal = begin + (parts.reached + size) * (target - begin)
            at_end = parts.reached + size == 1.0
            scene = self._scene(last, target if at_end else rounded(goal, self._precision))
        return _Way(whole, parts, Substep(result, end, size), last, positions)

    def _scene(self, last: _End | None, proposed: Any) -> Scene:
        """Return the step from the last end to proposed positions."""
        if last is None:
            return Scene(self._positions, proposed, *self._mesh, **self._modes)
        return last.scene.after(last, proposed)

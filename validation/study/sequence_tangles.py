"""Starts that are tangled: how many crossings are left after some frames, and whether one is new.

The animation stands still at the tangled start; that of a published step goes to the end of the
step and stands still there. All crossings are counted exactly in each frame.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref import Frame, resolve_sequence
from izo_ref.base.arrays import Edges, Faces, Flags, Masses, Positions
from izo_ref.base.records import Exclusion
from izo_ref.detection.intersections import find_intersections
from izo_ref.scene import edges_of
from validation.rows import Row, Rows
from validation.scenes import tangles
from validation.study import steps
from validation.study.parts import Say
from validation.study.sequence_judges import meeting_by_ipctk, new_rows, unexplained_by_fcl

KEYS = ("scene", "pull_edges", "frame")
COUNTED = (0, 1, 10, 50)  # frames after which crossings are counted for a row
PULLS = (0.0, 1.0)  # of a frame, in median edge lengths; 0 is without it
JUDGED_ALL = 5_000  # triangles up to which each path is judged, and not those of COUNTED alone


class Still(NamedTuple):
    """A tangled start, and where it is proposed to end in all later frames.

    Attributes:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m].
        faces: (m, 3) i4.
        masses: (n,) f8 [kg], or None.
        pinned: (n,) b1, or None.
    """

    start: Positions
    end: Positions
    faces: Faces
    masses: Masses | None
    pinned: Flags | None


def _generated(make: Callable[[], tangles.Tangle]) -> Still:
    found = make()
    start = found.positions_t0
    return Still(start, start, found.faces, found.masses, found.pinned)


def _published() -> Still | None:
    if not (steps.FOLDER / "cloth-ball.npz").is_file():
        return None
    arrays = steps.load("cloth-ball")
    return Still(arrays["positions_t0"], arrays["positions_t1"], arrays["faces"], None, None)


SCENES: dict[str, Callable[[], Still | None]] = {
    "crossed-corner": lambda: _generated(tangles.crossed_corner),
    "crossed-sheets": lambda: _generated(tangles.crossed_sheets),
    "layered-shells": lambda: _generated(tangles.layered_shells),
    "cloth-ball": _published,
}


def can_pull() -> bool:
    """Return whether `resolve_sequence` can pull apart what is tangled."""
    return "pull" in inspect.signature(resolve_sequence).parameters


def tangled(folder: Path, say: Say) -> None:
    """Add the missing rows: a row for each scene, pull and frame of COUNTED."""
    rows = Rows(folder, "tangles", KEYS)
    for name, load in SCENES.items():
        for pull in PULLS:
            if rows.has(scene=name, pull_edges=pull, frame=COUNTED[-1]):
                continue
            if pull and not can_pull():
                say(f"tangles: {name}: left out, resolve_sequence has no pull")
                continue
            still = load()
            if still is None:
                say(f"tangles: {name} is not there; the folder that IZO_DATA names has it")
                break
            for row in tangle_rows(still, pull, COUNTED):
                if not rows.has(scene=name, pull_edges=pull, frame=row["frame"]):
                    rows.add(scene=name, pull_edges=pull, **row)
                say(f"tangles: {name}, {pull}, frame {row['frame']}: {row['crossings']} crossings")


def tangle_rows(still: Still, pull_edges: float, counted: Sequence[int]) -> Iterator[Row]:
    """Yield a row for each frame that is counted.

    Args:
        still: The tangled start.
        pull_edges: The pull of a frame, in median edge lengths.
        counted: Numbers of these frames, the last one at the end.
    """
    edges = edges_of(still.faces)
    length = float(np.median(np.linalg.norm(np.diff(still.start[edges], axis=1), axis=2)))
    frames = (still.start if k == 0 else still.end for k in range(counted[-1] + 1))
    more: dict[str, Any] = {"pull": pull_edges * length} if pull_edges else {}
    resolved = resolve_sequence(frames, still.faces, still.masses, still.pinned, **more)
    judged = range(1, counted[-1] + 1) if len(still.faces) <= JUDGED_ALL else counted
    count = _Count(still, edges, judged)
    for frame in resolved:
        count.add(frame)
        if frame.number in counted:
            yield {"frame": frame.number, "triangles": len(still.faces), **count.row(frame)}


class _Count:
    """The crossings of the frames so far, and what judges say of the paths between them."""

    def __init__(self, still: Still, edges: Edges, judged: Sequence[int]) -> None:
        self._still, self._edges, self._frames = still, edges, judged
        self._crossings = np.empty((0, 5), np.int32)
        self._start, self._n_excluded = still.start, 0
        self._most_new = self._grown = self._excluded_grown = 0
        self._judged = self._met = self._unexplained = 0
        self._unasked = False

    def add(self, frame: Frame) -> None:
        """Count the crossings of a frame, and judge its path."""
        found = find_intersections(frame.positions, self._edges, self._still.faces)
        crossings = np.concatenate((found.crossing_edges, found.crossed_faces), axis=1)
        if frame.number:
            self._most_new = max(self._most_new, new_rows(self._crossings, crossings))
            self._grown = max(self._grown, len(crossings) - len(self._crossings))
            self._excluded_grown = max(self._excluded_grown, frame.excluded - self._n_excluded)
            if frame.number in self._frames:
                self._judge(frame)
        self._crossings, self._n_excluded = crossings, frame.excluded
        self._start = frame.positions

    def _judge(self, frame: Frame) -> None:
        """Ask ipctk about the path and python-fcl about its end, if the path is straight."""
        if frame.substeps != 1 or frame.certificate is None:
            return
        excluded = frame.certificate.excluded
        mesh = self._edges, self._still.faces
        met = meeting_by_ipctk(self._start, frame.positions, *mesh, excluded)
        self._unasked |= met is None
        self._met += met or 0
        self._unexplained += unexplained_by_fcl(frame.positions, *mesh, excluded)
        self._judged += 1

    def row(self, frame: Frame) -> Row:
        """Return what is known after a frame."""
        excluded = None if frame.certificate is None else frame.certificate.excluded
        prescribed = 0
        if excluded is not None:
            prescribed = int(np.count_nonzero(excluded.reasons == Exclusion.PRESCRIBED))
        return {
            "status": frame.status.name,
            "crossings": len(self._crossings),
            "left_out": frame.excluded,
            "prescribed": prescribed,
            "most_new": self._most_new,
            "grown": max(self._grown, 0),
            "left_out_grown": max(self._excluded_grown, 0),
            "judged": self._judged,
            "met_by_ipctk": None if self._unasked else self._met,
            "crossing_by_fcl": self._unexplained,
        }

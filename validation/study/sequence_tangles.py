"""Starts that are tangled: how many crossings are left after some frames, and whether one is new.

Most animations stand still at the tangled start; in one, what is not pinned is proposed to sway.
All crossings are counted exactly in each frame.
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
PULLS = (0.0, 0.5)  # of a frame, in median edge lengths; 0 is without it
SWAY = 0.5  # angle by which what sways goes on in a frame [rad]
JUDGED_ALL = 5_000  # triangles up to which each path is judged, and not those of COUNTED alone


class Start(NamedTuple):
    """A tangled start, and how it is proposed to move.

    Attributes:
        start: (n, 3) f8 [m].
        sway: (n, 3) f8 [m], by which vertices go to and fro.
        faces: (m, 3) i4.
        masses: (n,) f8 [kg], or None.
        pinned: (n,) b1, or None.
    """

    start: Positions
    sway: Positions
    faces: Faces
    masses: Masses | None
    pinned: Flags | None


def generated(make: Callable[[], tangles.Tangle], sway_m: float = 0.0) -> Start:
    """Return a generated start; what is not pinned sways by a distance [m], obliquely."""
    found = make()
    sway = sway_m * np.where(found.pinned, 0.0, 1.0)[:, None] * np.array([0.5, 0.7, 0.5])
    # the level sheet, whose rim is pinned, stands still as a whole
    level = np.arange(len(sway)) <= np.flatnonzero(found.pinned).max(initial=-1)
    sway[level] = 0.0
    return Start(found.positions_t0, sway, found.faces, found.masses, found.pinned)


def _published() -> Start | None:
    if not (steps.FOLDER / "cloth-ball.npz").is_file():
        return None
    arrays = steps.load("cloth-ball")
    start = arrays["positions_t0"]
    return Start(start, np.zeros_like(start), arrays["faces"], None, None)


SCENES: dict[str, Callable[[], Start | None]] = {
    "crossed-corner": lambda: generated(tangles.crossed_corner),
    "crossed-sheets": lambda: generated(tangles.crossed_sheets),
    "swaying-sheets": lambda: generated(tangles.crossed_sheets, 0.05),
    "layered-shells": lambda: generated(tangles.layered_shells),
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
            tangle = load()
            if tangle is None:
                say(f"tangles: {name} is not there; the folder that IZO_DATA names has it")
                break
            for row in tangle_rows(tangle, pull, COUNTED):
                if not rows.has(scene=name, pull_edges=pull, frame=row["frame"]):
                    rows.add(scene=name, pull_edges=pull, **row)
                say(f"tangles: {name}, {pull}, frame {row['frame']}: {row['crossings']} crossings")


def tangle_rows(tangle: Start, pull_edges: float, counted: Sequence[int]) -> Iterator[Row]:
    """Yield a row for each frame that is counted.

    Args:
        tangle: The tangled start.
        pull_edges: The pull of a frame, in median edge lengths.
        counted: Numbers of these frames, the last one at the end.
    """
    edges = edges_of(tangle.faces)
    length = float(np.median(np.linalg.norm(np.diff(tangle.start[edges], axis=1), axis=2)))
    frames = (
        tangle.start + np.sin(SWAY * number) * tangle.sway for number in range(counted[-1] + 1)
    )
    more: dict[str, Any] = {"pull": pull_edges * length} if pull_edges else {}
    resolved = resolve_sequence(frames, tangle.faces, tangle.masses, tangle.pinned, **more)
    judged = range(1, counted[-1] + 1) if len(tangle.faces) <= JUDGED_ALL else counted
    count = _Count(tangle, edges, judged)
    for frame in resolved:
        count.add(frame)
        if frame.number in counted:
            yield {"frame": frame.number, "triangles": len(tangle.faces), **count.row(frame)}


class _Count:
    """The crossings of the frames so far, and what judges say of the paths between them."""

    def __init__(self, tangle: Start, edges: Edges, judged: Sequence[int]) -> None:
        self._faces, self._edges, self._frames = tangle.faces, edges, judged
        self._crossings = np.empty((0, 5), np.int32)
        self._start, self._n_excluded = tangle.start, 0
        self._most_new = self._grown = self._excluded_grown = 0
        self._judged = self._met = self._unexplained = 0
        self._unasked = False

    def add(self, frame: Frame) -> None:
        """Count the crossings of a frame, and judge its path."""
        found = find_intersections(frame.positions, self._edges, self._faces)
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
        mesh = self._edges, self._faces
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

"""The command `izo sequence`: resolve an animation frame by frame, and write it as it was read."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.app.files import check_outputs, save_json
from izo_ref.app.flags import scene_modes
from izo_ref.app.frame_progress import Display, Progress, Tell
from izo_ref.app.kept_frames import KeptFrames, digest_of
from izo_ref.base.arrays import Faces, Flags, Positions
from izo_ref.base.errors import FileFormatError, OptionError, ShapeError
from izo_ref.base.records import Status
from izo_ref.formats.animation import Animation, open_animation, triangles
from izo_ref.sequence.resolve import Frame, resolve_sequence
from izo_ref.version import __version__

SHOWN = 5  # pairs of a blocked frame that its report names
FREE, NOT_FREE, FREE_EXCEPT_EXCLUDED = 0, 1, 3  # exit codes
KEPT = ".frames"  # ending of the folder of kept frames, beside the output


def sequence(args: argparse.Namespace) -> int:
    """Resolve one animation, write it and its report, and say how it ended.

    Args:
        args: What the parser found; `animation` is one path.

    Returns:
        The exit code.
    """
    with Display(args.progress, named=False) as display:
        reports = resolve_file(args, partial(display.tell, str(args.animation)))
    code, lines = ending(reports)
    print(*lines, sep="\n")
    return code


def resolve_file(args: argparse.Namespace, tell: Tell) -> list[dict[str, Any]]:
    """Resolve one animation, and write it and its report.

    Args:
        args: What the parser found; `animation` is one path.
        tell: Is called before the first frame, and after each.

    Returns:
        The report of each frame, as JSON.

    Raises:
        IzoError: The animation, the obstacle or an option is refused, or the output cannot be
            written.
    """
    inputs = {"the animation": args.animation, "--obstacle": args.obstacle}
    if Path(args.animation).is_dir():
        check_outputs(inputs, {"--json": args.json})
        _check_folder(Path(args.animation), Path(args.output))
    else:
        check_outputs(inputs, {"-o": args.output, "--json": args.json})
    scene = _Input(args)
    kept = KeptFrames(f"{args.output}{KEPT}", scene.about())
    done = False
    try:
        reports = [kept.report(number) for number in scene.kept_numbers(kept)]
        impacts = sum(report["impacts"] for report in reports)
        tell(scene.progress(len(reports), impacts))
        for number, frame, seconds in scene.resolve(kept):
            reports.append(_report(frame, seconds))
            kept.write(number, frame.positions, reports[-1])
            impacts += frame.impacts
            tell(scene.progress(len(reports), impacts))
        scene.write(kept)
        if args.json:
            save_json(args.json, {"input": str(args.animation), "frames": reports})
        done = True
    finally:
        kept.close(done)
    return reports


def _check_folder(animation: Path, output: Path) -> None:
    """Raise an error if a folder of frames cannot be the output of another one."""
    if output.resolve() == animation.resolve():
        raise FileFormatError(
            f"{output}: -o is the folder of the animation, which would be lost; name another one"
        )
    if not output.parent.is_dir() or (output.exists() and not output.is_dir()):
        raise FileFormatError(f"{output}: -o: expected a folder, or a new name in a folder")


class _Input:
    """The animation, the obstacle, and what of them is resolved."""

    def __init__(self, args: argparse.Namespace) -> None:
        self._args = args
        self._own: Animation = open_animation(args.animation, args.topology)
        self._obstacle = None if args.obstacle is None else open_animation(args.obstacle)
        self.first, self.last = self._range(args.start, args.stop)
        self._n_own = sum(mesh.n_vertices for mesh in self._own.meshes)
        self._is_exact: bool = getattr(self._own, "is_exact", True)

    def _range(self, start: int | None, stop: int | None) -> tuple[int, int]:
        n = self._own.n_frames
        first, last = 0 if start is None else start, n - 1 if stop is None else stop
        if not 0 <= first <= last < n:
            raise OptionError(
                f"expected --start and --stop from 0 to {n - 1}, the first no larger than the "
                f"second; found {first} and {last}"
            )
        obstacle = self._obstacle
        if obstacle is not None and obstacle.n_frames not in (1, n):
            raise ShapeError(
                f"{obstacle.path}: expected one frame or {n}, as many as {self._own.path} has; "
                f"found {obstacle.n_frames}"
            )
        return first, last

    def about(self) -> dict[str, Any]:
        """Return what the run is about, as JSON."""
        args = self._args
        paths = (args.animation, args.topology, args.obstacle)
        names = ("thickness", "device", "max_substeps", "pull", "initial_intersections")
        return {
            "version": __version__,
            "inputs": digest_of(path for path in paths if path is not None),
            "range": [self.first, self.last],
            "pin": sorted(args.pin),
            **{name: getattr(args, name) for name in (*names, "prescribed", "weld")},
        }

    def _mesh(self) -> tuple[Faces, Flags]:
        """Return the faces, and which vertices are pinned: those of obstacles and named meshes."""
        faces, pinned = [triangles(self._own.meshes)], [np.zeros(self._n_own, bool)]
        names = {mesh.name for mesh in self._own.meshes}
        unknown = sorted(set(self._args.pin) - names)
        if unknown:
            raise OptionError(
                f"--pin: expected names of meshes, which are {', '.join(sorted(names))}; found "
                f"{unknown[0]}"
            )
        for mesh in self._own.meshes:
            if mesh.name in self._args.pin:
                pinned[0][mesh.first : mesh.first + mesh.n_vertices] = True
        if self._obstacle is not None:
            faces.append(triangles(self._obstacle.meshes) + np.int32(self._n_own))
            n = sum(mesh.n_vertices for mesh in self._obstacle.meshes)
            pinned.append(np.ones(n, bool))
        return np.concatenate(faces), np.concatenate(pinned)

    def _frames(self, first: int) -> Iterator[Positions]:
        """Read the frames from a number on, with the obstacle."""
        for number in range(first, self.last + 1):
            own = self._own.frame(number)
            if self._obstacle is not None:
                other = self._obstacle.frame(min(number, self._obstacle.n_frames - 1))
                own = np.concatenate((own, other))
            yield own

    def progress(self, done: int, impacts: int) -> Progress:
        """Return how far the sequence is with so many frames and impacts."""
        frame = self.first + done - 1 if done else None
        return Progress(frame, self.last, done, self.last - self.first + 1, impacts)

    def kept_numbers(self, kept: KeptFrames) -> range:
        """Return the numbers of the frames that an earlier run kept."""
        return range(self.first, self.first + kept.count_from(self.first))

    def resolve(self, kept: KeptFrames) -> Iterator[tuple[int, Frame, float]]:
        """Resolve the frames that are not kept yet; yield number, frame and seconds of each."""
        args, (faces, pinned) = self._args, self._mesh()
        n_kept, thickness = kept.count_from(self.first), args.thickness
        if n_kept == self.last - self.first + 1:
            return
        begin = self.first + max(n_kept - 1, 0)
        frames, proposed = self._frames(begin), None
        if n_kept:
            last = kept.read(begin)
            thickness = last.report["thickness"] or thickness
            frames = _with_first(last.positions, self._frames(begin + 1))
            if args.pull > 0.0 and last.report["reached"] == 1.0:
                proposed = next(self._frames(begin))
        resolved = resolve_sequence(
            frames,
            faces,
            None,
            pinned,
            thickness=thickness,
            device=args.device,
            precision=self._own.precision if self._is_exact else self._as_written,
            max_substeps=args.max_substeps,
            first=begin,
            pull=args.pull,
            first_proposed=proposed,
            **scene_modes(args),
        )
        before = time.perf_counter()
        for frame in resolved:
            now = time.perf_counter()
            if frame.number > begin or not n_kept:
                self._check(frame)
                yield frame.number, frame, now - before
            before = time.perf_counter()

    def _as_written(self, positions: Positions, number: int | None = None) -> Positions:
        """Return what a file with transforms holds of positions; those of obstacles stay."""
        animation: Any = self._own
        own = animation.as_written(
            self.first if number is None else number, positions[: self._n_own]
        )
        return np.concatenate((own, positions[self._n_own :]))

    def _check(self, frame: Frame) -> None:
        """Raise an error if the file cannot hold the positions that were certified."""
        positions = frame.positions
        if self._is_exact or np.array_equal(self._as_written(positions, frame.number), positions):
            return
        raise FileFormatError(
            f"{self._own.path}: frame {frame.number}: the transform of a mesh moves, so that its "
            "rounding differs from frame to frame; apply the transforms to the points first"
        )

    def write(self, kept: KeptFrames) -> None:
        """Write the animation: the frames before the first as they are, then the resolved ones."""

        def frames() -> Iterator[Positions]:
            for number in range(self.first):
                yield self._own.frame(number)
            for number in range(self.first, self.last + 1):
                yield kept.read(number).positions[: self._n_own]

        self._own.write(self._args.output, frames())


def _with_first(positions: Positions, frames: Iterator[Positions]) -> Iterator[Positions]:
    yield positions
    yield from frames


def _report(frame: Frame, seconds: float) -> dict[str, Any]:
    """Return what is said of a frame, as JSON."""
    report: dict[str, Any] = {
        "frame": frame.number,
        "status": frame.status.name,
        "reached": frame.reached,
        "substeps": frame.substeps,
        "impacts": frame.impacts,
        "objective": frame.objective,
        "thickness": None if frame.result is None else frame.result.thickness,
        "excluded": frame.excluded,
        "crossings": frame.crossings,
        "nudged": len(frame.nudged),
        "held": len(frame.held),
        "seconds": round(seconds, 3),
    }
    if frame.meeting is not None:
        rows = zip(
            frame.meeting.nodes.tolist(),
            frame.meeting.is_edge_edge.tolist(),
            frame.meeting_toi.tolist(),
            strict=True,
        )
        report["meeting"] = [
            {"kind": "edge-edge" if kind else "vertex-face", "nodes": nodes, "at": toi}
            for nodes, kind, toi in list(rows)[:SHOWN]
        ]
    return report


def ending(reports: list[dict[str, Any]]) -> tuple[int, list[str]]:
    """Return the exit code of a sequence, and the lines that say how it ended.

    Args:
        reports: The report of each frame.
    """
    blocked = [report for report in reports if report["status"] == Status.BLOCKED.name]
    counts = {status.name: 0 for status in Status}
    for report in reports:
        counts[report["status"]] += 1
    said = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    lines = [f"{len(reports)} frames: {said}"]
    nudged, held = (sum(report[name] > 0 for report in reports) for name in ("nudged", "held"))
    if nudged or held:
        lines.append(f"rounding moved vertices in {nudged} frames, and held some back in {held}")
    excluded = [report["excluded"] for report in reports]
    if excluded[0] or excluded[-1]:
        lines.append(
            f"pairs that are left out: {excluded[0]} at the start, {excluded[-1]} at the end"
        )
    crossings = [report["crossings"] for report in reports]
    if crossings[0]:
        lines.append(
            f"edges that go through faces: {crossings[0]} at the start, {crossings[-1]} at the end"
        )
    for report in blocked:
        first = report["meeting"][0]
        lines.append(
            f"frame {report['frame']} is blocked at {report['reached']:g} of its way: "
            f"{first['kind']} {first['nodes']} meet at {first['at']:.6g}"
        )
    if blocked:
        return NOT_FREE, lines
    return (FREE_EXCEPT_EXCLUDED if excluded[-1] else FREE), lines

"""Animations through every format by the command `izo sequence`: what it writes, and who agrees."""

from __future__ import annotations

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.records import Status
from validation.oracles.animation_files import held
from validation.provenance import ROOT
from validation.rows import Row, Rows
from validation.scenes.animation_files import FORMATS, Written, only, write_animation
from validation.scenes.moving_garment import Moving, Part, moving_garment
from validation.study import steps
from validation.study.parts import Say
from validation.study.sequence_judges import Verdict, judge_frames

KEYS = ("animation", "format")
SEED = 22
KILL_AT = 60  # the frame after which a run is killed; the middle one of a shorter animation
LIBRARIES = {"usd": "pxr", "abc": "alembic3d"}
COMMAND = (sys.executable, "-m", "izo_ref.app.cli", "sequence")
KILLED = -signal.SIGKILL
DATE = re.compile(rb"_ai_DateWritten=[^;]{24}")


def garment() -> Moving:
    """Return the garment of a hundred frames that is inside a moving body from frame 10 on."""
    return moving_garment(np.random.default_rng(SEED), 100, 2000, 2, 0.3)


def sleeve() -> Moving:
    """Return the animation of `data/scenes`."""
    arrays = steps.load("sleeve")
    n_arm = int(arrays["pinned"].sum())
    faces = arrays["faces"]
    own = (faces < n_arm).all(axis=1)
    parts = (
        Part("arm", 0, n_arm, faces[own]),
        Part("cuff", n_arm, len(arrays["pinned"]) - n_arm, faces[~own] - np.int32(n_arm)),
    )
    return Moving(arrays["positions"], parts, ("arm",))


def tshirt() -> Moving | None:
    """Return the published animation of a shirt; None if its file is not there."""
    if not (steps.FOLDER / "tshirt-sequence.npz").is_file():
        return None
    arrays = steps.load("tshirt-sequence")
    n = arrays["positions"].shape[1]
    return Moving(arrays["positions"], (Part("shirt", 0, n, arrays["faces"]),), ())


ANIMATIONS: dict[str, Callable[[], Moving | None]] = {
    "tshirt-sequence": tshirt,
    "sleeve": sleeve,
    "garment": garment,
}


def formats(folder: Path, say: Say) -> None:
    """Add the missing rows: a row for each animation and format."""
    rows = Rows(folder, "formats", KEYS)
    for name, load in ANIMATIONS.items():
        missing = [kind for kind in FORMATS if not rows.has(animation=name, format=kind)]
        moving = load() if missing else None
        if missing and moving is None:
            say(f"formats: {name} is not there; the folder that IZO_DATA names has it")
        judged: dict[str, Verdict] = {}
        for kind in missing if moving is not None else ():
            why = _unreadable(kind)
            if why is not None or moving is None:
                say(f"formats: {name}, {kind}: left out, {why}")
                continue
            with tempfile.TemporaryDirectory(prefix="formats-") as scratch:
                row = format_row(moving, kind, Path(scratch), judged)
            rows.add(animation=name, format=kind, **row)
            say(f"formats: {name}, {kind}: {row['free_paths']} of {row['paths']} paths are free")


def _unreadable(kind: str) -> str | None:
    """Return why a format cannot be written here; None if it can."""
    try:
        __import__(LIBRARIES.get(kind, "numpy"))
    except ImportError as error:
        return str(error)
    return None


def format_row(
    moving: Moving, kind: str, folder: Path, judged: dict[str, Verdict], kill_at: int = KILL_AT
) -> Row:
    """Resolve an animation in a format, kill a second run and let it go on, and judge the file.

    Args:
        moving: The animation.
        kind: One of FORMATS.
        folder: An empty folder.
        judged: The verdicts so far, by a digest of the frames; formats often hold the same ones.
        kill_at: The frame after which the second run is killed, if there are more.
    """
    written = write_animation(folder, kind, moving)
    outputs = [written.path.with_name(f"{name}{written.path.suffix}") for name in ("out", "again")]
    done = _run(written, outputs[0], "--json", folder / "report.json")
    reports = json.loads((folder / "report.json").read_text())["frames"]
    before, after = held(kind, written.path), held(kind, outputs[0])
    frames = _with_others(moving, written, after.positions)
    verdict = _judged(frames, moving, judged)
    still = [report["frame"] for report in reports if report["impacts"] == 0]
    kept = _killed_and_resumed(
        written, outputs[1], kill_at if kill_at < len(reports) - 1 else len(reports) // 2
    )
    return {
        "frames": len(reports),
        "triangles": len(moving.faces),
        "exit_code": done,
        **{status.name: _count(reports, status) for status in Status},
        "impacts": sum(report["impacts"] for report in reports),
        "nudged": sum(report["nudged"] for report in reports),
        "held": sum(report["held"] for report in reports),
        "paths": verdict.paths,
        "free_paths": verdict.certified,
        "free_by_ipctk": verdict.by_ipctk,
        "free_by_fcl": verdict.by_fcl,
        "rest_kept": before.rest == after.rest,
        "still": len(still),
        "still_same": sum(_same_bits(before.positions[k], after.positions[k]) for k in still),
        "killed_after": kept,
        "same_bytes": _digest(outputs[0]) == _digest(outputs[1]),
    }


def _count(reports: Sequence[dict[str, Any]], status: Status) -> int:
    return sum(report["status"] == status.name for report in reports)


def _same_bits(one: Floats, other: Floats) -> bool:
    """Return whether all numbers are equal; both were read by the same reader."""
    return one.tobytes() == other.tobytes()


def _words(written: Written, output: Path, *more: object) -> list[str]:
    return [*COMMAND, str(written.path), "-o", str(output), *written.flags, *map(str, more)]


def _run(written: Written, output: Path, *more: object) -> int:
    """Run the command; return its exit code.

    Raises:
        RuntimeError: It wrote nothing.
    """
    words = _words(written, output, *more)
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    if not output.exists():
        raise RuntimeError(f"{' '.join(words[3:])}: {done.stderr}")
    return done.returncode


def _killed_and_resumed(written: Written, output: Path, kill_at: int) -> int:
    """Kill a run after a frame, and run it again; return how many frames the first one kept.

    Raises:
        RuntimeError: The first run was not killed in time, or left an output.
    """
    words = _words(written, output, "--progress")
    with subprocess.Popen(words, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith(f"frame {kill_at} of "):
                os.kill(process.pid, signal.SIGKILL)
                break
    if process.returncode != KILLED or output.exists():
        raise RuntimeError(f"{' '.join(words[3:])}: was not killed after frame {kill_at}")
    kept = len(list(output.with_name(f"{output.name}.frames").glob("*.npz")))
    _run(written, output)
    return kept


def _with_others(moving: Moving, written: Written, own: Floats) -> Floats:
    """Return the frames of a file, with the parts that are not in it, in the order of all parts."""
    inside = only(moving, list(written.parts)).parts
    columns = {part.name: own[:, part.first : part.first + part.n_vertices] for part in inside}
    for part in moving.parts:
        if part.name not in columns:
            columns[part.name] = moving.positions[:, part.first : part.first + part.n_vertices]
    return np.concatenate([columns[part.name] for part in moving.parts], axis=1)


def _judged(frames: Floats, moving: Moving, judged: dict[str, Verdict]) -> Verdict:
    key = hashlib.sha256(frames.tobytes()).hexdigest()
    if key not in judged:
        judged[key] = judge_frames(frames, moving.faces, moving.pinned_vertices)
    return judged[key]


def _digest(path: Path) -> str:
    """Return a digest of a file, or of the names and contents of the files of a folder.

    The date of writing, which the library of Alembic puts into each file, is left out.
    """
    digest = hashlib.sha256()
    for file in sorted(path.iterdir()) if path.is_dir() else [path]:
        digest.update((file.name if path.is_dir() else "").encode())
        digest.update(DATE.sub(b"", file.read_bytes()))
    return digest.hexdigest()

"""Whether the memory of a sequence grows with its number of frames."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from izo_ref import resolve_sequence
from izo_ref.base.arrays import Positions
from validation.provenance import ROOT
from validation.rows import Row, Rows
from validation.scenes.animation_files import write_npz
from validation.scenes.moving_garment import Moving, moving_garment
from validation.study.parts import Say

KEYS = ("what", "frames")
SEED = 22
FRAMES = 1000
EARLY = 100  # the frame with whose memory that of the last one is compared
TRIANGLES = 1200
# The memory of a process goes up and down by some pages, and the command keeps a report of about a
# kilobyte for each frame. To keep the positions of all frames would take four times this much.
FLAT_MIB = 3.0
COMMAND = (sys.executable, "-m", "izo_ref.app.cli", "sequence")
PROGRAM = "from validation.study import sequence_memory; sequence_memory.print_row({})"


class MemoryGrowsError(RuntimeError):
    """The memory of a sequence grew with its number of frames."""


def memory(folder: Path, say: Say, frames: int = FRAMES, early: int = EARLY) -> None:
    """Add the missing rows: one for `resolve_sequence`, and one for the command.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line of text as the work goes on.
        frames: Number of frames.
        early: The frame with whose memory that of the last one is compared.

    Raises:
        MemoryGrowsError: The last frame has more than FLAT_MIB above the early one.
    """
    if not Path("/proc/self/statm").is_file():
        say("memory: not measured, because the system does not say how much a process has")
        return
    rows = Rows(folder, "memory", KEYS)
    measured = {"resolve_sequence": _of_generator, "izo sequence": _of_command}
    for what, measure in measured.items():
        if rows.has(what=what, frames=frames):
            continue
        row = measure(frames, early)
        rows.add(what=what, frames=frames, **row)
        say(f"memory: {what}: {row['early_mib']:.1f} MiB, then {row['last_mib']:.1f} MiB")
        require_flat(what, row)


def require_flat(what: str, row: Row) -> None:
    """Raise an error if memory grew.

    Raises:
        MemoryGrowsError: The last frame has more than FLAT_MIB above the early one.
    """
    grown = row["last_mib"] - row["early_mib"]
    if grown > FLAT_MIB:
        raise MemoryGrowsError(
            f"{what}: memory grew by {grown:.1f} MiB from frame {row['early']} to the last one; at "
            f"most {FLAT_MIB:g} MiB were expected"
        )


def resident_mib(process: int | str = "self") -> float:
    """Return the memory of a process that is in use [MiB]."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def _frames_of(moving: Moving, n_frames: int) -> Iterator[Positions]:
    """Yield frames, going back and forth through those of an animation."""
    n = len(moving.positions)
    for number in range(n_frames):
        turn = number % (2 * n - 2)
        yield moving.positions[turn if turn < n else 2 * n - 2 - turn].copy()


def _garment() -> Moving:
    return moving_garment(np.random.default_rng(SEED), 40, TRIANGLES, 1, 0.5)


def generator_row(n_frames: int, early: int) -> Row:
    """Resolve a garment in this process, and compare its memory at two frames."""
    moving, found, impacts = _garment(), dict[int, float](), 0
    frames = _frames_of(moving, n_frames)
    for frame in resolve_sequence(frames, moving.faces, None, moving.pinned_vertices):
        impacts += frame.impacts
        if frame.number in (early, n_frames - 1):
            found[frame.number] = resident_mib()
    return _row(moving, early, found, impacts)


def _row(moving: Moving, early: int, found: dict[int, float], impacts: int) -> Row:
    return {
        "triangles": len(moving.faces),
        "early": early,
        "early_mib": found[early],
        "last_mib": found[max(found)],
        "impacts": impacts,
        "frame_kib": moving.positions[0].nbytes / 2**10,
    }


def print_row(arguments: Iterable[int]) -> None:
    """Print the row of this process as JSON."""
    print(json.dumps(generator_row(*arguments)))


def _of_generator(n_frames: int, early: int) -> Row:
    """Measure `resolve_sequence` in a new process, where nothing else takes or gives memory."""
    words = [sys.executable, "-c", PROGRAM.format([n_frames, early])]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])


def _of_command(n_frames: int, early: int) -> Row:
    """Measure the command from outside, as it says which frame it has done."""
    moving = _garment()
    whole = moving._replace(positions=np.array(list(_frames_of(moving, n_frames))))
    with tempfile.TemporaryDirectory(prefix="memory-") as folder:
        path, report = Path(folder) / "in.npz", Path(folder) / "report.json"
        write_npz(path, whole)
        words = [*COMMAND, str(path), "-o", f"{folder}/out.npz", "--progress", "--json"]
        found: dict[int, float] = {}
        with subprocess.Popen(
            [*words, str(report)],
            cwd=ROOT,
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
        ) as process:
            assert process.stderr is not None
            for line in process.stderr:
                words = line.split()
                if words[:1] == ["frame"] and int(words[1]) in (early, n_frames - 2):
                    found[int(words[1])] = resident_mib(process.pid)
        if process.returncode or len(found) < 2:
            raise RuntimeError(f"izo sequence ended with {process.returncode}: {found}")
        impacts = sum(row["impacts"] for row in json.loads(report.read_text())["frames"])
    return _row(whole, early, found, impacts)

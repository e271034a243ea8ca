"""Frames of a sequence that are done, kept in a folder, so that a run can be resumed.

Each frame is an archive that appears whole or not at all. What the run is about (the bytes of the
inputs, the options, the version) is in `run.json`; frames of another run are never mixed in.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.app.files import FilePath, save_text
from izo_ref.base.archives import read_archive
from izo_ref.base.arrays import Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.whole_files import lock, write_whole

RUN = "run.json"
PIECE = 1 << 20  # bytes that are read at once


class Kept(NamedTuple):
    """A frame that was kept."""

    positions: Positions  # (n, 3) f8 [m], all vertices, with obstacles
    report: dict[str, Any]  # what is said of it, as JSON


class KeptFrames:
    """The folder of a run.

    Args:
        folder: Its path; made if it is not there.
        about: What the run is about, as JSON.

    Raises:
        FileFormatError: The folder holds frames of another run, another process works in it, or it
            cannot be written.
    """

    def __init__(self, folder: FilePath, about: dict[str, Any]) -> None:
        """Open the folder, and lock it until `close`."""
        self.folder = Path(folder)
        try:
            self.folder.mkdir(exist_ok=True)
            self._handle = os.open(self.folder, os.O_RDONLY)
        except OSError as error:
            raise FileFormatError(f"{folder}: cannot be used: {error.strerror}") from None
        try:
            self._begin(json.dumps(about, sort_keys=True, indent=1) + "\n")
        except BaseException:
            os.close(self._handle)
            raise

    def _begin(self, about: str) -> None:
        """Lock the folder, and write what the run is about, or compare it."""
        if not lock(self._handle):
            raise FileFormatError(f"{self.folder}: another process resolves this sequence now")
        own = self.folder / RUN
        try:
            if not own.exists() and any(self.folder.iterdir()):
                raise FileFormatError(f"{self.folder}: expected frames of a run, found other files")
            if not own.exists():
                save_text(own, about)
            elif own.read_text(encoding="utf-8") != about:
                raise FileFormatError(
                    f"{self.folder}: holds frames of other inputs or options; delete the folder, "
                    "or run the command that began it"
                )
        except (OSError, UnicodeDecodeError) as error:
            raise FileFormatError(f"{self.folder}: cannot be used: {error}") from None

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:08d}.npz"

    def count_from(self, first: int) -> int:
        """Return how many frames are kept without a gap, from a number on."""
        count = 0
        while self._path(first + count).exists():
            count += 1
        return count

    def read(self, number: int) -> Kept:
        """Read a frame.

        Raises:
            FileFormatError: It is damaged.
        """
        arrays = read_archive(self._path(number), ("positions", "report"))
        return Kept(arrays["positions"], json.loads(str(arrays["report"])))

    def report(self, number: int) -> dict[str, Any]:
        """Read what is said of a frame, without its positions.

        Raises:
            FileFormatError: It is damaged.
        """
        return json.loads(str(read_archive(self._path(number), ("report",))["report"]))

    def write(self, number: int, positions: Positions, report: dict[str, Any]) -> None:
        """Keep a frame.

        Raises:
            FileFormatError: It cannot be written.
        """
        content = io.BytesIO()
        np.savez(content, positions=positions, report=np.array(json.dumps(report)))
        try:
            write_whole(self._path(number), content.getbuffer())
        except OSError as error:
            raise FileFormatError(f"{self._path(number)}: {error.strerror}") from None

    def close(self, done: bool) -> None:
        """Unlock the folder, and delete it if the sequence is written, or no frame is kept."""
        if done or not any(self.folder.glob("*.npz")):
            shutil.rmtree(self.folder)
        os.close(self._handle)


def digest_of(paths: Iterable[FilePath]) -> str:
    """Return a digest of the names and the bytes of files, and of the files in folders.

    Raises:
        FileFormatError: One cannot be read.
    """
    digest = hashlib.sha256()
    for path in map(Path, paths):
        for file in sorted(path.iterdir()) if path.is_dir() else [path]:
            digest.update(repr((file.name, file.is_file())).encode())
            try:
                with open(file, "rb") as content:
                    while piece := content.read(PIECE):
                        digest.update(piece)
            except IsADirectoryError:
                continue
            except OSError as error:
                raise FileFormatError(f"{file}: cannot be read: {error.strerror}") from None
    return digest.hexdigest()

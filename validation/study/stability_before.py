"""Run rungs of the ladders on the core as it was before borders of it were moved.

The core of a commit is unpacked into a temporary folder. The ladders, their judges and this study
are those of today. Only our own outcome counts, since other solvers did not change. Ladders with
rungs of many minutes are left out.
"""

import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from subprocess import PIPE

from validation.ladders.ladder import OWN, Outcome
from validation.ladders.rungs import ladders, rung_text
from validation.provenance import ROOT
from validation.rows import Rows
from validation.study.parts import Say
from validation.study.stability import KEYS

# The last commit before the ladders found faults of the core, which later ones mended.
COMMIT = "9de3844"
BY = f"{OWN} {COMMIT}"
# Families that run on it. Precision and symmetry ask for the vectors of the porting kit, which each
# core looks for beside itself.
CHOSEN = ("stiff", "scale", "geometry", "motion", "contact")
LONGEST_S = 240.0  # ladders with a longer limit of a rung are left out: they take hours [s]


def before_rows(folder: Path, say: Say) -> None:
    """Add the missing rows of the core of COMMIT to `before.csv`.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line of text for each family.
    """
    rows = Rows(folder, "before", KEYS)
    missing = {family: _missing(rows, family) for family in CHOSEN}
    if not any(missing.values()):
        return
    with tempfile.TemporaryDirectory() as core:
        if not _unpack(Path(core)):
            say(f"before: the history here has no commit {COMMIT}, so nothing is measured")
            return
        for family, keys in missing.items():
            if keys:
                _add(rows, family, keys, Path(core))
                say(f"before: {family}: {len(keys)} rungs on the core of {COMMIT}")


def _unpack(core: Path) -> bool:
    """Unpack the core of COMMIT into a folder; return whether the history has the commit."""
    packed = subprocess.run(
        ["git", "archive", COMMIT, "izo_ref"], cwd=ROOT, capture_output=True, check=False
    )
    if packed.returncode:
        return False
    with tarfile.open(fileobj=BytesIO(packed.stdout)) as archive:
        archive.extractall(core, filter="data")
    return True


def _missing(rows: Rows, family: str) -> list[tuple[str, str]]:
    """Return the ladders and rungs of a family that have no row yet."""
    return [
        (ladder.name, rung_text(rung))
        for ladder in ladders(family)
        if ladder.seconds <= LONGEST_S
        for rung in ladder.rungs
        if not rows.has(family=family, ladder=ladder.name, rung=rung_text(rung), by=BY)
    ]


def _add(rows: Rows, family: str, keys: list[tuple[str, str]], core: Path) -> None:
    with _process(family, core) as process:
        questions, answers = process.stdin, process.stdout
        assert questions is not None
        assert answers is not None
        found = Path(answers.readline().strip())
        if core not in found.parents:
            raise RuntimeError(f"expected the core in {core}, but its process imports {found}")
        for name, rung in keys:
            print(json.dumps([name, rung]), file=questions, flush=True)
            outcome = Outcome(*json.loads(answers.readline()))._replace(by=BY)
            rows.add(family=family, ladder=name, rung=rung, **outcome._asdict())


@contextmanager
def _process(family: str, core: Path) -> Iterator["subprocess.Popen[str]"]:
    """Start a process that imports the core of a folder, and everything else from here."""
    # with -m, the folder that a process starts in is searched before PYTHONPATH
    command = [sys.executable, "-m", "validation.ladders.rungs", family]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    environment.pop("PYTHONSAFEPATH", None)
    with subprocess.Popen(
        command, cwd=core, env=environment, stdin=PIPE, stdout=PIPE, text=True
    ) as process:
        yield process

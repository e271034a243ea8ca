"""Commands that are killed leave whole outputs, and a study goes on to the same rows."""

import os
import subprocess
import sys

import numpy as np
import pytest

from tests.helpers.steps import SEED
from validation.provenance import ROOT
from validation.rows import read

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="needs fork, without threads of the system's libraries"
)


def killed_at(moments, folder, seed, only=()):
    """Kill commands in a process of its own, which forks; return the rows."""
    command = [sys.executable, "-m", "validation.machine", "--moments", str(moments)]
    command += ["--seed", str(seed), "-o", str(folder)]
    command += [word for name in only for word in ("--only", name)]
    done = subprocess.run(
        command,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    rows = read(folder, "kills")
    wrong = [row for row in rows if not row["right"]]
    assert (done.returncode, wrong, len(rows)) == (0, [], moments), done.stdout + done.stderr
    return rows


def test_commands_that_are_killed_leave_nothing_half_written(tmp_path):
    only = ("izo resolve", "izo vectors make", "study", "validation guide")
    seed = int(np.random.default_rng(SEED).integers(1 << 30))
    rows = killed_at(8, tmp_path, seed, only)
    assert {row["command"] for row in rows} == set(only)
    assert {row["by"] for row in rows} == {"clock", "call"}
    assert any(row["ended"] == "killed" for row in rows if row["by"] == "call")


@pytest.mark.slow
def test_all_commands_at_200_moments(tmp_path):
    rows = killed_at(200, tmp_path, SEED)
    assert len({row["command"] for row in rows}) == 10

"""Commands that are killed leave whole outputs, and a study goes on to the same rows."""

import numpy as np
import pytest

from tests.helpers.steps import SEED
from validation.rows import read
from validation.study import kills

pytestmark = pytest.mark.skipif(
    not kills.CAN_KILL, reason="needs fork, without threads of the system's libraries"
)


def killed_at(moments, folder, seed, names=kills.NAMES):
    """Kill commands, and return the rows, of which none may be wrong."""
    said = []
    kills.measure(folder, said.append, moments, seed, names)
    rows = read(folder, "kills")
    assert [row for row in rows if not row["right"]] == [], said
    assert [row["number"] for row in rows] == list(range(moments))
    assert len(said) == moments + 1
    return rows


def test_commands_that_are_killed_leave_nothing_half_written(tmp_path):
    names = ("izo resolve", "izo vectors make", "study", "validation guide")
    seed = int(np.random.default_rng(SEED).integers(1 << 30))
    rows = killed_at(8, tmp_path, seed, names)
    assert {row["command"] for row in rows} == set(names)
    assert {row["by"] for row in rows} == {"clock", "call"}
    assert any(row["ended"] == "killed" for row in rows if row["by"] == "call")
    kills.measure(tmp_path, pytest.fail, 8, seed, names)  # nothing is missing


def test_a_process_that_ends_too_early_is_an_error(tmp_path):
    with pytest.raises(RuntimeError, match="their process ended with 1"):
        kills.measure(tmp_path, pytest.fail, 1, SEED, ("no such command",))


@pytest.mark.slow
def test_all_commands_at_200_moments(tmp_path):
    rows = killed_at(200, tmp_path, SEED)
    assert len({row["command"] for row in rows}) == 10

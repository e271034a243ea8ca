"""Judges end: by an answer, or because their time or their memory is used up."""

import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from validation.limits import CAN_LIMIT, Limits, NotDecidedError, limited

pytestmark = pytest.mark.skipif(not CAN_LIMIT, reason="processes cannot be forked here")


def test_an_answer_passes_through():
    found = limited(Limits(), np.multiply, np.arange(3), 2.0)
    assert found.tolist() == [0.0, 2.0, 4.0]
    assert limited(Limits(), sorted, [1, 3, 2], reverse=True) == [3, 2, 1]


def test_an_error_passes_through():
    with pytest.raises(ZeroDivisionError):
        limited(Limits(), divmod, 1, 0)


def test_a_judge_without_end_is_stopped():
    begin = time.monotonic()
    with pytest.raises(NotDecidedError, match=r"more than 0\.3 s"):
        limited(Limits(seconds=0.3), time.sleep, 1000.0)
    assert time.monotonic() - begin < 10.0


def test_a_judge_that_takes_too_much_memory_is_stopped():
    with pytest.raises(NotDecidedError, match=r"more than 0\.25 GiB"):
        limited(Limits(bytes=1 << 28), np.ones, 1 << 27)
    assert len(limited(Limits(bytes=1 << 28), np.ones, 1 << 20)) == 1 << 20


def test_a_judge_that_dies_is_reported():
    with pytest.raises(NotDecidedError, match="its process ended with -6"):
        limited(Limits(), os.abort)


def _print_as_libraries_do():
    return os.write(1, b"out"), os.write(2, b"err")


def test_what_a_judge_prints_belongs_to_no_report(capfd):
    assert limited(Limits(), _print_as_libraries_do) == (3, 3)
    assert tuple(capfd.readouterr()) == ("", "")


def _ask_another(seconds):
    return limited(Limits(), len, "abc") + limited(Limits(seconds=seconds), time.sleep, 1000.0)


def test_a_judge_may_ask_another_judge():
    with pytest.raises(NotDecidedError, match=r"more than 0\.2 s"):
        limited(Limits(), _ask_another, 0.2)


def _sleep_below(path):
    """Run a process below this one that writes its number and sleeps."""
    limited(Limits(), _write_and_sleep, path)


def _write_and_sleep(path):
    path.write_text(str(os.getpid()))
    time.sleep(1000.0)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a signal of Linux")
def test_a_judge_that_is_stopped_takes_those_that_it_asked_along(tmp_path):
    path = tmp_path / "number"
    with pytest.raises(NotDecidedError, match="more than 2 s"):
        limited(Limits(seconds=2.0), _sleep_below, path)
    number = int(path.read_text())
    for _ in range(100):
        state = Path(f"/proc/{number}/stat")
        if not state.exists() or state.read_text().split()[2] == "Z":
            return
        time.sleep(0.1)
    pytest.fail(f"process {number} is still there")

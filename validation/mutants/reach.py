"""A plugin of pytest that notes, for each test, which functions of the package it enters.

It is loaded by `-p validation.mutants.reach` in a process that runs in pure Python, where each
function is a function of Python. The file that the variable REACH names gets one line for each
test, as soon as the test ends: its name, whether it passed, its seconds, and the functions. A test
that takes longer than REACH_LIMIT_S seconds is stopped and counts as failed.
"""

import json
import os
import signal
import sys
import time
from collections.abc import Generator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NoReturn

import pytest

REACH, LIMIT = "REACH", "REACH_LIMIT_S"
ROOT = Path(__file__).resolve().parents[2]
_PACKAGE = f"{ROOT / 'izo_ref'}{os.sep}"


class TooSlow(Exception):
    """A test took longer than the limit."""


PASSED = pytest.StashKey[bool]()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, Any, Any]:
    """Watch the calls while a test and its fixtures run."""
    seen: set[CodeType] = set()

    def watch(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            seen.add(frame.f_code)

    item.stash[PASSED] = True
    begin = time.process_time()
    sys.setprofile(watch)
    try:
        return (yield)
    finally:
        sys.setprofile(None)
        _note(item, time.process_time() - begin, seen)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, Any, Any]:
    """Stop a test at the limit."""
    previous = signal.signal(signal.SIGPROF, _stop)
    signal.setitimer(signal.ITIMER_PROF, float(os.environ.get(LIMIT, "20")))
    try:
        return (yield)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, previous)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, Any]:
    """Note whether each phase of a test passed; a test that was skipped did not."""
    report = yield
    item.stash[PASSED] = item.stash[PASSED] and report.passed
    return report


def _stop(*_: object) -> NoReturn:
    raise TooSlow


def _note(item: pytest.Item, seconds: float, seen: set[CodeType]) -> None:
    """Write the line of a test."""
    entered = {
        f"{code.co_filename.removeprefix(_PACKAGE)}:{code.co_qualname}"
        for code in seen
        if code.co_filename.startswith(_PACKAGE)
    }
    line = {
        "test": item.nodeid,
        "passed": item.stash[PASSED],
        "seconds": round(seconds, 3),
        "entered": sorted(entered),
    }
    with open(os.environ[REACH], "a") as file:
        file.write(json.dumps(line) + "\n")

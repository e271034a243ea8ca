"""The second process, with a format that does what its file says."""

import os
import time

import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats import trial

FORMAT = """
import ctypes, os, time
from izo_ref.base.errors import FileFormatError

class Probe:
    n_frames = 1

    def __init__(self, path):
        with open(path) as file:
            exec(file.read())

    def frame(self, number):
        raise FileFormatError("this is raised again when the frame is read")
"""


@pytest.fixture
def attempt(tmp_path, monkeypatch):
    """Return a function that tries a file with these lines."""
    (tmp_path / "probe_of_trial.py").write_text(FORMAT)
    monkeypatch.syspath_prepend(str(tmp_path))  # the second process has the same path
    trial._stop()

    def run(text):
        path = tmp_path / "file"
        path.write_text(text)
        trial.try_in_child("probe_of_trial", "Probe", path)

    yield run
    trial._stop()


def test_files_that_can_be_read_are_read_by_one_process(attempt, tmp_path):
    for _ in range(3):
        attempt(f"open({str(tmp_path / 'pids')!r}, 'a').write(f'{{os.getpid()}} ')")
    pids = (tmp_path / "pids").read_text().split()
    assert len(pids) == 3
    assert len(set(pids)) == 1
    assert int(pids[0]) != os.getpid()


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("raise FileFormatError('what is wrong')", "what is wrong"),
        ("raise KeyError('inside')", "file: cannot be read: KeyError"),
        ("os.abort()", "file: the library that reads it crashes on it"),
        ("ctypes.string_at(0)", "file: the library that reads it crashes on it"),
        ("bytearray(8 << 30)", "file: reading it takes more memory than its size allows"),
        ("os.write(2, b'warning 7')", "file: cannot be read; its library prints 'warning 7'"),
        ("os.write(1, b'null')", "file: cannot be read; its library prints 'null'"),
    ],
)
def test_what_goes_wrong_there_is_an_error_here(attempt, text, match):
    with pytest.raises(FileFormatError, match=match):
        attempt(text)
    attempt("pass")  # the next file is read, by a new process if the old one died


def test_a_file_that_is_not_read_in_time_is_refused(attempt, monkeypatch):
    monkeypatch.setattr(trial, "SECONDS", 1)
    begin = time.monotonic()
    with pytest.raises(FileFormatError, match="is not read within 1 s"):
        attempt("time.sleep(100)")
    assert time.monotonic() - begin < 20
    monkeypatch.undo()


def test_a_file_that_names_others_may_take_more_memory(attempt):
    attempt("from izo_ref.formats import trial; trial.raise_limit(); bytearray(3 << 30)[0]")

"""Too little memory: a sentence and exit code 2, nothing lost, and no signal of LLVM."""

import os
import re
import subprocess
import sys
import threading

import numba
import numpy as np
import pytest

from izo_ref.app import cli
from izo_ref.app.cli import main
from izo_ref.app.files import save_scene
from izo_ref.app.process import _code_of
from izo_ref.base import callees
from izo_ref.base.compile import compiled, cpu_kernel
from izo_ref.base.threads import _Helpers, _Launch, share
from tests.helpers.shapes import vertex_over_face

LIMITED = """
import os, resource, sys
from izo_ref.app.cli import main
from izo_ref.app.process import run_and_exit
with open("/proc/self/statm") as file:
    used = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
most = used + (int(sys.argv.pop(1)) << 20)
resource.setrlimit(resource.RLIMIT_AS, (most, most))
run_and_exit(main)
"""
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs limits of the address space")


@pytest.fixture
def step(tmp_path):
    """Return the file of a small step."""
    save_scene(tmp_path / "step.npz", vertex_over_face())
    return tmp_path / "step.npz"


@LINUX
@pytest.mark.parametrize(
    "room", [0, 4, 90, *(pytest.param(r, marks=pytest.mark.slow) for r in (1, 2, 8, 16, 33, 300))]
)
def test_little_address_space_is_a_sentence(room, step, tmp_path):
    """Without the checks, 1 to 20 MiB ended by SIGABRT or a traceback.

    With 60 to 100 MiB, the BLAS of scipy waited for ever, if a step has a large zone.
    """
    out = tmp_path / "out.npz"
    out.write_bytes(b"old")
    command = [sys.executable, "-c", LIMITED, str(room), "resolve", str(step), "-o", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert "Traceback" not in done.stderr
    if room >= 300 and done.returncode == 0:
        assert out.read_bytes()[:2] == b"PK"  # it was enough
        return
    assert done.returncode == 2, done.stderr
    # the reader of files says which file it was
    assert re.match("izo: (not enough memory|FileFormatError: .*needs more memory)", done.stderr)
    assert out.read_bytes() == b"old"
    assert sorted(os.listdir(tmp_path)) == ["out.npz", "step.npz"]


@pytest.mark.parametrize("stage", ["load_scene", "resolve", "result_summary", "save_result"])
def test_memory_that_ends_in_any_stage_loses_nothing(stage, step, tmp_path, monkeypatch, capsys):
    def fail(*arguments, **more):
        raise MemoryError("Unable to allocate 8.00 EiB for an array")

    out = tmp_path / "out.npz"
    out.write_bytes(b"old")
    monkeypatch.setattr(cli, stage, fail)
    words = ["resolve", str(step), "-o", str(out), "--json", str(tmp_path / "out.json")]
    assert _code_of(lambda: main(words), "izo") == 2
    said = capsys.readouterr().err
    assert said == "izo: not enough memory: Unable to allocate 8.00 EiB for an array\n"
    assert not (tmp_path / "out.json").exists()
    # the summary is made when the result is safe
    assert (out.read_bytes() == b"old") is (stage != "result_summary")


@compiled
def take(n):
    """Take memory in compiled code."""
    return np.empty(n)[0]


@cpu_kernel
def take_in_parts(begin, end, n, out):
    for i in range(begin, end):
        out[i] = np.empty(n)[0]


@pytest.mark.parametrize("threads", [1, 2])
def test_compiled_code_without_memory_raises_an_error(threads):
    if threads > numba.config.NUMBA_NUM_THREADS:
        pytest.skip("this machine lets numba start one thread only")
    before = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        with pytest.raises(MemoryError):
            take(1 << 58)
        with pytest.raises(MemoryError):
            take_in_parts(range(100), 1 << 58, np.zeros(100))
    finally:
        numba.set_num_threads(before)


def test_llvm_is_not_called_without_room(monkeypatch):
    for name in ("LOADING", "COMPILING", "BLAS"):
        monkeypatch.setattr(callees, name, 1 << 62)

    @compiled
    def one():
        return 1

    with pytest.raises(MemoryError, match="address space"):
        one()
    monkeypatch.undo()
    assert one() == 1  # with room, the same function compiles


def test_a_kernel_runs_without_helpers_that_cannot_start(monkeypatch):
    def refuse(thread):
        raise RuntimeError("can't start new thread")

    times = np.zeros(100, int)

    def count(begin, end, times):
        times[begin:end] += 1

    helpers = _Helpers()
    monkeypatch.setattr(threading.Thread, "start", refuse)
    launch = _Launch(count, (times,), [range(0, 60), range(60, 100)])
    helpers.join(launch, 3)
    launch.work()
    launch.wait()
    assert times.tolist() == [1] * 100


def test_each_error_of_a_thread_comes_back_and_hangs_nothing():
    before = numba.get_num_threads()

    def fail(begin, end):
        raise MemoryError(f"part {begin}")

    numba.set_num_threads(min(2, numba.config.NUMBA_NUM_THREADS))
    try:
        for _ in range(20):
            with pytest.raises(MemoryError, match="part"):
                share(fail, range(50), ())
    finally:
        numba.set_num_threads(before)

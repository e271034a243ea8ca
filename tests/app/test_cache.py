"""Commands that show, fill and clear the compiled code on disk."""

import os
import subprocess
import sys

import pytest

from izo_ref.app import cache
from izo_ref.app.cli import main
from izo_ref.base.errors import CacheFolderError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Make a folder of compiled code, and beside it one of older sources; return the first."""
    for name in ("now", "before"):
        (tmp_path / name / "serial_1").mkdir(parents=True)
        (tmp_path / name / "serial_1" / "dot.nbi").write_bytes(b"12345")
    monkeypatch.setattr(cache, "CACHE_FOLDER", tmp_path / "now")
    return tmp_path / "now"


def test_cache_show_lists_the_folders(folder, capsys):
    assert [(f.path.name, f.current, f.files, f.bytes) for f in cache.folders()] == [
        ("now", True, 1, 5),
        ("before", False, 1, 5),
    ]
    assert main(["cache", "show"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"{folder}: 1 files, 0.0 MB, in use"
    assert said[1].endswith("of other sources or versions")


def test_cache_clear_removes_the_old_folders_or_all(folder, capsys):
    assert main(["cache", "clear", "--old"]) == 0
    assert folder.is_dir()
    assert not folder.with_name("before").exists()
    assert main(["cache", "clear"]) == 0
    assert not folder.exists()
    assert cache.folders() == []


def test_unknown_tasks_are_refused(capsys):
    assert main(["cache", "fill", "nothing"]) == 2
    assert "'nothing'" in capsys.readouterr().err


@pytest.mark.parametrize("name", cache.TASKS)
def test_each_task_runs(name):
    cache.run_task(name)


def test_a_failed_task_raises_an_error_with_its_name(monkeypatch):
    broken = subprocess.Popen([sys.executable, "-c", "raise SystemExit(3)"])
    monkeypatch.setattr(cache, "_start", lambda name: broken)
    with pytest.raises(CacheFolderError, match="detection"):
        cache.fill(["detection"], print)


@pytest.mark.parametrize("compiled", [False, True])
def test_another_process_compiles_only_where_nothing_is_compiled(monkeypatch, compiled):
    started = []

    def start(name):
        started.append(subprocess.Popen([sys.executable, "-c", "pass"]))
        return started[0]

    monkeypatch.setattr(cache, "_start", start)
    monkeypatch.setattr(cache, "anything_compiled", lambda: compiled)
    monkeypatch.setattr(cache.os, "cpu_count", lambda: 2)
    with cache.compiling_beside("small-zones"):
        pass
    assert len(started) == (0 if compiled else 1)
    assert all(process.returncode == 0 for process in started)


@pytest.mark.parametrize("compiled", [False, True])
def test_everything_is_compiled_in_two_processes_where_nothing_is(monkeypatch, compiled):
    here, beside = [], []

    def start(name):
        beside.append(name)
        return subprocess.Popen([sys.executable, "-c", "pass"])

    monkeypatch.setattr(cache, "_start", start)
    monkeypatch.setattr(cache, "run_task", here.append)
    monkeypatch.setattr(cache, "anything_compiled", lambda: compiled)
    monkeypatch.setattr(cache.os, "cpu_count", lambda: 2)
    cache.compile_everything()
    assert (here, beside) == (([], []) if compiled else (["rest"], ["large-zones"]))


LISTED = """
import sys
from numba.core import event
from izo_ref.app.cache import run_task

class Listener(event.Listener):
    def on_start(self, happening):
        python = happening.data["dispatcher"].py_func
        if python.__module__.startswith("izo_ref"):
            print(python.__name__)

    def on_end(self, happening):
        pass

event.register("numba:compile", Listener())
run_task(sys.argv[1])
"""


@pytest.mark.slow
def test_the_two_processes_compile_different_kernels(tmp_path):
    env = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    compiled = []
    for task in ("rest", "large-zones", "rest", "large-zones"):
        command = [sys.executable, "-c", LISTED, task]
        done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
        compiled.append(set(done.stdout.split()))
    assert compiled[2:] == [set(), set()]  # loaded from the disk
    assert {"find_contacts", "solve_small_zones", "decide_meetings"} <= compiled[0]
    assert {"minimum_degree", "factorize", "gram_products", "solve_sweeps"} <= compiled[1]
    assert not compiled[0] & {"minimum_degree", "factorize"}


def test_importing_the_package_imports_neither_numba_nor_numpy():
    code = "import sys, izo_ref; print({'numba', 'numpy', 'scipy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"

"""Compiled code is kept on disk, in a folder named by everything that it was made from."""

import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numba
import pytest

import izo_ref

PACKAGE = Path(izo_ref.__file__).parent


def folder_of(root):
    """Return the name of the cache folder that the package in `root` uses."""
    code = "import izo_ref.base.compile as j; print(j.CACHE_FOLDER.name)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_an_edit_of_any_file_gets_a_folder_of_its_own(tmp_path):
    shutil.copytree(PACKAGE, tmp_path / "izo_ref")
    before = folder_of(tmp_path)
    assert folder_of(tmp_path) == before
    with open(tmp_path / "izo_ref" / "base" / "formulas" / "vec3.py", "a") as file:
        file.write("# a remark\n")
    assert folder_of(tmp_path) != before


def test_numbas_own_cache_folder_is_left_alone():
    assert numba.config.CACHE_DIR == ""


WHO = """
import numpy as np
from numba import get_thread_id, prange
from izo_ref.base.compile import cpu_kernel

@cpu_kernel
def who(out):
    for i in prange(out.shape[0]):
        out[i] = get_thread_id()

ids = np.zeros(1000, np.int64)
for launch in (who, who.alone):
    launch(ids)
    print(len(set(ids)))
"""


def test_a_kernel_on_all_threads_and_one_alone_are_kept_apart(tmp_path):
    (tmp_path / "who.py").write_text(WHO)
    home = {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(PACKAGE.parent)}
    env = os.environ | home | {"NUMBA_NUM_THREADS": "2"}
    for _ in range(2):  # the first run compiles, the second one loads from disk
        done = subprocess.run(
            [sys.executable, "who.py"], cwd=tmp_path, env=env, capture_output=True, text=True
        )
        assert done.stdout.split() == ["2", "1"], done.stderr


TWICE = """
import sys
from izo_ref.base.compile import compiled

@compiled
def twice(x):
    return x + x

print(twice(int(sys.argv[2]) if sys.argv[1] == "int" else float(sys.argv[2])))
print(sum(twice.stats.cache_hits.values()))
"""


def test_processes_that_save_at_the_same_time_write_different_files(tmp_path):
    """The second process does not see the index of the first, which is then written back."""
    (tmp_path / "twice.py").write_text(TWICE)
    home = {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(PACKAGE.parent)}

    def run(*arguments):
        command = [sys.executable, "twice.py", *arguments]
        done = subprocess.run(
            command, cwd=tmp_path, env=os.environ | home, capture_output=True, text=True, check=True
        )
        return done.stdout.split()

    assert run("int", "3") == ["6", "0"]
    (index,) = tmp_path.rglob("*.nbi")
    of_the_first = index.read_bytes()
    index.unlink()
    assert run("float", "3") == ["6.0", "0"]
    index.write_bytes(of_the_first)
    assert run("int", "3") == ["6", "1"]  # from the disk, and for an int


@pytest.mark.skipif(find_spec("numba_cuda") is None, reason="needs numba-cuda: izo-ref[cuda]")
def test_files_of_cuda_kernels_are_named_by_the_process_too():
    code = (
        "from izo_ref.base.cuda.arrays import fill;"
        "print(fill._dispatcher._cache._cache_file._data_name_pattern)"
    )

    def pattern():
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=PACKAGE.parent,
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout.strip()

    assert pattern() != pattern()

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
from izo_ref.base.compile import NEVER_COMPILED

PACKAGE = Path(izo_ref.__file__).parent


def folder_of(root):
    """Return the name of the cache folder that the package in `root` uses."""
    code = "import izo_ref.base.compile as j; print(j.CACHE_FOLDER.name)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_an_edit_of_any_file_that_is_compiled_gets_a_folder_of_its_own(tmp_path):
    shutil.copytree(PACKAGE, tmp_path / "izo_ref")
    before = folder_of(tmp_path)
    for edited, same in (("porting/stages.py", True), ("base/formulas/vec3.py", False)):
        with open(tmp_path / "izo_ref" / edited, "a") as file:
            file.write("# a remark\n")
        assert (folder_of(tmp_path) == before) is same


@pytest.mark.parametrize("folder", NEVER_COMPILED)
def test_folders_whose_edits_do_not_matter_hold_nothing_that_is_compiled(folder):
    for path in (PACKAGE / folder).rglob("*.py"):
        assert "@compiled" not in path.read_text()
        assert "kernel\n" not in path.read_text()


def test_numbas_own_cache_folder_is_left_alone():
    assert numba.config.CACHE_DIR == ""


ADD_ONE = """
from unittest.mock import patch
import numpy as np
from numba.core.cpu import CPUContext
from izo_ref.base.compile import compiled, cpu_kernel

@compiled
def add_one(x):
    return x + 1

@compiled
def add_two(x):
    return add_one(add_one(x))

@cpu_kernel
def add_three(begin, end, out):
    for i in range(begin, end):
        out[i] = add_one(add_two(out[i]))

numbers = np.zeros(1000, np.int64)
declare = CPUContext.load_additional_registries
with patch.object(CPUContext, "load_additional_registries", autospec=True) as declared:
    declared.side_effect = declare
    add_three(range(1000), numbers)
    add_three.alone(range(1, 3), numbers)
print(numbers[:4].tolist(), set(numbers[3:].tolist()))
print(declared.called, add_two(np.float32(0.5)))
"""


def test_a_kernel_is_compiled_once_together_with_what_it_calls(tmp_path):
    (tmp_path / "add_one.py").write_text(ADD_ONE)
    home = {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(PACKAGE.parent)}
    env = os.environ | home | {"NUMBA_NUM_THREADS": "2"}
    for compiles in (True, False):  # the first run compiles, the second one loads from disk
        done = subprocess.run(
            [sys.executable, "add_one.py"], cwd=tmp_path, env=env, capture_output=True, text=True
        )
        assert done.stdout == f"[3, 6, 6, 3] {{3}}\n{compiles} 2.5\n", done.stderr
        names = sorted(path.name.split("-")[0] for path in tmp_path.rglob("*.nbc"))
        assert names == ["add_one.add_three", "add_one.add_two"]


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
        "from izo_ref.base.cuda.arrays import put_rows;"
        "print(put_rows._dispatcher._cache._cache_file._numbered(1))"
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

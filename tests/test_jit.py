"""Compiled code is kept on disk, keyed by everything it was made from."""

import shutil
import subprocess
import sys
from pathlib import Path

import numba

import izo_ref._jit

PACKAGE = Path(izo_ref._jit.__file__).parent


def folder_of(root):
    code = "import izo_ref._jit as j; print(j.CACHE_FOLDER.name)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_an_edit_of_any_file_gets_a_folder_of_its_own(tmp_path):
    shutil.copytree(PACKAGE, tmp_path / "izo_ref")
    before = folder_of(tmp_path)
    assert folder_of(tmp_path) == before
    with open(tmp_path / "izo_ref" / "scalar" / "vec3.py", "a") as file:
        file.write("# a remark\n")
    assert folder_of(tmp_path) != before


def test_numbas_own_cache_folder_is_left_alone():
    assert numba.config.CACHE_DIR == ""

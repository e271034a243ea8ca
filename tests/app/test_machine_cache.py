"""The folder of compiled code: gone, damaged, full, shared, or open to other users."""

import os
import pickle
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from izo_ref.base import kept_code
from izo_ref.base.kept_code import CodeFiles, read_whole
from izo_ref.base.own_folder import make_own, why_unsafe
from tests.helpers.small_module import RIGHT, command, environment, run

OTHER = 65534  # the user nobody
ROOT = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root, to give files away"
)
POSIX = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs owners of files")


@pytest.fixture
def own(tmp_path):
    """Make a folder that is safe whatever the umask is."""
    folder = tmp_path / "own"
    folder.mkdir(mode=0o700)
    return folder


@pytest.fixture
def files(own):
    """Keep the codes of two signatures, and return the files."""
    files = CodeFiles(str(own), "f", b"stamp", pickle.dumps)
    files.save("int", "code of int")
    files.save("float", "code of float")
    return files


def test_a_folder_of_the_user_is_safe(own):
    assert why_unsafe(own) is None
    assert why_unsafe(own / "not" / "there") is None


@POSIX
@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o707, 0o702])
def test_a_folder_that_others_write_to_is_not_safe(own, mode):
    (own / "kept").mkdir(mode=0o700)
    own.chmod(mode)
    assert "other users can write" in str(why_unsafe(own))
    # a sticky folder above lets nobody replace what is the user's
    assert (why_unsafe(own / "kept") is None) is bool(mode & 0o1000)


@POSIX
def test_a_group_may_write_only_if_it_is_the_private_group_of_the_user(own, monkeypatch):
    import grp
    import pwd

    user = pwd.getpwuid(os.geteuid())
    own.chmod(0o770)

    def group_is(name, members):
        answer = grp.struct_group((name, "x", os.stat(own).st_gid, members))
        monkeypatch.setattr(grp, "getgrgid", lambda number: answer)
        monkeypatch.setattr(
            pwd, "getpwuid", lambda number: pwd.struct_passwd((*user[:3], answer.gr_gid, *user[4:]))
        )
        return why_unsafe(own) is None

    assert group_is(user.pw_name, [])
    assert group_is(user.pw_name, [user.pw_name])
    assert not group_is(user.pw_name, ["eve"])
    assert not group_is("staff", [])


@POSIX
def test_links_are_followed_to_where_the_files_are(own, tmp_path):
    away = tmp_path / "away"
    away.mkdir(mode=0o700)
    (own / "link").symlink_to(away)
    (own / "up").symlink_to("../away")
    (own / "circle").symlink_to("circle")
    assert why_unsafe(own / "link" / "kept") is None
    assert why_unsafe(own / "up" / "kept") is None
    away.chmod(0o777)
    assert str(away) in str(why_unsafe(own / "link"))
    assert "away" in str(why_unsafe(own / "up" / "kept"))
    assert "circle" in str(why_unsafe(own / "circle"))


@ROOT
def test_what_belongs_to_another_user_is_not_safe(own):
    (own / "link").symlink_to(own)
    os.lchown(own / "link", OTHER, OTHER)
    assert "another user" in str(why_unsafe(own / "link"))
    os.chown(own, OTHER, OTHER)
    assert "another user" in str(why_unsafe(own / "kept"))


def test_a_file_in_place_of_the_folder_is_not_safe(own):
    (own / "izo_ref").write_text("a file")
    assert "not a folder" in str(why_unsafe(own / "izo_ref" / "kept"))
    with pytest.raises(OSError, match=r"File exists|Not a directory|cannot find"):
        make_own(own / "izo_ref" / "kept")


def test_a_new_folder_is_for_the_user_alone(own):
    before = os.umask(0)
    try:
        make_own(own / "a" / "b")
    finally:
        os.umask(before)
    if hasattr(os, "geteuid"):
        assert (own / "a").stat().st_mode & 0o777 == (own / "a" / "b").stat().st_mode & 0o777
        assert (own / "a").stat().st_mode & 0o077 == 0


def test_kept_code_comes_back(files, own):
    again = CodeFiles(str(own), "f", b"stamp", pickle.dumps)
    assert (again.load("int"), again.load("float")) == ("code of int", "code of float")
    assert again.load("str") is None
    assert CodeFiles(str(own), "f", b"edited", pickle.dumps).load("int") is None
    assert sorted(path.suffix for path in own.iterdir()) == [".nbc", ".nbc", ".nbi"]


def test_a_flipped_bit_in_each_byte_and_every_cut_is_noticed(files, own, rng):
    """Of the index and of the code: nothing but the truth is loaded."""
    for path in sorted(own.iterdir()):
        whole = path.read_bytes()
        for bit in 8 * np.arange(len(whole)) + rng.integers(8, size=len(whole)):
            damaged = bytearray(whole)
            damaged[bit // 8] ^= 1 << bit % 8
            path.write_bytes(damaged)
            assert read_whole(path) is None, (path.name, bit)
        for length in range(len(whole)):
            path.write_bytes(whole[:length])
            assert read_whole(path) is None, (path.name, length)
        path.write_bytes(whole)
    assert files.load("int") == "code of int"


def test_a_file_that_stands_for_another_one_is_noticed(files, own):
    one, other = sorted(own.glob("*.nbc"))
    shutil.copy(one, other)
    assert read_whole(one) is not None
    assert read_whole(other) is None


def test_damaged_code_is_kept_again(files, own):
    for path in own.iterdir():
        path.write_bytes(b"")
    assert files.load("int") is None
    files.save("int", "new code")
    assert files.load("int") == "new code"


@POSIX
def test_a_file_that_others_can_write_to_is_not_loaded(files, own):
    for path in own.glob("*.nbc"):
        path.chmod(0o666)
    assert files.load("int") is None
    files.save("int", "new code")  # which takes the place of the file, with its own permissions
    assert files.load("int") == "new code"


@ROOT
def test_a_file_of_another_user_is_not_loaded(files, own):
    (index,) = own.glob("*.nbi")
    os.chown(index, OTHER, OTHER)
    assert files.load("int") is None


@POSIX
def test_a_pipe_or_a_link_in_place_of_a_file_is_not_loaded(files, own):
    (index,) = own.glob("*.nbi")
    index.rename(own / "elsewhere")
    index.symlink_to(own / "elsewhere")
    assert files.load("int") is None
    index.unlink()
    os.mkfifo(index)
    assert files.load("int") is None  # and it does not wait for a writer


def test_a_write_that_fails_is_said_once_and_is_no_error(files, own, monkeypatch, capsys):
    monkeypatch.setattr(kept_code, "_said", set())

    def full(path, content, mode):
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(kept_code, "replace_whole", full)
    files.save("str", "code")
    files.save("bytes", "code")
    assert capsys.readouterr().err.count("No space left on device") == 1


@pytest.fixture
def filled(tmp_path, own):
    """Compile the small module into a cache; return its folder."""
    assert run(tmp_path, own)[:2] == (RIGHT, 0)
    return own


def test_code_is_compiled_again_if_its_files_are_damaged(filled, tmp_path, rng):
    assert run(tmp_path, filled) == (RIGHT, 2, "")
    for path in filled.rglob("*.nb?"):
        damaged = bytearray(path.read_bytes())
        damaged[rng.integers(len(damaged))] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
    assert run(tmp_path, filled) == (RIGHT, 0, "")
    assert run(tmp_path, filled) == (RIGHT, 2, "")  # the damaged files were replaced


@POSIX
def test_code_is_neither_loaded_nor_kept_in_an_open_folder(filled, tmp_path):
    filled.chmod(0o777)
    before = sorted(filled.rglob("*"))
    said, loaded, errors = run(tmp_path, filled)
    assert (said, loaded) == (RIGHT, 0)
    assert errors.count("\n") == 1
    assert f"other users can write to {filled}" in errors
    assert "XDG_CACHE_HOME" in errors
    assert sorted(filled.rglob("*")) == before
    assert not list(tmp_path.rglob("__pycache__/*.nb?"))  # where numba would keep it


@POSIX
@pytest.mark.parametrize("place", ["file", "gone", "read-only"])
def test_code_runs_without_a_folder_to_keep_it(place, tmp_path):
    folder = tmp_path / place
    if place == "file":
        folder.write_text("a file")
    elif place == "gone":
        folder = Path("/proc/none")  # nobody can create it
    elif os.geteuid() == 0:
        folder = Path("/sys")  # where root cannot write either
    else:
        folder.mkdir(mode=0o500)
    said, loaded, errors = run(tmp_path, folder)
    assert (said, loaded) == (RIGHT, 0)
    assert "compiled code is not kept" in errors
    assert errors.count("\n") == 1


def test_processes_that_compile_at_once_share_a_folder(tmp_path, own):
    together = [
        subprocess.Popen(
            command(tmp_path),
            env=environment(own),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(3)
    ]
    for process in together:
        said, errors = process.communicate(timeout=120)
        assert (process.returncode, said.split()[:-1], errors) == (0, RIGHT, "")
    said, loaded, errors = run(tmp_path, own)
    assert (said, errors) == (RIGHT, "")
    assert loaded >= 1  # an entry of an index may be lost, and is compiled again
    assert not list(own.rglob("*.unfinished"))


def test_checking_takes_little_time(tmp_path):
    """1,000 files of 50 kB, as a bound on what goes wrong by orders: 5 s at 5 ms a file."""
    path = tmp_path / "f"
    content = np.arange(6250.0).tobytes()
    path.write_bytes(kept_code._digest("f", content) + content)
    begin = time.perf_counter()
    for _ in range(1000):
        assert read_whole(path) == content
    assert time.perf_counter() - begin < 5.0

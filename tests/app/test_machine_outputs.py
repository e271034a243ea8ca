"""Outputs on a machine that refuses: full disks, odd targets, closed outputs, kills."""

import errno
import io
import os
import signal
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from izo_ref.app import files, process
from izo_ref.app.cli import main
from izo_ref.app.files import check_outputs, make_folder, save_json, save_scene
from izo_ref.base import whole_files, whole_folder
from izo_ref.base.errors import FileFormatError, VectorsError
from izo_ref.base.whole_files import leftovers, write_whole
from izo_ref.porting.generate.build import write_folder
from izo_ref.porting.trace_files import TraceFolder
from tests.helpers.shapes import vertex_over_face
from validation import rows
from validation.__main__ import main as validation_main

POSIX = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs devices, pipes and fork")


def writes_everywhere():
    """Return whether this process may write where the permissions of files say no, as root may."""
    with tempfile.NamedTemporaryFile() as file:
        os.chmod(file.name, 0o400)
        return os.access(file.name, os.W_OK)


NOT_ROOT = pytest.mark.skipif(writes_everywhere(), reason="root may write everywhere")
OLD, NEW = b"the old content", b"the new content, which is longer"


@pytest.fixture
def old(tmp_path):
    """Return a file with the old content, alone in its folder."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "out.npz").write_bytes(OLD)
    return tmp_path / "folder" / "out.npz"


@pytest.fixture
def step(tmp_path):
    """Return the file of a small step."""
    save_scene(tmp_path / "step.npz", vertex_over_face())
    return tmp_path / "step.npz"


def is_as_it_was(old):
    """Return whether the old file is there with its content, and nothing else."""
    return old.read_bytes() == OLD and os.listdir(old.parent) == [old.name]


@pytest.mark.parametrize("at", range(len(NEW)))
def test_a_disk_that_is_full_at_any_byte_leaves_the_old_file(at, old, monkeypatch):
    true_write, written = os.write, []

    def write(handle, content):
        room = at - sum(written)
        if room == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        written.append(true_write(handle, content[: min(room, 7)]))
        return written[-1]

    monkeypatch.setattr(whole_files.os, "write", write)
    with pytest.raises(OSError, match="No space"):
        write_whole(old, NEW)
    monkeypatch.undo()
    assert is_as_it_was(old)


@pytest.mark.parametrize("call", ["open", "write", "fchmod", "fsync", "replace"])
@pytest.mark.parametrize("error", [OSError(errno.EIO, "bad disk"), KeyboardInterrupt, MemoryError])
def test_any_call_that_fails_leaves_the_old_file(call, error, old, monkeypatch):
    def fail(*arguments, **more):
        raise error

    monkeypatch.setattr(whole_files.os, call, fail)
    with pytest.raises((OSError, KeyboardInterrupt, MemoryError)):
        write_whole(old, NEW)
    monkeypatch.undo()
    assert is_as_it_was(old)


CALLS = ("open", "write", "fchmod", "fsync", "replace", "close", "fstat", "mkdir", "rename")


def dies_at(number, work):
    """Run work in a child that is killed before its `number`-th call of the system.

    Returns:
        Whether the child was killed; else it made fewer calls.
    """
    child = os.fork()
    if child == 0:
        made = []

        def counted(true_call):
            def call(*arguments, **more):
                made.append(1)
                if len(made) == number:
                    os.kill(os.getpid(), signal.SIGKILL)
                return true_call(*arguments, **more)

            return call

        for name in CALLS:
            setattr(os, name, counted(getattr(os, name)))
        try:
            work()
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


@POSIX
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_process_that_is_killed_at_any_call_leaves_the_old_or_the_new_file(old):
    most = number = 0
    while dies_at(number := number + 1, lambda: write_whole(old, NEW)):
        assert old.read_bytes() in (OLD, NEW)
        most = max(most, len(leftovers(old)))
        write_whole(old, OLD)
        assert is_as_it_was(old)  # what was left is gone
    assert number > 6
    assert most == 1


@POSIX
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_process_that_is_killed_at_any_call_leaves_the_old_or_the_new_folder(tmp_path):
    folder, contents = tmp_path / "vectors", [{"a": b"1", "b": b"2"}, {"a": b"3", "c": b"4"}]

    def held():
        return {path.name: path.read_bytes() for path in folder.iterdir()}

    whole_folder.replace_folder(contents[0], folder)
    number = 0
    while dies_at(number := number + 1, lambda: whole_folder.replace_folder(contents[1], folder)):
        assert held() in contents
        assert len(leftovers(folder)) <= 1
        whole_folder.replace_folder(contents[0], folder)
        assert os.listdir(tmp_path) == ["vectors"]
    assert number > 10


def test_folders_are_exchanged_where_the_system_needs_two_steps(tmp_path, monkeypatch):
    monkeypatch.setattr(whole_folder, "_exchange_at_once", lambda one, other: False)
    for content in ({"a": b"1"}, {"b": b"2"}):
        whole_folder.replace_folder(content, tmp_path / "vectors")
        held = {path.name: path.read_bytes() for path in (tmp_path / "vectors").iterdir()}
        assert held == content
    assert os.listdir(tmp_path) == ["vectors"]


@POSIX
def test_what_a_living_process_writes_is_no_leftover(old):
    handle, new = whole_files._open_new(str(old))
    write_whole(old, NEW)
    assert leftovers(old) == [new]
    os.close(handle)
    write_whole(old, NEW)
    assert leftovers(old) == []


def test_files_of_like_names_are_no_leftovers(old):
    for name in (".out.npz.mine.unfinished", ".out.npz.0123abcd.unfinished.txt", "out.npz.bak"):
        (old.parent / name).write_bytes(b"keep")
    write_whole(old, NEW)
    assert len(os.listdir(old.parent)) == 4


@POSIX
def test_a_file_keeps_its_permissions_and_a_new_one_gets_the_usual_ones(old):
    old.chmod(0o600)
    write_whole(old, NEW)
    assert stat.S_IMODE(old.stat().st_mode) == 0o600
    before = os.umask(0o027)
    try:
        write_whole(old.with_name("new"), NEW)
    finally:
        os.umask(before)
    assert stat.S_IMODE(old.with_name("new").stat().st_mode) == 0o640


@POSIX
def test_a_link_is_followed(old, step):
    link = old.parent.parent / "link.npz"
    link.symlink_to(old)
    assert main(["resolve", str(step), "-o", str(link)]) == 0
    assert link.is_symlink()
    assert files.load_result(old).thickness is not None
    link.unlink()
    link.symlink_to(old.parent / "later.npz")  # there is none yet
    assert main(["resolve", str(step), "-o", str(link)]) == 0
    assert link.is_symlink()
    assert (old.parent / "later.npz").is_file()


@POSIX
def test_a_pipe_or_a_device_stays_what_it_is(step, tmp_path):
    """As root, `-o /dev/null` replaced the device of the whole machine by a file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE) as reader:
        assert main(["certify", str(step), "--json", str(pipe)]) == 1
        assert b'"free": false' in reader.communicate()[0]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert main(["resolve", str(step), "-o", os.devnull, "--json", os.devnull]) == 0
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("folder", "it is a folder"),
        ("none/out.npz", "there is no folder"),
        ("link.npz", "there is no folder"),
        ("step.npz", "which would be lost"),
        ("same.npz", "which would be lost"),
        ("step.npz/out", "there is no folder"),
        ("o" * 300, "too long"),
        pytest.param("read-only.npz", "read-only", marks=NOT_ROOT),
        pytest.param("closed/out.npz", "no permission", marks=NOT_ROOT),
    ],
)
@pytest.mark.parametrize("command", ["resolve", "certify", "check"])
def test_targets_that_cannot_be_written_are_refused_before_the_work(
    command, target, words, step, tmp_path, capsys
):
    for folder in ("folder", "closed"):
        (tmp_path / folder).mkdir()
    (tmp_path / "closed").chmod(0o500)
    (tmp_path / "read-only.npz").touch(0o400)
    (tmp_path / "link.npz").symlink_to(tmp_path / "none" / "out.npz")
    (tmp_path / "same.npz").symlink_to(step)
    before = step.read_bytes()
    flag, run = ("-o", main) if command == "resolve" else ("--json", main)
    run = validation_main if command == "check" else run
    assert run([command, str(step), flag, str(tmp_path / target)]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert step.read_bytes() == before


def test_a_demo_without_a_folder_is_refused_before_the_work(tmp_path, capsys):
    (tmp_path / "file").touch()
    for target in ("file", "file/below"):
        assert main(["demo", "-o", str(tmp_path / target)]) == 2
    assert "expected a folder, found a file" in capsys.readouterr().err
    with pytest.raises(FileFormatError, match="cannot be created"):
        make_folder("/proc/none")


@pytest.fixture
def full(monkeypatch, step, old):
    """Let the disk be full for everything that is written whole."""

    def write(handle, content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(whole_files.os, "write", write)
    yield
    monkeypatch.undo()


def test_a_full_disk_is_a_sentence_for_each_command(full, old, step, capsys):
    out = str(old)
    for run, words in (
        (main, ["resolve", str(step), "-o", out]),
        (main, ["resolve", str(step), "-o", str(old.parent / "o"), "--trace", f"{old.parent}.d"]),
        (main, ["certify", str(step), "--json", out]),
        (main, ["plan", str(step), "--json", out]),
        (main, ["view", str(step), "-o", out]),
        (validation_main, ["check", str(step), "--json", out]),
        (validation_main, ["check", str(step), "--html", out]),
        (main, ["conform", "--exec", "false", "--case", "S9-zero-01", "--json", out]),
    ):
        code = run(words)
        said = capsys.readouterr().err
        assert code == 2, words
        assert "No space left on device" in said or "no case" in said
    assert is_as_it_was(old)
    with pytest.raises(VectorsError, match="No space"):
        write_folder({"a": b"1"}, old.parent.parent / "vectors")
    with pytest.raises(FileFormatError, match="No space"):
        TraceFolder(old.parent / "trace").write("scene", thickness=1.0)
    with pytest.raises(FileFormatError, match="No space"):
        save_json(old, {})


@POSIX
def test_a_row_that_does_not_fit_is_taken_back(tmp_path):
    """With a limit of the system on the size of files, which is a full disk for this process."""
    import resource

    table = rows.Rows(tmp_path, "study", ["case"])
    table.add(case="first", value=1.0)
    before = table.path.read_bytes()
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    old_handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 4, limit[1]))
    try:
        with pytest.raises(OSError, match="large"):
            table.add(case="second", value=2.0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        signal.signal(signal.SIGXFSZ, old_handler)
    assert table.path.read_bytes() == before
    table.add(case="third", value=3.0)
    assert [row["case"] for row in rows.Rows(tmp_path, "study", ["case"]).all()] == [
        "first",
        "third",
    ]


def test_a_run_whose_first_line_was_cut_off_gets_one_head(tmp_path):
    """A process that was killed between the head and the first run of `runs.csv`."""
    (tmp_path / "runs.csv").write_text(",".join(rows.RUN_COLUMNS) + "\n")
    assert rows.begin_run(tmp_path, "command", False) == 1
    assert rows.begin_run(tmp_path, "command", False) == 1
    assert [run["run"] for run in rows.runs(tmp_path)] == [1]


def test_two_outputs_may_be_the_null_device():
    check_outputs({}, {"-o": os.devnull, "--json": os.devnull})


class Full(io.StringIO):
    """An output to a disk that is full."""

    def write(self, text):
        """Refuse."""
        raise OSError(errno.ENOSPC, "No space left on device")


def test_errors_of_the_machine_are_sentences(monkeypatch, capsys):
    def fails(error):
        def run():
            raise error

        code = process._code_of(run, "izo")
        return code, capsys.readouterr().err

    assert fails(MemoryError()) == (2, "izo: not enough memory\n")
    assert fails(MemoryError("no room")) == (2, "izo: not enough memory: no room\n")
    assert fails(PermissionError(13, "denied", "f")) == (2, "izo: f: denied\n")
    code, said = fails(OSError(errno.ENOSPC, "full"))
    assert (code, said) == (2, "izo: the standard output cannot be written: full\n")
    monkeypatch.setattr(sys, "stdout", Full())
    assert process._code_of(lambda: print("text") or 0, "izo") == 2
    assert "the standard output cannot be written" in capsys.readouterr().err


COMMAND = "import sys; from izo_ref.app.cli import entry; entry()"


@POSIX
@pytest.mark.parametrize(
    ("ending", "code", "words"),
    [
        ("> /dev/full", 2, "the standard output cannot be written: No space left on device"),
        (">&-", 0, ""),
        (">&- 2>&- <&-", 0, ""),
        ("| head -c 0", 141, ""),
        ("2> /dev/full --no-such-flag", 2, ""),
    ],
)
def test_odd_outputs_of_a_process(ending, code, words, tmp_path):
    """A command that needs no compiled code; a file that it writes gets nothing that it prints."""
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full, the output that is always full")
    picture = tmp_path / "case.svg"
    case = "S7-kink-01"
    words_of_command = f'"{sys.executable}" -c "{COMMAND}" vectors show {case} --picture {picture}'
    line = f"set -o pipefail; {words_of_command} {ending}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    if "flag" not in ending:
        assert picture.read_text().startswith("<svg")
        assert "grade" not in picture.read_text()


def test_a_report_is_not_written_to_an_output_that_is_closed(monkeypatch, capsys):
    monkeypatch.setattr(process, "_closed", {"stdout"})
    assert main(["conform", "--exec", "true", "--json", "-"]) == 2
    assert "the standard output is closed; name a file" in capsys.readouterr().err

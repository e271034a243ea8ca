"""Texts and paths of every other reader: vectors, replies, known failures, traces, rows."""

import json
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from izo_ref.app.files import load_result, load_scene
from izo_ref.porting.cases import Case
from izo_ref.porting.conform.folder import REPLIES, REQUESTS, judge_folder
from izo_ref.porting.conform.known import compare, known_text, read_known
from izo_ref.porting.conform.protocol import GREETING, Request, line_of, request_line
from izo_ref.porting.conform.report import Report
from izo_ref.porting.conform.right import right_reply
from izo_ref.porting.conform.run import Choice
from izo_ref.porting.conform.terminal import report_text
from izo_ref.porting.files import CHECKOUT, load_cases, wrong_files
from izo_ref.porting.stages import STAGES
from izo_ref.porting.trace_files import load_arrays, load_index
from validation import json_rows
from validation.fuzz.archive_bytes import array_bytes, members_of, zip_bytes
from validation.fuzz.archives import STEP
from validation.fuzz.arrays import Rng
from validation.fuzz.trial import Trial, Wrong
from validation.rows import Rows, read, runs

STAGE_NAMES = tuple(stage.name for stage in STAGES)
CHEAP = ("S9", "S7", "S2")  # stages of small replies
JSON = (
    "null",
    "true",
    "0",
    "-1",
    "1e999",
    "-1e999",
    "NaN",
    "9" * 400,
    "9" * 5000,
    "0.1",
    '""',
    '"nan"',
    '"0x1p+99999"',
    '"0x1p+999999999"',
    '"\\ud800"',
    '"\\u0000"',
    '"../../../../etc/passwd"',
    '"/dev/zero"',
    "[]",
    "{}",
    "[[]]",
    '{"npy":5}',
    '{"npy":"/dev/zero"}',
    '{"npy":"../S1.json"}',
    '{"npy":""}',
    "[" * 2000 + "]" * 2000,
    "[" * 200_000,
    '"' + "x" * 5000 + '"',
)


def broken_text(rng: Rng, content: bytes) -> bytes:
    """Return a text of JSON, CSV or words with some of it replaced."""
    out = bytearray(content)
    for _ in range(rng.integers(1, 4)):
        kind, size = rng.integers(7), max(len(out), 1)
        at = int(rng.integers(size))
        if kind <= 2:  # a value of JSON in the place of another one
            begin = max(out.rfind(mark, 0, at) for mark in (b":", b",", b"["))
            ends = [e for e in (out.find(m, begin + 1) for m in (b",", b"}", b"]")) if e > 0]
            stop = min(ends, default=size)
            out[begin + 1 : stop] = JSON[rng.integers(len(JSON))].encode()
        elif kind == 3 and len(out):
            out[at % len(out)] ^= 1 << rng.integers(8)
        elif kind == 4:
            del out[at:]
        elif kind == 5:
            out[at:at] = rng.bytes(int(rng.integers(8)))
        else:
            stop = at + int(rng.integers(200))
            out[at:at] = out[at:stop]
    return bytes(out)


@cache
def _vectors(stage: str) -> tuple[bytes, tuple[Case, ...]]:
    """Return a few cases of a stage, and the file that has them."""
    lines = (CHECKOUT / f"{stage}.json").read_text().splitlines()
    few = [line for line in lines[1:-1] if len(line) < 3000 and '"npy"' not in line][:3]
    text = "\n".join([lines[0], ",\n".join(line.rstrip(",") for line in few), lines[-1]])
    return text.encode(), tuple(load_cases(stages=[stage]))


def vectors_trial(rng: Rng, folder: Path) -> Trial:
    """Return a damaged file of vectors."""
    stage = STAGE_NAMES[rng.integers(len(STAGE_NAMES))]
    content = broken_text(rng, _vectors(stage)[0])
    (folder / f"{stage}.json").write_bytes(content)
    call: Callable[[], Any] = lambda: load_cases(folder, [stage])  # noqa: E731
    return Trial(call, None, lambda _: "", f"vectors {stage} {content[-200:]!r}")


def sums_trial(rng: Rng, folder: Path) -> Trial:
    """Return a damaged list of sums."""
    (folder / "a.json").write_bytes(b"{}")
    lines = b"".join(b"%064x  %s\n" % (i, n) for i, n in enumerate((b"a.json", b"b.npy", b"c")))
    if rng.random() < 0.2:
        lines += b"0" * 64 + b"  ../../../dev/zero\n"
    (folder / "SHA256SUMS").write_bytes(broken_text(rng, lines))
    return Trial(lambda: wrong_files(folder), None, lambda _: "", "sums")


def replies_trial(rng: Rng, folder: Path) -> Trial:
    """Return a folder with requests, and damaged requests or replies to them."""
    stage = CHEAP[rng.integers(len(CHEAP))]
    cases = [case for case in _vectors(stage)[1] if case.verdict == "valid"]
    chosen = [cases[i] for i in rng.choice(len(cases), 3, replace=False)]
    requests = [Request(case, "f8") for case in chosen if "f8" in case.dtypes]
    asked = line_of(GREETING) + b"".join(map(request_line, requests))
    hello = {"name": "p", "version": "1", "stages": [stage], "dtypes": ["f8"]}
    lines = [json.dumps(hello).encode() + b"\n"]
    for request in requests:
        reply = {"id": request.case.id, **(right_reply(request.case) or {})}
        lines.append(json.dumps(reply).encode() + b"\n")
    answered = b"".join(lines)
    if rng.random() < 0.2:
        asked = broken_text(rng, asked)
    else:
        answered = broken_text(rng, answered)
    (folder / REQUESTS).write_bytes(asked)
    (folder / REPLIES).write_bytes(answered)

    def call() -> Any:
        run = judge_folder(folder, cases, Choice())
        known = known_text(run.rows)
        path = folder / "known.txt"
        path.write_text(known)
        listed = read_known(path, {case.id for case in cases})
        return report_text(Report(run, compare(run.rows, listed)))

    return Trial(call, None, lambda text: "" if text.strip() else "an empty report", "replies")


def known_trial(rng: Rng, folder: Path) -> Trial:
    """Return a damaged file of known failures."""
    path = folder / "known.txt"
    path.write_bytes(broken_text(rng, b"# head\nS9-a-01 f8 multipliers  # why\nS9-a-01 f4 x\n"))
    return Trial(lambda: read_known(path, {"S9-a-01"}), None, lambda _: "", "known failures")


def index_trial(rng: Rng, folder: Path) -> Trial:
    """Return a damaged index of a trace."""
    index = {
        "trace": 1,
        "scene": {"initial_intersections": "raise", "prescribed": "exclude", "weld": None},
        "iterations": [{"folder": "iteration-0001", "kind": "detect", "selection": "all"}],
    }
    (folder / "index.json").write_bytes(broken_text(rng, json.dumps(index).encode()))
    return Trial(lambda: load_index(folder), None, lambda _: "", "index")


@cache
def _rows() -> dict[str, bytes]:
    """Return the files of the rows of a study, by name."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Rows(folder, "study", ("name", "size"))
        rows.add(name="a", size=1, seconds=0.5)
        rows.add(name='b"c', size=2, seconds=None, outcome="failed")
        return {name: (Path(folder) / f"{name}.csv").read_bytes() for name in ("study", "runs")}


def rows_trial(rng: Rng, folder: Path) -> Trial:
    """Return damaged rows of a study."""
    for name, content in _rows().items():
        is_damaged = name == "study" or rng.random() < 0.3
        path = folder / f"{name}.csv"
        path.write_bytes(broken_text(rng, content) if is_damaged else content)

    def call() -> Any:
        again = Rows(folder, "study", ("name", "size"))
        return again.all(), read(folder, "study"), runs(folder)

    return Trial(call, None, lambda _: "", "rows")


def json_rows_trial(rng: Rng, folder: Path) -> Trial:
    """Return damaged rows in JSON."""
    path = folder / "rows.json"
    made = {"command": "c", "commit": "1", "machine": "m", "versions": "v"}
    path.write_bytes(broken_text(rng, json.dumps({"made": made, "rows": [{"a": 1}]}).encode()))
    return Trial(lambda: json_rows.load(path), None, lambda _: "", "rows in JSON")


def _make_path(rng: Rng, folder: Path) -> tuple[Any, bool]:
    """Return a path that is no file, or a file in disguise, and whether it can be read."""
    whole, path = zip_bytes(list(members_of(STEP).values())), folder / "file.npz"
    kinds = ("folder", "fifo", "zero", "null", "full", "dangling", "loop", "link", "missing")
    kind = (*kinds, "nul", "long", "empty", "under")[rng.integers(len(kinds) + 4)]
    if kind == "folder":
        path.mkdir()
    elif kind == "fifo":
        os.mkfifo(path)
    elif kind in ("zero", "null", "full"):
        path.symlink_to(f"/dev/{kind}")
    elif kind == "dangling":
        path.symlink_to("nowhere")
    elif kind == "loop":
        path.symlink_to(path)
    elif kind == "link":
        (folder / "own.npz").write_bytes(whole)
        path.symlink_to(folder / "own.npz")
        return path, True
    elif kind == "empty":
        path.write_bytes(b"")
    elif kind == "under":
        (folder / "own").write_bytes(whole)
        return folder / "own" / "file.npz", False
    elif kind in ("nul", "long"):
        return f"{folder}/file.npz\0" if kind == "nul" else f"{folder}/{'file.npz' * 90}", False
    return path, False


def path_trial(rng: Rng, folder: Path) -> Trial:
    """Return a path that is no file, for one of the readers."""
    path, readable = _make_path(rng, folder)
    readers: tuple[Callable[[Any], Any], ...] = (
        load_scene,
        load_arrays,
        load_result,
        lambda p: read_known(Path(p), ()),
    )
    i = int(rng.integers(len(readers)))
    wrongs = None if readable or i in (1, 2, 3) else [Wrong("file.npz")]
    return Trial(lambda: readers[i](path), wrongs, lambda _: "", f"reader {i} of {path}")


def pipe_in_dump_trial(rng: Rng, folder: Path) -> Trial:
    """Return a dump whose folder holds a pipe, a device or a loop in the place of an array."""
    (folder / "scene").mkdir()
    for name, array in STEP.items():
        (folder / "scene" / f"{name}.npy").write_bytes(array_bytes(array))
    path, _ = _make_path(rng, folder / "scene")
    del path
    odd = folder / "scene" / "faces.npy"
    odd.unlink()
    if rng.random() < 0.5:
        os.mkfifo(odd)
    else:
        odd.symlink_to("/dev/zero")

    def call() -> Any:
        return load_arrays(folder)

    return Trial(call, [Wrong("")], lambda _: "", "dump with a pipe")

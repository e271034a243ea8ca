"""Hostile archives of steps and results, made byte by byte, and what the contract says of them."""

import io
import pickle
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.app.files import load_result, load_scene
from izo_ref.porting.trace_files import load_arrays
from validation.fuzz.archive_bytes import Member, array_bytes, members_of, npy, zip_bytes
from validation.fuzz.arrays import Rng
from validation.fuzz.trial import Trial, Wrong

STEP = {
    "positions_t0": np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 1]]),
    "positions_t1": np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, -1]]),
    "faces": np.array([[0, 1, 2]], np.int32),
    "masses": np.array([1.0, 2.0, 3.0, 4.0]),
    "pinned": np.array([True, False, False, False]),
}
RESULT = {"positions": STEP["positions_t1"], "thickness": np.array(1e-3)}
TERA = 2**42
LOADED: list[str] = []  # what a pickle that was loaded would write


def _trap(word: str) -> str:
    LOADED.append(word)
    return word


class Trap:
    """An object whose pickle calls a function when it is loaded."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the call that loading makes."""
        return _trap, ("loaded",)


def _pickled() -> bytes:
    return npy("'|O'", "(1,)", pickle.dumps(np.array([Trap()], object)))


# Hostile arrays: each is in the place of one that is read.
ARRAYS: tuple[Callable[[bytes], bytes], ...] = (
    lambda good: npy("'<f8'", f"({2**62},)", b"\0" * 64),
    lambda good: npy("'<f8'", f"({2**40}, 3)", b"\0" * 64),
    lambda good: npy("'<f8'", f"({10**30}, 3)", b"\0" * 64),
    lambda good: npy("'<f8'", "(-4, 3)", b"\0" * 96),
    lambda good: npy("'<f8'", "(-2, -6)", b"\0" * 96),
    lambda good: npy("'<f8'", f"({'1, ' * 65})", b"\0" * 8),
    lambda good: npy("'<f8'", f"(0, {2**62})", b""),
    lambda good: npy("'<f8'", "(4.0, 3)", b"\0" * 96),
    lambda good: npy("'<f8'", "(True, 12)", b"\0" * 96),
    lambda good: npy("'<f8'", "[4, 3]", b"\0" * 96),
    lambda good: npy("'<f8'", "12", b"\0" * 96),
    lambda good: npy("'<f8'", "(4, 3)", b"\0" * 95),
    lambda good: npy("'<f8'", "(4, 3)", b"\0" * 97),
    lambda good: _pickled(),
    lambda good: pickle.dumps(Trap()),
    lambda good: npy("'|O'", "(4, 3)", b""),
    lambda good: npy("'<c16'", "(4, 3)", b"\0" * 192),
    lambda good: npy("'<U4'", "(4, 3)", b"\0" * 192),
    lambda good: npy("'|S8'", "(4, 3)", b"\0" * 96),
    lambda good: npy("'|V8'", "(4, 3)", b"\0" * 96),
    lambda good: npy("'<M8[s]'", "(4, 3)", b"\0" * 96),
    lambda good: npy("[('x', '<f8'), ('y', '<f8')]", "(4,)", b"\0" * 64),
    lambda good: npy("('<f8', (3,))", "(4,)", b"\0" * 96),
    lambda good: npy("'(3,)<f8'", "(4,)", b"\0" * 96),
    lambda good: npy("'f8,f8,f8'", "(4,)", b"\0" * 96),
    lambda good: npy("'<f8'", "(4, 3)", b"\0" * 96, "1"),
    lambda good: npy("'|b1'", "(4, 3)", b"\7" * 12),
    lambda good: npy("'<f16'", "(4, 3)", b"\0" * 192),
    lambda good: npy("'|S99999999999'", "(4, 3)", b""),
    lambda good: npy("__import__('os').getcwd()", "(4, 3)", b"\0" * 96),
    lambda good: npy("'<f8'", f"{'(' * 3000}{')' * 3000}", b""),
    lambda good: npy("'<f8'", f"({'9' * 5000},)", b""),
    lambda good: npy("'<f8'", "(4, 3)", b"\0" * 96, version=(9, 9)),
    lambda good: b"\x93NUMPY\x01\x00\xff\xff" + b"{" * 70_000,
    lambda good: b"\x93NUMPY\x02\x00\xff\xff\xff\xff" + b" " * 100,
    lambda good: b"\x93NUMPY\x01\x00\x02\x00[]" + b"\0" * 96,
    lambda good: b"\x93NUMPY\x01\x00\x05\x00{'a'}",
    lambda good: b"\x93NUM",
    lambda good: b"",
    lambda good: b"no array",
    lambda good: zip_bytes([Member("inner.npy", good)]),
    lambda good: good[:-1],
    lambda good: good + b"\0",
)
# Hostile records around a good array.
RECORDS: tuple[Callable[[Member], list[Member]], ...] = (
    lambda m: [m._replace(crc=0)],
    lambda m: [m._replace(size=TERA)],
    lambda m: [m._replace(size=TERA, packed=TERA)],
    lambda m: [m._replace(packed=2**31)],
    lambda m: [m._replace(size=0)],
    lambda m: [m._replace(size=len(m.data) - 1)],
    lambda m: [m._replace(size=len(m.data) + 1)],
    lambda m: [m._replace(flags=1)],
    lambda m: [m._replace(flags=1 | 64)],
    lambda m: [m._replace(flags=32)],
    lambda m: [m._replace(method=12)],
    lambda m: [m._replace(method=14)],
    lambda m: [m._replace(method=99)],
    lambda m: [m._replace(method=0, size=len(m.data) + 8)],
    lambda m: [m._replace(local="other.npy")],
    lambda m: [m._replace(name="../" + m.name)],
    lambda m: [m, m],
    lambda m: [m, m._replace(data=array_bytes(np.zeros((4, 3))))],
    lambda m: [m, m._replace(name=m.name.removesuffix(".npy"))],
    lambda m: [],
)


@cache
def _bomb(*names: str) -> bytes:
    """Return an archive of which many members share the bytes of one."""
    data = array_bytes(np.zeros((40_000, 3)))
    files = [f"{name}.npy" for name in (*names, *map(str, range(50)))]
    return zip_bytes([Member(file, data) for file in files], shared=True)


def hostile_archive(rng: Rng, arrays: dict[str, Any]) -> tuple[bytes, bool | None, str]:
    """Return an archive, whether it is valid (None: its arrays decide), and what it is."""
    members = members_of(arrays, int(rng.choice((0, 8))))
    required = [name for name in members if name not in ("masses", "pinned", "thickness")]
    name = required[rng.integers(len(required))]
    kind = rng.integers(9)
    if kind <= 1:
        i = int(rng.integers(len(ARRAYS)))
        members[name] = members[name]._replace(data=ARRAYS[i](members[name].data))
        return zip_bytes(list(members.values())), False, f"array {i} as {name}"
    if kind == 2:
        i = int(rng.integers(len(RECORDS)))
        changed = RECORDS[i](members.pop(name))
        return zip_bytes([*members.values(), *changed]), False, f"record {i} of {name}"
    if kind == 3:
        return _variant(rng, arrays), True, "a variant"
    if kind == 4 and rng.random() < 0.3:
        return _bomb(*arrays), False, "shared bytes"
    return _damaged(rng, zip_bytes(list(members.values()))), None, f"damage of kind {kind}"


def _variant(rng: Rng, arrays: dict[str, Any]) -> bytes:
    """Return an archive with the same numbers in another type, order, format or company."""
    kinds = {"f": ("<f8", ">f8"), "i": ("<i4", ">i8", "<u2", "<f4"), "b": ("?", "u1")}
    members = []
    for name, array in arrays.items():
        kind = kinds[array.dtype.kind][rng.integers(len(kinds[array.dtype.kind]))]
        other = np.asarray(array).astype(kind)
        other = np.asfortranarray(other) if rng.random() < 0.5 and other.ndim else other
        out = io.BytesIO()
        version = (1, 0), (2, 0), (3, 0)
        np.lib.format.write_array(out, other, version[rng.integers(3)], allow_pickle=False)
        members.append(Member(f"{name}.npy", out.getvalue(), int(rng.choice((0, 8)))))
    if rng.random() < 0.3:
        members.append(Member("notes.txt", b"nobody reads this"))
    order = rng.permutation(len(members))
    return zip_bytes([members[i] for i in order])


def _damaged(rng: Rng, content: bytes) -> bytes:
    """Return bytes of which some are flipped, cut off, moved or repeated."""
    out = bytearray(content)
    kind = rng.integers(5)
    if kind <= 1:
        for place in rng.integers(len(out), size=rng.integers(1, 4)):
            out[place] ^= 1 << rng.integers(8)
    elif kind == 2:
        del out[rng.integers(len(out)) :]
    elif kind == 3:
        a, b = sorted(rng.integers(len(out), size=2).tolist())
        at = int(rng.integers(len(out)))
        out[at:at] = out[a:b]
    else:
        a, b = sorted(rng.integers(len(out), size=2).tolist())
        out[a:b] = rng.bytes(int(rng.integers(16)))
    return bytes(out)


def step_trial(rng: Rng, folder: Path) -> Trial:
    """Return a step file to read."""
    return _file_trial(rng, folder, STEP, lambda path: vars(load_scene(path)))


def result_trial(rng: Rng, folder: Path) -> Trial:
    """Return a result file to read."""
    return _file_trial(rng, folder, RESULT, lambda path: load_result(path)._asdict())


def dump_trial(rng: Rng, folder: Path) -> Trial:
    """Return the archive of a dump to read."""
    return _file_trial(rng, folder, {"scene/" + k: v for k, v in STEP.items()}, load_arrays)


def _file_trial(
    rng: Rng, folder: Path, arrays: dict[str, Any], read: Callable[[Path], dict[str, Any]]
) -> Trial:
    content, valid, what = hostile_archive(rng, arrays)
    path = folder / "file.npz"
    path.write_bytes(content)
    if read is load_arrays and what.startswith(("array", "record")):
        valid = None  # of a dump, only the names of its arrays are known here
    if read is load_arrays and b"notes.txt" in content:
        valid = False  # in a dump, every file is an array
    wrongs = {True: [], False: [Wrong("file.npz")], None: None}[valid]

    def judge(found: dict[str, Any]) -> str:
        if LOADED:
            LOADED.clear()
            return "a pickle was loaded"
        if read is load_arrays:
            return ""
        for name, array in arrays.items():
            if not np.array_equal(np.asarray(found[name]), array):
                return f"the array {name} is another one"
        return ""

    return Trial(lambda: read(path), wrongs, judge, f"{what} {content[:40]!r}")


def npy_trial(rng: Rng, folder: Path) -> Trial:
    """Return a folder of a dump with one hostile .npy file."""
    (folder / "scene").mkdir()
    for name, array in STEP.items():
        (folder / "scene" / f"{name}.npy").write_bytes(array_bytes(array))
    path, i = folder / "scene" / "faces.npy", int(rng.integers(len(ARRAYS)))
    damage = rng.random() < 0.3
    good = path.read_bytes()
    path.write_bytes(_damaged(rng, good) if damage else ARRAYS[i](good))
    kinds = (b"'<U4'",) if not damage else ()
    is_text = any(kind in path.read_bytes() for kind in kinds)
    wrongs = None if damage or is_text else [Wrong("faces.npy")]

    def judge(found: dict[str, Any]) -> str:
        return "a pickle was loaded" if LOADED else ""

    return Trial(lambda: load_arrays(folder), wrongs, judge, f"npy {i}, damage {damage}")


def is_zip(content: bytes) -> bool:
    """Return whether Python's own reader finds an archive."""
    return zipfile.is_zipfile(io.BytesIO(content))

"""The vectors pass a port that was written in C, and catch faults that are put into it."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from izo_ref.porting.cases import Case
from izo_ref.porting.conform.run import Choice, Row, requests_of, run_program
from izo_ref.porting.conform.suspects import shown_suspects
from izo_ref.porting.files import load_cases
from izo_ref.porting.judge.outcome import FAILED, PASSED
from izo_ref.porting.stages import STAGE
from tests.helpers.sample import sample
from tests.ports.c_faults import FAULTS, Fault

SOURCE = Path(__file__).parent / "c"
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
COMPILERS = COMPILERS or [name for name in ("cc",) if shutil.which(name)]
FLAGS = ("-std=c11", "-O2", "-ffp-contract=off")
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
REAL = {"f8": "double", "f4": "float"}
STAGES = ("S2", "S3", "S5", "S6", "S7", "S8", "S9", "S10", "S11")

pytestmark = pytest.mark.skipif(not COMPILERS, reason="this system has no C compiler")


def compile_c(compiler: str, dtype: str, *words: str | Path) -> None:
    """Run a C compiler, and fail with what it says if it does not succeed."""
    command = [compiler, *FLAGS, f"-DREAL={REAL[dtype]}", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


def objects_of(folder: Path, dtype: str) -> dict[str, Path]:
    """Compile each file of the port, and return the objects by the names of the files."""
    objects = {}
    for path in sorted(SOURCE.glob("*.c")):
        objects[path.name] = folder / f"{path.stem}-{dtype}.o"
        compile_c(COMPILERS[0], dtype, "-c", path, "-o", objects[path.name])
    return objects


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Path]]:
    folder = tmp_path_factory.mktemp("objects")
    return {dtype: objects_of(folder, dtype) for dtype in REAL}


@cache
def all_cases() -> list[Case]:
    """Return the vectors of the repository."""
    return load_cases()


def rows_of(port: Path, dtype: str, stages: tuple[str, ...]) -> tuple[Row, ...]:
    """Ask a port every case of some stages."""
    requests = requests_of(all_cases(), Choice(stages=stages, dtypes=(dtype,)))
    run = run_program([str(port)], requests)
    assert run.port is not None
    assert not run.notes
    return run.rows


def build_with_fault(fault: Fault, folder: Path, objects: dict[str, Path]) -> Path:
    """Compile the file of a fault with the fault in it, and link it with the other objects."""
    text = (SOURCE / fault.file).read_text(encoding="utf-8")
    assert text.count(fault.old) == 1, "the text to change has to occur once"
    changed, port = folder / fault.file, folder / "port"
    changed.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    others = [path for name, path in objects.items() if name != fault.file]
    compile_c(COMPILERS[0], fault.dtype, f"-I{SOURCE}", changed, *others, "-lm", "-o", port)
    return port


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("dtype", REAL)
def test_every_stage_of_the_port_conforms(compiler: str, dtype: str, tmp_path: Path) -> None:
    port = tmp_path / "port"
    compile_c(compiler, dtype, *STRICT, *sorted(SOURCE.glob("*.c")), "-lm", "-o", port)
    rows = rows_of(port, dtype, STAGES)
    wrong = [(row.request.case.id, row.outcome) for row in rows if row.outcome.result != PASSED]
    assert not wrong
    assert {row.request.case.stage for row in rows} == set(STAGES)


@pytest.mark.parametrize("fault", sample(FAULTS, 4, lambda fault: fault.name))
def test_a_fault_is_caught_at_its_stage_and_named_by_its_flag(
    fault: Fault, tmp_path: Path, objects: dict[str, dict[str, Path]]
) -> None:
    port = build_with_fault(fault, tmp_path, objects[fault.dtype])
    order = list(STAGE)
    asked = tuple(name for name in STAGES if order.index(name) <= order.index(fault.stage))
    rows = rows_of(port, fault.dtype, asked)
    first = next((row for row in rows if row.outcome.result == FAILED), None)
    assert first is not None, "no case fails"
    assert first.request.case.stage == fault.stage, first
    named = [item.flag for item in shown_suspects(rows, fault.stage)]
    assert fault.flag in named


def answers_of(port: Path, lines: list[str]) -> list[str]:
    """Return what a port writes for lines that are not from the harness."""
    text = "".join(f"{line}\n" for line in lines)
    done = subprocess.run([str(port)], input=text, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


BAD_INPUTS = {
    "no JSON": "this is no JSON",
    "half a line": '{"id":"a","stage":"S9","dtype":"f8","input":{"multipliers":["0x1p+0"',
    "no inputs": '{"id":"a","stage":"S9","dtype":"f8"}',
    "too few numbers": '{"id":"a","stage":"S9","dtype":"f8","input":{"multipliers":["0x1p+0"],'
    '"constraints":[],"penalty":"0x1p+0"}}',
    "not finite": '{"id":"a","stage":"S9","dtype":"f8","input":{"multipliers":["nan"],'
    '"constraints":["0x1p+0"],"penalty":"0x1p+0"}}',
    "no number": '{"id":"a","stage":"S9","dtype":"f8","input":{"multipliers":["one"],'
    '"constraints":["0x1p+0"],"penalty":"0x1p+0"}}',
    "index out of range": '{"id":"a","stage":"S5","dtype":"f8","input":{"nodes":[0,1,2,4],'
    '"pinned":[0,0,0,0]}}',
    "index that is no integer": '{"id":"a","stage":"S5","dtype":"f8","input":{"nodes":[0,1,2,0.5],'
    '"pinned":[0,0,0,0]}}',
    "deep brackets": "[" * 100000,
}


def test_the_port_refuses_bad_requests_and_goes_on(
    tmp_path: Path, objects: dict[str, dict[str, Path]]
) -> None:
    port = tmp_path / "port"
    compile_c(COMPILERS[0], "f8", *objects["f8"].values(), "-lm", "-o", port)
    good = '{"id":"good","stage":"S5","dtype":"f8","input":{"nodes":[],"pinned":[]}}'
    unknown = '{"id":"S4-a","stage":"S4","dtype":"f8","input":{}}'
    *answers, last, other = answers_of(port, [*BAD_INPUTS.values(), good, unknown])
    for name, answer in zip(BAD_INPUTS, answers, strict=True):
        assert '"status":"refused"' in answer, name
    assert last == '{"id":"good","status":"ok","output":{"zone_of_impact":[]}}'
    assert '"status":"unsupported"' in other

"""Run the vectors on copies of the repository that have one fault each.

Our own port (`tests/ports/own`) answers from the copy with the fault, in pure Python, since
compiling each copy would take minutes. The harness and the judge run from a copy without any
fault: a judge with a fault proves nothing.
"""

import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from izo_ref.app.files import save_json
from validation.mutants.fault import Fault
from validation.mutants.faults import FAULTS
from validation.mutants.run import ROOT, Bench, choose

HARNESS = ("-m", "izo_ref.app.cli", "conform")  # behind it: --exec PORT --json REPORT
PORT = ("-m", "tests.ports.own")
VECTORS = Path("data/vectors/v1")
# Seconds for one case: in pure Python, a step in which a sheet falls through five takes over 10.
CASE_S = 60
# Seconds for all vectors on one copy, in pure Python. A fault may make the port hang at each case.
LIMIT_S = 900.0
SHOWN = 5  # cases in a row
# Whole steps take ten times as long as all other stages, in pure Python: they are asked last.
SLOW_STAGE = "S12"


class Finding(NamedTuple):
    """What the vectors found in a port.

    Attributes:
        stages: Stages with a case that failed, in the order of the method.
        flags: Flags of these cases, sorted.
        cases: Identifiers of these cases.
        notes: What the harness says besides, such as that the port did not start.
    """

    stages: tuple[str, ...]
    flags: tuple[str, ...]
    cases: tuple[str, ...]
    notes: tuple[str, ...]


def run_vectors(
    names: Iterable[str] | None = None,
    json_path: str | Path | None = None,
    *,
    root: Path = ROOT,
    faults: Sequence[Fault] = FAULTS,
    limit_s: float = LIMIT_S,
) -> list[dict[str, Any]]:
    """Apply each fault to a copy of the repository and run the vectors on our own port there.

    Args:
        names: Names of the faults to run. If None, those that the vectors have to notice.
        json_path: File to which the rows are written after each of them; none if None.
        root: Root of the repository.
        faults: The faults.
        limit_s: Seconds for all vectors on one copy.

    Returns:
        One row for each fault: name, file, what, flag, caught, stages, flags and cases that failed,
        by_flag (whether a case with the flag of the fault failed), notes, seconds.

    Raises:
        ValueError: A name is unknown, or the vectors cannot notice the fault.
        RuntimeError: A vector fails without any fault, or the harness cannot run.
    """
    chosen = choose(names, faults)
    excused = [fault for fault in chosen if fault.not_by_vectors]
    if names is not None and excused:
        reasons = "; ".join(f"{fault.name}: {fault.not_by_vectors}" for fault in excused)
        raise ValueError(f"mutants: the vectors cannot notice these faults: {reasons}")
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="vectors-") as folder:
        bench = Bench(Path(folder), root)
        bench.restore()
        begin = time.perf_counter()
        found = vectors_find(bench, limit_s)
        if found != Finding((), (), (), ()):
            raise RuntimeError(f"mutants: without any fault, the vectors fail: {found}")
        print(f"without fault: conforms, {time.perf_counter() - begin:.0f} s", flush=True)
        for fault in chosen:
            if not fault.not_by_vectors:
                rows.append(_row(bench, fault, limit_s))
                print(_line(rows[-1]), flush=True)
                if json_path is not None:
                    save_json(json_path, rows)
    return rows


def _row(bench: Bench, fault: Fault, limit_s: float) -> dict[str, Any]:
    """Run the vectors with one fault and return its row."""
    begin = time.perf_counter()
    bench.apply(fault)
    found = vectors_find(bench, limit_s)
    return {
        "name": fault.name,
        "file": fault.file,
        "what": fault.what,
        "flag": fault.flag,
        "caught": bool(found.cases or found.notes),
        "stages": list(found.stages),
        "flags": list(found.flags),
        "by_flag": fault.flag in found.flags,
        "cases": list(found.cases[:SHOWN]),
        "notes": list(found.notes[:SHOWN]),
        "seconds": round(time.perf_counter() - begin, 1),
    }


def vectors_find(bench: Bench, limit_s: float, compiled: str = "") -> Finding:
    """Run the vectors on the port in the copy, the slow stage only if no other one fails.

    Args:
        bench: The copy, and the snapshot without any fault.
        limit_s: Seconds for all vectors.
        compiled: A folder for compiled code; in pure Python if it is empty.
    """
    stages = sorted(path.stem for path in (bench.snapshot / VECTORS).glob("S*.json"))
    quick = [stage for stage in stages if stage != SLOW_STAGE]
    found = _ask(bench, quick, limit_s, compiled)
    if SLOW_STAGE in stages and found == Finding((), (), (), ()):
        return _ask(bench, [SLOW_STAGE], limit_s, compiled)
    return found


def _ask(bench: Bench, stages: Sequence[str], limit_s: float, compiled: str) -> Finding:
    """Run the vectors of some stages on the port in the copy, with the harness of the snapshot.

    Raises:
        RuntimeError: The harness writes no report.
    """
    folder = bench.tree.parent
    report, log, port = (folder / name for name in ("report.json", "log.txt", "port.sh"))
    report.unlink(missing_ok=True)
    words = " ".join(shlex.quote(word) for word in (sys.executable, *PORT))
    tree = shlex.quote(str(bench.tree))
    own = f"PYTHONPATH={tree}"
    if compiled:
        own += f" NUMBA_DISABLE_JIT=0 XDG_CACHE_HOME={shlex.quote(compiled)}"
    port.write_text(f"#!/bin/sh\ncd {tree} && {own} exec {words}\n")
    port.chmod(0o755)
    command = [sys.executable, *HARNESS, "--exec", str(port), "--json", str(report)]
    command += ["--seconds", str(CASE_S)]
    for stage in stages:
        command += ["--stage", stage]
    code = _run(command, bench.snapshot, log, limit_s)
    if code is None:
        return Finding((), (), (), (f"no end within {limit_s:g} s",))
    if not report.is_file():
        end = log.read_text(errors="replace")[-2000:]
        raise RuntimeError(f"mutants: the harness wrote no report, exit code {code}\n{end}")
    return read_report(json.loads(report.read_text()), bench.snapshot / VECTORS)


def _run(command: Sequence[str], folder: Path, log: Path, limit_s: float) -> int | None:
    """Run the harness in a folder, in pure Python; return its exit code, None after a timeout."""
    changes = {
        "PYTHONPATH": str(folder),
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONWARNINGS": "ignore",  # pure Python warns where compiled code divides by zero
    }
    with open(log, "w") as out:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=os.environ | changes,
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            return process.wait(limit_s)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.poll() is None:
                # first politely, so that the harness ends the port, which is in a group of its own
                os.killpg(process.pid, signal.SIGINT)
                try:
                    process.wait(10.0)
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)
                    process.wait()


def read_report(report: dict[str, Any], vectors: Path) -> Finding:
    """Return what a report of `izo conform --json` found.

    Args:
        report: The report.
        vectors: Folder of the vectors, whose files have the flags of the cases.
    """
    # after a few equal incidents the harness stops, and the rest says nothing about the fault
    results = [row["result"] for row in report["cases"]]
    wrong = "failed" if "failed" in results else "not run"
    failed = [row for row in report["cases"] if row["result"] == wrong]
    if not any(row["result"] == "passed" for row in report["cases"]) and not failed:
        return Finding((), (), (), ("no case was judged", *report["notes"]))
    ids = list(dict.fromkeys(row["id"] for row in failed))
    stages = sorted({row["stage"] for row in failed}, key=lambda stage: int(stage[1:]))
    flags_of: dict[str, list[str]] = {}
    for stage in stages:
        cases = json.loads((vectors / f"{stage}.json").read_text())["cases"]
        flags_of |= {case["id"]: case["flags"] for case in cases}
    flags = sorted({flag for name in ids for flag in flags_of[name]})
    return Finding(tuple(stages), tuple(flags), tuple(ids), tuple(report["notes"]))


def _line(row: dict[str, Any]) -> str:
    """Return the line that is printed for a row."""
    if not row["caught"]:
        verdict = "SURVIVED"
    elif row["stages"]:
        other = "" if row["by_flag"] else f", but not by its own flag {row['flag']}"
        verdict = f"caught at {row['stages'][0]} by {', '.join(row['flags'])}{other}"
    else:
        verdict = f"caught: {row['notes'][0]}"
    return f"{row['name']}: {verdict} ({row['seconds']:.0f} s)"

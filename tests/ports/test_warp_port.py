"""The vectors pass a port to Warp, and catch faults that are put into it."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest

from izo_ref.porting.conform.run import Choice, Row, requests_of, run_program
from izo_ref.porting.conform.suspects import shown_suspects
from izo_ref.porting.files import load_cases
from izo_ref.porting.judge.outcome import FAILED, PASSED
from tests.helpers.sample import sample

PORT = Path(__file__).parent / "warp" / "port.py"
STAGES = ("S2", "S3", "S6", "S7", "S9")
SECONDS = 60.0  # of the first case that needs a kernel, which is then compiled

pytestmark = pytest.mark.skipif(find_spec("warp") is None, reason="warp-lang is not installed")


class Fault(NamedTuple):
    """A change of the port that makes a stage wrong."""

    name: str
    old: str
    new: str
    stage: str
    flag: str
    dtype: str = "f8"


FAULTS = (
    Fault(
        "contact at an absolute distance",
        "limit = contact * size_of(start, end)",
        "limit = real(1.0e-6)",
        "S2",
        "absolute-tolerance",
    ),
    Fault(
        "parallel edges by their first ends",
        "        best = points_at(p, a, b, real(0.0), nearest_on_segment(a, b), best)\n",
        "        if not nn > real(0.0):\n"
        "            return vec4(real(1.0), real(0.0), real(-1.0), real(0.0))\n"
        "        best = points_at(p, a, b, real(0.0), nearest_on_segment(a, b), best)\n",
        "S2",
        "parallel-edges",
    ),
    Fault(
        "the normal as the order of the corners has it",
        "        elif gap < real(0.0):\n            n = -n\n",
        "",
        "S3",
        "normal-sign",
    ),
    Fault(
        "the frame at the end of the step",
        "a = node_at(start, end, 1, toi)",
        "a = node_at(start, end, 1, real(1.0))",
        "S3",
        "frame-time",
    ),
    Fault(
        "gaps of absolute positions",
        "point += w[k] * (positions[nodes[j, k]] - positions[nodes[j, 0]])",
        "point += w[k] * positions[nodes[j, k]] + (w[0] / real(3.0)) * positions[nodes[j, 0]]",
        "S6",
        "float32-coordinates",
        "f4",
    ),
    Fault(
        "the objective without masses",
        "share = masses[i] / total_mass",
        "share = real(1.0) / real(masses.shape[0])",
        "S6",
        "mass-weighting",
    ),
    Fault(
        "the constraint is clamped without its multiplier",
        "pushed = wp.max(values[j] + rest, real(0.0))",
        "pushed = wp.max(values[j], real(0.0)) + rest",
        "S7",
        "kink",
    ),
    Fault(
        "multipliers that pull",
        "wp.max(multipliers[j] + penalty * values[j], real(0.0))",
        "multipliers[j] + penalty * values[j]",
        "S9",
        "multipliers-not-clamped",
    ),
)


def rows_of(port: Path, stages: tuple[str, ...], dtypes: tuple[str, ...]) -> tuple[Row, ...]:
    """Ask the port every case of some stages."""
    requests = requests_of(load_cases(stages=stages), Choice(dtypes=dtypes))
    run = run_program([sys.executable, str(port)], requests, seconds=SECONDS)
    assert run.port is not None
    assert not run.notes
    return run.rows


def test_every_stage_of_the_port_conforms():
    rows = rows_of(PORT, STAGES, ("f8", "f4"))
    wrong = [(row.request.case.id, row.outcome) for row in rows if row.outcome.result != PASSED]
    assert not wrong
    assert {row.request.case.stage for row in rows} == set(STAGES)


@pytest.mark.parametrize("fault", sample(FAULTS, 4, lambda fault: fault.name))
def test_a_fault_is_caught_at_its_stage_and_explained(fault, tmp_path):
    text = PORT.read_text(encoding="utf-8")
    assert text.count(fault.old) == 1
    port = tmp_path / "port.py"
    port.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    before = STAGES[: STAGES.index(fault.stage) + 1]
    rows = rows_of(port, before, (fault.dtype,))
    first = next(row for row in rows if row.outcome.result == FAILED)
    assert first.request.case.stage == fault.stage
    assert fault.flag in [item.flag for item in shown_suspects(rows, fault.stage)]

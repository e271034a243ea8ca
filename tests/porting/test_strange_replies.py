"""Whatever numbers a port answers, they are judged and the report is written."""

import json
from random import Random

import pytest

from izo_ref.porting.conform.divergence import report_record
from izo_ref.porting.conform.page import page_text
from izo_ref.porting.conform.protocol import Hello, Request
from izo_ref.porting.conform.report import Report
from izo_ref.porting.conform.right import right_reply
from izo_ref.porting.conform.run import Run, judged
from izo_ref.porting.conform.terminal import report_text
from izo_ref.porting.files import load_cases
from izo_ref.porting.stages import STAGES

SEED = 29
LARGEST, LEAST = 1.7976931348623157e308, 5e-324
# What one number of a reply becomes, given the right one.
NUMBERS = (
    lambda x: LARGEST,
    lambda x: -LARGEST,
    lambda x: LEAST,
    lambda x: 0.0,
    lambda x: -0.0,
    lambda x: 10**400,
    lambda x: -(2**63),
    lambda x: -x,
    lambda x: 2 * x,
    lambda x: x * (1.0 + 2.0**-40),
    lambda x: x * (1.0 + 2.0**-23),
    lambda x: x + 1e-300,
    lambda x: 1e300 * x,
    lambda x: 1e-310,
    lambda x: int(x),
    lambda x: "0x1p+1023",
    lambda x: "-inf",
)


def changed(value, change, random):
    """Return an answer of which all numbers, or some, are changed in one way."""
    if isinstance(value, list):
        part = random.choice((0.2, 1.0))
        return [changed(v, change, random) if random.random() < part else v for v in value]
    return change(value) if isinstance(value, int | float) else value


def base_of(case):
    """Return a reply whose numbers are changed; for whole steps, the proposed positions."""
    if case.stage == "S12":
        return {"free": 1, "positions": list(case.inputs["positions_t1"])}
    return (right_reply(case) or {}).get("output", {})


@pytest.mark.parametrize("stage", [stage.name for stage in STAGES])
def test_strange_numbers_are_judged_and_reported(stage):
    random = Random(SEED)
    cases = [case for case in load_cases(stages=[stage]) if case.verdict == "valid"]
    port = Hello("strange", "1", (stage,), ("f8", "f4"))
    for change in NUMBERS:
        rows = []
        for case in random.sample(cases, min(4, len(cases))):
            wrong = {name: changed(value, change, random) for name, value in base_of(case).items()}
            if stage == "S12":
                wrong["free"] = 1
            reply = json.loads(json.dumps({"status": "ok", "output": wrong}))
            rows += [judged(Request(case, dtype), reply) for dtype in case.dtypes]
        report = Report(Run(port, tuple(rows)))
        assert report_text(report).strip()
        json.dumps(report_record(report), allow_nan=False)
        assert "</html>" in page_text(report)

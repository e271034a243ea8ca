"""SciPy's SLSQP as a port: an independent solver agrees with the exact optima of stage S11."""

import io
import json

import pytest

from izo_ref.porting.cases import encode
from izo_ref.porting.files import load_cases
from tests.helpers.vectors import is_close
from tests.ports import slsqp
from tests.ports.serve import serve

CASES = load_cases(stages=["S11"])


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_slsqp_finds_the_exact_optimum(case):
    reply, wanted = slsqp.answer(dict(case.inputs), "f8"), case.expected
    assert [reply["feasible"]] == wanted["feasible"]["values"]
    assert not reply["feasible"] or is_close(wanted["positions"], reply["positions"], "f8")


def test_the_port_speaks_the_protocol(monkeypatch, capsys):
    case = CASES[0]
    head = {"hello": "izo-conform", "protocol": 1, "vectors": "v1"}
    body = {"id": case.id, "stage": "S11", "dtype": "f8", "input": encode(case.inputs)}
    bad = {**body, "input": {**body["input"], "thickness": "-0x1p+0"}}
    lines = [head, body, {**body, "stage": "S1"}, {**body, "dtype": "f4"}, bad]
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(json.dumps(x) + "\n" for x in lines)))
    serve("scipy-slsqp", {"S11": slsqp.answer})
    replies = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert replies[0]["stages"] == ["S11"]
    statuses = ["ok", "unsupported", "unsupported", "refused"]
    assert [reply["status"] for reply in replies[1:]] == statuses
    assert {reply["id"] for reply in replies[1:]} == {case.id}

"""Our own port: what it answers, refuses and does not support."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from izo_ref import IzoError
from izo_ref.porting.conform.protocol import GREETING, Request, hello_of, request_line
from izo_ref.porting.judge.outcome import NOT_SUPPORTED, PASSED
from izo_ref.porting.judge.verdict import judge
from tests.helpers import porting_cases as made
from tests.ports.own import __main__ as own


def stub(monkeypatch, answer):
    """Let a function answer stage S9."""
    monkeypatch.setitem(sys.modules, own.module_of("S9"), SimpleNamespace(answer=answer))


def ask(case):
    """Return the reply to a case, as a harness reads it."""
    (reply,) = own.replies([request_line(Request(case, "f8")).decode()])
    return json.loads(json.dumps(reply, allow_nan=False))


def test_the_port_introduces_itself_with_the_stages_that_have_a_module(monkeypatch):
    monkeypatch.setattr(own, "find_spec", lambda name: name.endswith(("s02", "s09")))
    (reply,) = own.replies([json.dumps(GREETING)])
    hello = hello_of(json.dumps(reply).encode())
    assert (hello.name, hello.stages, hello.dtypes) == ("izo_ref", ("S2", "S9"), ("f8", "f4"))


def test_arrays_and_numbers_of_numpy_are_written_in_full(monkeypatch):
    def answer(inputs, dtype):
        assert (inputs["penalty"], dtype) == (2.0, "f8")
        return {"multipliers": np.array([[0.0], [1.0]])}

    stub(monkeypatch, answer)
    assert ask(made.clamp()) == {
        "id": "S9-clamp-01",
        "status": "ok",
        "output": {"multipliers": ["0x0p+0", "0x1p+0"]},
    }
    assert judge(made.clamp(), ask(made.clamp()), "f8").result == PASSED


@pytest.mark.parametrize(
    ("value", "text"), [(np.float32(0.5), "0x1p-1"), (np.nan, "nan"), (True, 1), (np.int8(3), 3)]
)
def test_single_values_are_written_too(monkeypatch, value, text):
    stub(monkeypatch, lambda inputs, dtype: {"multipliers": value})
    assert ask(made.clamp())["output"] == {"multipliers": text}


def test_our_own_errors_refuse(monkeypatch):
    def answer(inputs, dtype):
        raise IzoError("too flat")

    stub(monkeypatch, answer)
    assert ask(made.clamp()) == {
        "id": "S9-clamp-01",
        "status": "refused",
        "message": "too flat",
    }


def test_what_is_not_there_is_unsupported(monkeypatch):
    def answer(inputs, dtype):
        raise NotImplementedError("float64 alone")

    stub(monkeypatch, answer)
    assert judge(made.clamp(), ask(made.clamp()), "f8").result == NOT_SUPPORTED

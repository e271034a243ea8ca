"""The vectors of stage S9: the update of the multipliers."""

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from tests.helpers.zone_port import KINDS
from tests.helpers.zone_vectors import check_cases, failures, kept_in_float32
from tests.ports.own import s09 as own

FLAGS = ("multipliers-not-clamped", "penalty-scaling", "kink", "constraint-sign")
CASES = load_cases(stages=["S9"])


def port(formula):
    """Return the function that answers with a formula of l, c and mu."""

    def reply(inputs, dtype):
        m, c = (np.array(inputs[name], KINDS[dtype]) for name in ("multipliers", "constraints"))
        new = formula(m, c, KINDS[dtype](inputs["penalty"]))
        return {"multipliers": new.tolist()}

    return reply


def test_the_cases_are_complete():
    check_cases(CASES, "S9", (*FLAGS, "absolute-tolerance"))


def test_our_own_functions_pass():
    assert failures(CASES, own.answer) == []


def test_right_formulas_pass():
    assert failures(CASES, port(lambda m, c, mu: np.maximum(m + mu * c, 0))) == []
    assert failures(CASES, port(lambda m, c, mu: mu * np.maximum(c + m / mu, 0))) == []
    assert failures(CASES, port(lambda m, c, mu: m + mu * np.maximum(c, -m / mu))) == []


@pytest.mark.parametrize("name", ["multipliers", "constraints", "penalty"])
def test_inputs_that_are_kept_in_float32_are_caught(name):
    right = port(lambda m, c, mu: np.maximum(m + mu * c, 0))
    assert failures(CASES, kept_in_float32(right, name), "float32-coordinates")


def test_a_port_may_flush_denormal_numbers_to_zero():
    def flushed(m, c, mu):
        new = np.maximum(m + mu * c, 0)
        return np.where(new < np.finfo(new.dtype).tiny, 0, new)

    assert failures(CASES, port(flushed)) == []


MISTAKES = {
    "multipliers-not-clamped": (
        lambda m, c, mu: m + mu * c,
        lambda m, c, mu: np.maximum(m + mu * c, m),
        lambda m, c, mu: m + mu * np.maximum(c, 0),
        lambda m, c, mu: abs(m + mu * c),
        lambda m, c, mu: np.where(np.arange(len(m)) < 1024, np.maximum(m + mu * c, 0), m),
    ),
    "penalty-scaling": (
        lambda m, c, mu: np.maximum(m + c, 0),
        lambda m, c, mu: np.maximum(m + c / mu, 0),
        lambda m, c, mu: np.maximum(m + mu / 2 * c, 0),
        lambda m, c, mu: np.clip(m + mu * c, 0, 1e10),
    ),
    "kink": (lambda m, c, mu: np.where(c > 0, m + mu * c, 0),),
    "constraint-sign": (lambda m, c, mu: np.maximum(m - mu * c, 0),),
    "absolute-tolerance": (lambda m, c, mu: np.where(m + mu * c > 1e-9, m + mu * c, 0),),
}


@pytest.mark.parametrize("flag", MISTAKES)
def test_cases_of_a_flag_catch_its_mistakes(flag):
    for mistake in MISTAKES[flag]:
        found = failures(CASES, port(mistake), flag)
        assert {dtype for _, dtype in found} == {"f8", "f4"}

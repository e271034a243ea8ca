"""A function that compiled code calls is compiled once, as a part of its callers."""

import gc

import numba
import numba.extending
import pytest

from izo_ref.base.callees import RARELY, Function
from izo_ref.base.compile import OPTIONS


def a_function(python):
    """Return a compiled function that is not kept on disk."""
    return Function(python, {}, dict(OPTIONS))


def abs_of_anything(x):
    """Return the absolute value; compiled code takes another function for it."""
    return abs(x)


@a_function
def square(x):
    return x * x


@a_function
def quarter(x):
    return square(x) / (4 * square(x) * square(x))


def test_python_and_compiled_code_get_the_same():
    assert quarter(2.0) == 0.0625
    assert square(0.5) == 0.25
    assert quarter(2) == 0.0625


def test_the_inner_form_has_no_machine_code():
    quarter(1.0)
    (of_square,) = (square.inner.overloads[types] for types in [(numba.float64,)])
    assert of_square.library.get_pointer_to_function(of_square.fndesc.llvm_func_name) == 0
    (of_quarter,) = (quarter.overloads[types] for types in [(numba.float64,)])
    assert of_quarter.library.get_pointer_to_function(of_quarter.fndesc.llvm_func_name) != 0
    assert not quarter.inner.overloads  # no compiled code called it


def test_the_inner_form_is_compiled_once_for_each_signature():
    quarter(1.0)
    before = square.inner.overloads[(numba.float64,)]

    @a_function
    def cube(x):
        return x * square(x)

    assert cube(2.0) == 8.0
    assert square.inner.overloads[(numba.float64,)] is before


def test_code_of_plain_numba_calls_the_inner_form_too():
    @numba.njit
    def plain(x):
        return square(x) + 1.0

    assert plain(3.0) == 10.0


def test_compiling_leaves_the_search_for_garbage_as_it_was():
    seen = []

    @numba.extending.overload(abs_of_anything)
    def _(x):
        seen.append(gc.get_threshold())
        return lambda x: abs(x)

    @a_function
    def caller(x):
        return abs_of_anything(x)

    before = gc.get_threshold()
    assert caller(-1.0) == 1.0
    assert gc.get_threshold() == before
    assert {threshold[0] for threshold in seen} == {RARELY * before[0]}


def test_what_cannot_be_compiled_is_named():
    @a_function
    def wrong(x):
        return x.colour

    @a_function
    def caller(x):
        return wrong(x)

    with pytest.raises(numba.TypingError, match="colour"):
        caller(1.0)

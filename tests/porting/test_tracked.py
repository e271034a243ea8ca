"""Numbers that remember how they were computed: their errors, ties and decisions."""

from decimal import Decimal
from fractions import Fraction
from random import Random

import numpy as np
import pytest

from izo_ref.porting.reference.rounded import EPS, ZERO, Decisions, Rounded
from izo_ref.porting.reference.tracked import Tape, norm, smaller

SEVENTH = Decimal(1) / Decimal(7)


def towards(number, goal, steps):
    """Halve the distance to a goal some times."""
    for _ in range(steps):
        number = number - 0.5 * (number - goal)
    return number


def test_errors_that_a_loop_contracts_stay_small():
    tape, goal = Tape(), Rounded(SEVENTH)
    tracked = tape.error(towards(tape.leaf(Rounded(Decimal(3))), goal, 40))
    assert tracked < 3 * SEVENTH
    assert towards(Rounded(Decimal(3)), goal, 40).error > 10**6


def test_a_formula_without_repetition_has_the_error_of_a_rounded_number():
    tape, inputs = Tape(), [Rounded.of(x) for x in (0.1, 30.0, 0.7, 1.9, 2.0)]

    def formula(a, b, c, d, e):
        return (a * b - c / d).sqrt() + -abs(e)

    tracked = formula(*(tape.leaf(x) for x in inputs))
    expected = formula(*inputs)
    assert float(tracked) == float(expected)
    assert float(tape.error(tracked)) == pytest.approx(float(expected.error))


def test_constants_on_either_side_keep_their_errors():
    tape, x = Tape(), Rounded.of(3.0)
    for formula in (
        lambda a: 0.1 + a,
        lambda a: a - 0.1,
        lambda a: 0.1 - a,
        lambda a: 0.1 * a,
        lambda a: 0.1 / a,
        lambda a: a / 0.1,
    ):
        number, expected = formula(tape.leaf(x)), formula(x)
        assert number.value == expected.value
        assert float(tape.error(number)) == pytest.approx(float(expected.error))


@pytest.mark.parametrize(("dtype", "kind"), [("f8", np.float64), ("f4", np.float32)])
def test_floats_stay_within_the_error(dtype, kind):
    random = Random(5)
    for _ in range(50):
        start = [kind(random.random()) for _ in range(4)]
        tape, one, half = Tape(), kind(1.0), kind(0.5)
        floats, exact = start, [tape.leaf(float(x)) for x in start]
        for step in range(12):
            i, j = step % 4, int(4 * random.random())
            floats = [
                *floats[:i],
                half * floats[j] + floats[i] / (one + floats[j]),
                *floats[i + 1 :],
            ]
            term = 0.5 * exact[j] + exact[i] / (1.0 + exact[j])
            exact = [*exact[:i], term, *exact[i + 1 :]]
        for found, number in zip(floats, exact, strict=True):
            tolerance = float(tape.error(number)) * EPS[dtype]
            assert abs(float(found) - float(number)) <= 1.01 * tolerance + 2.0**-53


def test_decisions_are_those_of_the_tape():
    tape = Tape()
    a, b = tape.leaf(Rounded(Decimal(1), Decimal(2))), tape.leaf(Rounded(Decimal(4), Decimal(1)))
    assert a < b
    assert b > a
    assert a <= b
    assert a > 0.0
    assert not a > 5.0
    with Decisions() as decisions:
        tape.note_decisions()
    assert decisions.closest == pytest.approx(1.0 / 2.0)  # 1 from 0, with an error of 2


def test_the_smaller_of_two_equal_numbers_has_the_larger_error():
    tape = Tape()
    sure, vague = tape.leaf(2.0), tape.leaf(Rounded(Decimal(2), Decimal(100)))
    assert tape.error(smaller(sure, vague)) >= 100
    assert tape.error(smaller(sure, tape.leaf(Rounded(Decimal(9), Decimal(100))))) == 0


def test_a_norm_that_vanishes_has_the_error_of_its_vector():
    tape = Tape()
    vector = [tape.leaf(Rounded(ZERO, Decimal(3))) for _ in range(4)]
    assert float(tape.error(norm(vector))) == pytest.approx(6.0)
    length = norm([tape.leaf(Rounded(Decimal(3))), Rounded(Decimal(4))])
    assert float(length) == 5.0
    assert float(norm([Rounded(Decimal(2))])) == 2.0


@pytest.mark.parametrize("number", [2.0**-52, 1.0 + 2.0**-52, -0.1])
def test_no_digit_is_lost_by_a_change_of_sign(number):
    """A float64 has up to 53 digits behind its first one; contexts of decimals have 28."""
    tape = Tape()
    for made in (Rounded(Decimal(number)), tape.leaf(Rounded(Decimal(number)))):
        assert (made - made).value == 0
        assert (-made).value == -Fraction(number)
        assert abs(made).value == abs(Fraction(number))

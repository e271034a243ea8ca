"""Hints: what is true of all wrong answers of an output, and nothing if nothing is."""

import math
import struct

import pytest

from izo_ref.porting.conform.hints import hints
from izo_ref.porting.conform.protocol import Request
from izo_ref.porting.conform.run import judged
from tests.helpers import porting_cases as made

CLAMPS = [
    made.clamp(f"S9-clamp-{i:02d}", (0.1 * i, 0.7, 1.0 / 3.0), (1.0, 0.3, 0.9 / i))
    for i in range(1, 13)
]
NORMAL = [0.36, 0.48, 0.8]
FRAME = {"weights": made.values([1.0, -0.5, -0.3, -0.2]), "normal": made.values(NORMAL)}
FRAMES = [made.case(f"S3-frame-{i}", {**made.PAIR, "toi": 0.5}, FRAME) for i in range(3)]
GRADIENT = [0.0, 0.0, 0.0, 0.3, 0.7, -0.2, 0.6, 0.1, 0.4, -0.9, -0.8, -0.2]
POINTS = [0.1 * i for i in range(12)]
EXPECTED = {"objective": made.values([0.7]), "gradient": made.values(GRADIENT)}
EXPECTED["constraints"] = made.values([0.1])
ENERGIES = [
    made.case(f"S6-energy-{i}", {**made.ZONE, "positions": POINTS}, EXPECTED) for i in range(3)
]


def toi(i, time):
    """Return a case of S2."""
    judge = {"judge": "time", "time": time, "scale": 1.0, "multiple": 4, "early": 0.0}
    return made.case(f"S2-toi-{i}", made.PAIR, {"meets": made.equal(1), "toi": judge})


TIMES = [toi(i, 0.1 + 0.07 * i) for i in range(4)]


def found(cases, change, dtype="f8", **outputs):
    """Return the hints if one output of every reply is changed by a function."""
    rows = []
    for case in cases:
        (name,) = outputs
        members = {
            output: expected["values"] if "values" in expected else [expected["time"]]
            for output, expected in case.expected.items()
        }
        if name in members:
            members[name] = change(case, members[name])
        shapes = {"toi": (), "meets": (), "objective": ()}
        values = {k: v[0] if k in shapes else v for k, v in members.items()}
        rows.append(judged(Request(case, dtype), {"status": "ok", "output": values}))
    return hints(rows, cases[0].stage, next(iter(outputs)))


def multipliers(change, cases=CLAMPS):
    """Return the hints if the new multipliers are changed."""
    return found(cases, lambda case, values: change(values), multipliers=1)


def to_float32(number):
    """Return the nearest float32."""
    return struct.unpack("<f", struct.pack("<f", number))[0]


def test_minus_the_expected_answer_is_said():
    said = multipliers(lambda values: [-value for value in values])
    assert said == ["The answer is minus the expected one in all 12 requests that fail."]


@pytest.mark.parametrize(
    ("factor", "name"),
    [(2.0, "2 times"), (1 / 3, "1/3 of"), (-4.0, "minus 4 times"), (0.7310001, "0.731 times")],
)
def test_a_constant_factor_is_named(factor, name):
    said = multipliers(lambda values: [factor * value for value in values])
    assert said == [f"The answer is {name} the expected one in all 12 requests that fail."]


def test_one_factor_in_each_case_is_said():
    said = multipliers(lambda values: [value * (2.0 + values[0]) for value in values])
    assert said[0].startswith("The answer is a multiple of the expected one in all 12 requests")
    assert "the direction is right and the size is not" in said[0]


def test_a_rule_may_hold_in_most_cases():
    said = found(
        CLAMPS,
        lambda case, values: [
            -1.5 * value + 7.0 * (case.id == "S9-clamp-03") * i for i, value in enumerate(values)
        ],
        multipliers=1,
    )
    assert "in 11 of the 12 requests that fail." in said[0]


def test_one_number_that_is_wrong_by_any_factor_says_nothing():
    one = [made.clamp("S9-clamp-01", (1.0,), (1.0,))]
    assert multipliers(lambda values: [1.3713 * values[0]], one) == []
    assert "2 times" in multipliers(lambda values: [2.0 * values[0]], one)[0]


def test_another_order_is_said_and_which():
    (said,) = multipliers(lambda values: [values[0], values[2], values[1]])
    assert said.endswith("requests that fail: expected elements 0, 2, 1, counted from 0.")
    (said,) = found(FRAMES, lambda case, values: [values[k] for k in (0, 2, 3, 1)], weights=1)
    assert "expected elements 0, 2, 3, 1" in said
    (said,) = found(FRAMES, lambda case, values: [values[k] for k in (2, 0, 1)], normal=1)
    assert said.endswith("(z, x, y) for (x, y, z).")


def test_rows_in_another_order_of_axes_are_said():
    def swap(case, values):
        return [values[i - i % 3 + (1, 0, 2)[i % 3]] for i in range(12)]

    (said, *_) = found(ENERGIES, swap, gradient=1)
    assert said.endswith("(y, x, z) for (x, y, z).")


def test_zeros_are_said():
    said = multipliers(lambda values: [0.0] * 3)
    assert said == ["The answer is zero in all 12 requests that fail."]


def test_an_answer_that_repeats_an_input_is_said():
    said = found(CLAMPS, lambda case, values: case.inputs["multipliers"], multipliers=1)
    assert said == [
        "The answer is the input multipliers as it was in all 12 requests that fail: nothing has "
        "changed."
    ]
    said = found(ENERGIES, lambda case, values: POINTS, gradient=1)
    assert said[0] == "The answer is the input positions as it was in all 3 requests that fail."


def test_the_length_of_a_vector_that_is_no_unit_vector_is_said():
    def squared(case, values):
        return [value**2 for value in values]

    length = math.hypot(*(value**2 for value in NORMAL))
    (said,) = found(FRAMES, squared, normal=1)
    assert said == f"The vector has length {length:.6g}, and not 1, in all 3 requests that fail."


def test_digits_of_a_float32_are_said():
    (said,) = multipliers(lambda values: [to_float32(value) for value in values])
    assert said.startswith("The answer has only the digits of a float32 in all 12 requests")
    (said,) = multipliers(lambda values: [value * to_float32(0.1) / 0.1 for value in values])
    assert "1 times" not in said
    assert "single precision" in said


def test_digits_that_were_not_printed_are_said():
    (said, *_) = multipliers(lambda values: [float(f"{value:g}") for value in values])
    assert said.startswith("The answer has only 6 decimal digits in all 12 requests that fail; ")


def test_a_small_error_is_not_taken_for_a_float32():
    assert (
        multipliers(lambda values: [value + 1e-12 * (i + 1) for i, value in enumerate(values)])
        == []
    )


def test_a_time_that_is_late_by_a_constant_is_said():
    said = found(TIMES, lambda case, values: [values[0] + 0.01], toi=1)
    assert said == ["The time is late by 0.01 in all 4 requests that fail."]
    said = found(TIMES, lambda case, values: [values[0] - 0.01], toi=1)
    assert said == ["The time is early by 0.01 in all 4 requests that fail."]


def test_the_same_number_everywhere_is_said():
    said = found(TIMES, lambda case, values: [1.0], toi=1)
    assert said == ["The answer is 1.0 in all 4 requests that fail."]


def test_the_only_part_that_is_right_is_said():
    (said,) = multipliers(lambda values: [values[0], values[1] + 0.3, values[2] + 0.1])
    assert said == "Only element 0 is right in all 12 requests that fail, counted from 0."

    def only_row(case, values):
        return [value + (0.0 if i // 3 in (0, 2) else 0.1 + i) for i, value in enumerate(values)]

    (said,) = found(ENERGIES, only_row, gradient=1)
    assert said == "Only row 2 is right in all 3 requests that fail, counted from 0."

    def only_y(case, values):
        return [value + (0.0 if i % 3 == 1 else 0.1 + i) for i, value in enumerate(values)]

    (said,) = found(ENERGIES, only_y, gradient=1)
    assert said == "Only y of each row is right in all 3 requests that fail."


def test_flags_that_are_all_the_same_are_said():
    apart = made.case("S2-apart-0", made.PAIR, {"meets": made.equal(0)})
    said = found(TIMES, lambda case, values: [0], meets=1)
    assert said == ["meets is 0 in every reply of this stage, right or wrong."]
    rows = [
        judged(Request(case, "f8"), {"status": "ok", "output": output})
        for case, output in [
            (TIMES[0], {"meets": 0}),
            (TIMES[1], {"meets": 0}),
            (TIMES[2], {"meets": 1, "toi": TIMES[2].expected["toi"]["time"]}),
            (apart, {"meets": 0}),
        ]
    ]
    said = hints(rows, "S2", "meets")
    assert said == ["meets is 0 in all 2 requests that fail, and never wrongly 1."]
    mixed = [*rows, judged(Request(apart, "f8"), {"status": "ok", "output": {"meets": 1}})]
    assert hints(mixed, "S2", "meets") == []


def test_answers_that_have_nothing_in_common_get_no_hint():
    def scatter(case, values):
        return [
            value + math.sin(7.0 * i + len(case.id) + values[0]) for i, value in enumerate(values)
        ]

    assert found(CLAMPS, scatter, multipliers=1) == []


def test_replies_of_the_wrong_form_get_no_hint():
    for bad in (None, [1.0], ["x"] * 3, [[1.0]] * 3, ["nan"] * 3):
        assert multipliers(lambda values, bad=bad: bad) == []


def test_single_precision_is_right_in_float32():
    change = {"multipliers": 1}
    assert found(CLAMPS, lambda case, v: [to_float32(x) for x in v], dtype="f4", **change) == []

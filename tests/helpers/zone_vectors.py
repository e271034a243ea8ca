"""Judges replies by hand, and evaluates zones in fractions: for the tests of stages S6 to S9."""

from fractions import Fraction

from izo_ref.porting.cases import DTYPES
from izo_ref.porting.generate.small_zones import float32
from izo_ref.porting.reference.rounded import EPS, is_float32


def numbers(value):
    """Return a value or a list as a list."""
    return list(value) if isinstance(value, list) else [value]


def passes(case, reply, dtype):
    """Return whether a reply is right, by the judges `values` and `range`; NaN is wrong."""
    for name, wanted in case.expected.items():
        if name not in reply:
            continue
        got, unit = numbers(reply[name]), wanted["multiple"] * EPS[dtype]
        if wanted["judge"] == "values":
            low = high = wanted["values"]
            scale = wanted["scale"]
        else:
            low, high, scale = [wanted["low"]], [wanted["high"]], [wanted["scale"]]
        if len(got) != len(low):
            return False
        for a, b, c, s in zip(low, got, high, scale, strict=True):
            if not a - unit * s <= b <= c + unit * s:
                return False
    return True


def failures(cases, answer, flag=None):
    """Return the cases, with their types of floats, at which an answer is wrong."""
    return [
        (case.id, dtype)
        for case in cases
        for dtype in case.dtypes
        if (flag is None or flag in case.flags)
        and not passes(case, answer(case.inputs, dtype), dtype)
    ]


def kept_in_float32(answer, name):
    """Return an answer that keeps an input in float32, whatever the type of floats is."""

    def reply(inputs, dtype):
        value = inputs[name]
        rounded = [float32(a) for a in value] if isinstance(value, list) else float32(value)
        return answer({**inputs, name: rounded}, dtype)

    return reply


def check_cases(cases, stage, flags):
    """Assert what holds for the cases of every stage."""
    assert len({case.id for case in cases}) == len(cases)
    assert len({case.what for case in cases}) == len(cases)
    for case in cases:
        assert case.id.startswith(f"{stage}-")
        assert case.dtypes, case.id
        assert case.what.endswith(".")
        if "f4" in case.dtypes:
            assert all(is_float32(a) or a == float("inf") for a in floats_of(case)), case.id
    for flag in flags:
        grades = [case.grade for case in cases if flag in case.flags]
        assert len(grades) >= 3, flag
        assert {"easy", "hard"} <= set(grades), flag
        for dtype in DTYPES:
            assert any(flag in case.flags and dtype in case.dtypes for case in cases), flag


def floats_of(case):
    """Return all floats of the inputs of a case."""
    return [a for value in case.inputs.values() for a in numbers(value) if isinstance(a, float)]


def fractions(flat):
    """Return numbers as fractions."""
    return [Fraction(a) for a in flat]


def exact_constraints(inputs, x):
    """Return c of a case at x, a flat list of fractions."""
    found = []
    for j in range(len(inputs["nodes"]) // 4):
        gap = Fraction(0)
        first = inputs["nodes"][4 * j]
        for k in range(4):
            i, a = inputs["nodes"][4 * j + k], Fraction(inputs["weights"][4 * j + k])
            for axis in range(3):
                moved = x[3 * i + axis] - x[3 * first + axis]
                gap += a * Fraction(inputs["normals"][3 * j + axis]) * moved
        found.append(Fraction(inputs["thickness"]) - gap)
    return found


def exact_objective(inputs, x):
    """Return g of a case at x."""
    squares = mass = Fraction(0)
    for i, is_pinned in enumerate(inputs["pinned"]):
        if not is_pinned:
            m = Fraction(inputs["masses"][i])
            mass += m
            for b in range(3 * i, 3 * i + 3):
                squares += m * (x[b] - Fraction(inputs["proposed"][b])) ** 2
    return squares / mass


def exact_lagrangian(inputs, x):
    """Return L of a case at x."""
    mu, value = Fraction(inputs["penalty"]), exact_objective(inputs, x)
    for c, m in zip(exact_constraints(inputs, x), fractions(inputs["multipliers"]), strict=True):
        value += mu / 2 * max(c + m / mu, Fraction(0)) ** 2 - m * m / (2 * mu)
    return value


def exact_change(inputs, step):
    """Return phi(step) - phi(0) of a case of stage S8."""
    x, p = fractions(inputs["positions"]), fractions(inputs["direction"])
    there = [a + step * b for a, b in zip(x, p, strict=True)]
    return exact_lagrangian(inputs, there) - exact_lagrangian(inputs, x)


def exact_rise(inputs, step, width=Fraction(1, 2**200)):
    """Return phi'(step) of a case of stage S8, from two values that are close to each other."""
    rise = exact_change(inputs, step + width) - exact_change(inputs, step - width)
    return rise / (2 * width)

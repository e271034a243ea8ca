"""Arrays of every type are converted, or refused with a message that names the first offender."""

import decimal
import fractions

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.base import checks, errors
from izo_ref.base.values import shown

ONE = {  # a vertex above a face
    "nodes": [[0, 1, 2, 3]],
    "weights": [[1.0, -0.25, -0.25, -0.5]],
    "normals": [[0.0, 0.0, 1.0]],
    "proposed": [[0.25, 0.25, -0.1], [0, 0, 0], [1, 0, 0], [0, 1, 0]],
    "masses": [1.0, 1.0, 1.0, 1.0],
    "thickness": 1e-3,
}
START = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 1]])


def scene(**changes):
    arguments = {"positions_t0": START, "positions_t1": START, "faces": [[0, 1, 2]]}
    return izo_ref.Scene(**(arguments | changes))


def with_object(array, place, value):
    out = np.array(array, object)
    out[place] = value
    return out


class Unprintable:
    def __repr__(self):
        raise RuntimeError


def named(value):
    """Return the id of a case: texts of arrays would have addresses, which differ by process."""
    return ",".join(value) if isinstance(value, dict) else "says"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pinned": [True, [False]]}, ["pinned"]),
        ({"masses": [1, [2, 3], 4, 5]}, ["masses"]),
        ({"positions_t0": START > 0}, ["positions_t0", "bool"]),
        ({"positions_t1": np.zeros((4, 3), "M8[s]")}, ["positions_t1", "datetime64"]),
        ({"positions_t1": np.zeros((4, 3), "m8[s]")}, ["positions_t1", "timedelta64"]),
        ({"positions_t1": with_object(START, (2, 1), "1")}, ["'1' at [2, 1]"]),
        ({"positions_t1": with_object(START, (2, 1), True)}, ["True at [2, 1]"]),
        ({"positions_t1": with_object(START, (3, 0), 10**5000)}, ["16610 bits at [3, 0]"]),
        (
            {"positions_t1": with_object(START, (0, 2), Unprintable())},
            ["Unprintable instance", "at [0, 2]"],
        ),
        ({"positions_t1": np.ma.masked_array(START, START > 0.5)}, ["3 entries are masked"]),
        ({"positions_t1": [np.ma.masked_array(p, p > 0.5) for p in START]}, ["masked"]),
        ({"faces": np.empty((5, 0))}, ["faces", "(5, 0)"]),
        ({"faces": np.empty((0, 4), int)}, ["faces", "(0, 4)"]),
        ({"faces": with_object([[0, 1, 2]], (0, 1), "1")}, ["'1' at [0, 1]"]),
        ({"faces": with_object([[0, 1, 2]], (0, 1), True)}, ["True at [0, 1]"]),
        ({"faces": np.array([[0, 1, 2]]) + np.longdouble(2.0**-60)}, ["faces", "integers"]),
        ({"faces": with_object([[0, 1, 2], [0, 1, 2]], (1, 2), 10**400)}, ["row 1", "1329 bits"]),
        ({"masses": True}, ["masses"]),
        ({"weld": "1e-3"}, ["weld", "'1e-3'"]),
        ({"initial_intersections": np.array(["raise"])}, ["initial_intersections"]),
        ({"initial_intersections": np.array(["raise", "x"])}, ["initial_intersections"]),
        ({"prescribed": 10**5000}, ["prescribed", "bits"]),
    ],
    ids=named,
)
def test_what_is_no_number_is_refused_and_named(changes, words):
    with pytest.raises(izo_ref.IzoError) as caught:
        scene(**changes)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("kind", ["f2", ">f8", "g", "i1", "u8", object])
def test_real_numbers_of_every_type_are_taken(kind):
    whole = 4.0 * START
    np.testing.assert_array_equal(scene(positions_t0=whole.astype(kind)).positions_t0, whole)


def test_fractions_and_decimals_are_numbers():
    masses = [fractions.Fraction(1, 2), decimal.Decimal("0.25"), np.float32(2), 3]
    assert scene(masses=masses).masses.tolist() == [0.5, 0.25, 2.0, 3.0]
    assert scene(masses=np.array(0.5)).masses.tolist() == [0.5] * 4


def test_a_long_double_beyond_the_floats_is_infinite_without_a_warning():
    big = START.astype(np.longdouble)
    big[1, 2] = np.longdouble("1e400")
    with pytest.raises(errors.NonFiniteError, match=r"inf at \[1, 2\]"):
        scene(positions_t1=big)


def test_flags_have_the_bytes_0_and_1():
    pinned = np.array([7, 0, 0, 1], np.uint8).view(bool)
    assert scene(pinned=pinned).pinned.view(np.uint8).tolist() == [1, 0, 0, 1]


@pytest.mark.parametrize(
    "value", ["0.1", True, np.complex128(0.1), 10**5000, [0.1], None], ids=shown
)
def test_what_is_no_thickness_is_refused(value):
    with pytest.raises(errors.ThicknessError, match="thickness: expected a finite number > 0"):
        checks.thickness(value)


@pytest.mark.parametrize(
    "given",
    [
        {"plan": None},
        {"plan": 5},
        {"plan": [["a"]]},
        {"plan": (rule for rule in ("still",))},  # read once, it would have switched all rules off
        {"method": np.array("auto")},
        {"small_zone": 2**70},
        {"max_steps": 10**400},
        {"gap_tolerance": 10**400},
        {"gap_tolerance": np.inf},
        {"max_iterations": np.float64("inf")},
        {"thickness_fraction": 0},
    ],
    ids=named,
)
def test_what_is_no_option_is_refused(given):
    (name,) = given
    with pytest.raises(errors.OptionError, match=f"^{name}: expected"):
        Options(**given)


def test_numbers_of_options_are_those_of_python():
    options = Options(gap_tolerance=np.float16(0.5), max_steps=1e3, plan=["still"])
    kinds = type(options.gap_tolerance), type(options.max_steps), options.plan
    assert kinds == (float, int, ("still",))


@pytest.mark.parametrize("rules", [None, "still", {"x"}, {1}])
def test_rules_of_a_certificate_are_a_set_of_known_names(rules):
    with pytest.raises(errors.OptionError, match=r"^rules: expected"):
        izo_ref.certify_path(scene(), START, rules)


@pytest.mark.parametrize("call", [izo_ref.solve_zone, izo_ref.residuals, izo_ref.distance_bound])
def test_what_is_no_problem_is_refused(call):
    rest = () if call is izo_ref.solve_zone else (START, [0.0])
    with pytest.raises(errors.OptionError, match="problem: expected a ZoneProblem, got str"):
        call("zone", *rest)


@pytest.mark.parametrize("judge", [izo_ref.residuals, izo_ref.distance_bound])
def test_answers_of_another_shape_are_not_judged(judge):
    """The kernel would read beyond the end of the array."""
    problem = izo_ref.ZoneProblem(**ONE)
    with pytest.raises(errors.ShapeError, match="positions: expected"):
        judge(problem, problem.proposed[:1], [0.0])
    with pytest.raises(errors.ShapeError, match="multipliers: expected"):
        judge(problem, problem.proposed, [0.0, 0.0])


def test_weights_that_do_not_sum_to_zero_are_refused():
    """They were solved for another constraint than the documented one, and called feasible."""
    with pytest.raises(errors.WeightError, match="impact 0"):
        izo_ref.ZoneProblem(**(ONE | {"weights": [[1.0, 1.0, 1.0, 1.0]]}))
    single = np.array(ONE["weights"], np.float32)
    izo_ref.ZoneProblem(**(ONE | {"weights": single}))
    for sum_, allowed in ((2.0**-20, True), (2.0**-20 + 2.0**-50, False)):
        weights = [[1.0, -0.5, -0.25, -0.25 + sum_]]
        if allowed:
            izo_ref.ZoneProblem(**(ONE | {"weights": weights}))
        else:
            with pytest.raises(errors.WeightError, match="impact 0"):
                izo_ref.ZoneProblem(**(ONE | {"weights": weights}))


def test_products_that_overflow_are_refused():
    """The positions were NaN, and the zone was called feasible."""
    huge = {"weights": np.array(ONE["weights"]) * 1e160, "normals": [[0.0, 0.0, 1e160]]}
    with pytest.raises(errors.SizeError, match="row 0"):
        izo_ref.solve_zone(izo_ref.ZoneProblem(**(ONE | huge)))


def test_a_zone_whose_answer_no_float_holds_is_refused():
    """The positions were infinite."""
    far = {"thickness": 1.7e308, "normals": [[0.0, 0.0, 0.5]], "masses": [1.0, *[np.inf] * 3]}
    problem = izo_ref.ZoneProblem(**(ONE | far))
    with pytest.raises(errors.SizeError, match="beyond the largest float"):
        izo_ref.solve_zone(problem)


@pytest.mark.parametrize("fake", [1, None, "certificate"])
def test_a_certificate_that_is_none_is_refused(fake):
    result = type("Fake", (), {"certificate": fake})()
    with pytest.raises(errors.UncertifiedStartError, match="no certificate"):
        scene().after(result, START)


def test_any_value_is_shown_on_one_short_line():
    values = (10**5000, Unprintable(), "x\ny" * 1000, [10**5000], np.zeros((9, 9)), {1: [2]})
    for value in values:
        text = shown(value)
        assert "\n" not in text
        assert len(text) <= 90


def test_a_lack_of_memory_is_no_fault_of_the_values():
    class Large:
        """An array that finds no memory."""

        def __array__(self, *arguments, **more):
            raise MemoryError("no room")

        def __float__(self):
            raise MemoryError("no room")

    with pytest.raises(MemoryError, match="no room"):
        scene(positions_t0=Large())
    with pytest.raises(MemoryError, match="no room"):
        izo_ref.resolve(scene(), Large())

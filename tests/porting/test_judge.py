"""The judges: what passes, what fails, and what is said about it."""

import math

import pytest

from izo_ref.porting.cases import ACCEPTABLE
from izo_ref.porting.conform.protocol import object_of
from izo_ref.porting.judge.outcome import FAILED, NOT_SUPPORTED, PASSED, place
from izo_ref.porting.judge.reading import HEX_FLOAT
from izo_ref.porting.judge.verdict import judge
from izo_ref.porting.stages import STAGE
from tests.helpers import porting_cases as made

EPS = 2.0**-52
EPS_F4 = 2.0**-23


def ask(case, dtype="f8", status="ok", **output):
    """Judge a reply."""
    return judge(case, {"id": case.id, "status": status, "output": output}, dtype)


def only(outcome):
    """Return the only difference of an outcome."""
    assert outcome.result == FAILED
    (difference,) = outcome.differences
    return difference


def test_values_pass_up_to_the_tolerance_and_fail_beyond_it():
    case = made.clamp()  # expects 0 and 1, tolerance 4 eps
    assert ask(case, multipliers=[0.0, 1.0 + 4 * EPS]).result == PASSED
    wrong = only(ask(case, multipliers=[0.0, 1.0 + 5 * EPS]))
    assert wrong.element == (1,)
    assert (wrong.expected, wrong.got) == (1.0, 1.0 + 5 * EPS)
    assert wrong.ulps == 5.0
    assert wrong.tolerances == 1.25
    assert "1.25 times the tolerance, 5 ulps" in wrong.sentence
    assert only(ask(case, multipliers=[5 * EPS, 1.0])).ulps is None  # the expected value is 0


def test_float32_has_its_own_tolerance_and_ulps():
    case = made.clamp()
    assert ask(case, "f4", multipliers=[0.0, 1.0 + 4 * EPS_F4]).result == PASSED
    wrong = only(ask(case, "f4", multipliers=[0.0, 1.0 - 8 * EPS_F4]))
    assert (wrong.ulps, wrong.tolerances) == (8.0, 2.0)


def test_a_wrong_sign_is_named():
    assert "the sign is wrong" in only(ask(made.clamp(), multipliers=[0, -1])).sentence


@pytest.mark.parametrize("text", ["0x1p+0", "0X1P+0", "0x1.p0", "+0x0.8p+1", "0x8p-3"])
def test_floats_may_be_written_as_c_does(text):
    assert ask(made.clamp(), multipliers=[0, text]).result == PASSED


@pytest.mark.parametrize("text", ["1.0", "1", "0x", "x", "", "0x1p+0 ", "١", "0x1p+99999999"])
def test_other_texts_are_no_floats(text):
    assert not HEX_FLOAT.fullmatch(text)
    assert "C's hexadecimal notation" in only(ask(made.clamp(), multipliers=[0, text])).sentence


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (None, "null"),
        (True, "true"),
        ([1.0], "flat, row by row"),
        ({}, "an object"),
        (10**400, "larger than any float64"),
        ("0x1p+5000", "larger than any float64"),
        (float("nan"), "nan where a finite number"),
        ("-nan(0x1)", "nan where a finite number"),
        ("inf", "inf where a finite number"),
    ],
)
def test_a_value_of_the_wrong_kind_is_a_difference_with_its_place(bad, said):
    wrong = only(ask(made.clamp(), multipliers=[0.0, bad]))
    assert said in wrong.sentence
    assert place(wrong) == "multipliers (1)"


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ({}, "does not have this output"),
        ({"multipliers": 1.0}, "expected a flat list"),
        ({"multipliers": [0.0]}, "expected 2 values, got 1"),
        ({"multipliers": [0.0, 1.0, 1.0]}, "expected 2 values, got 3"),
        ({"multipliers": [0.0, 1.0], "Multipliers": 1}, "no such output; it has multipliers"),
    ],
)
def test_missing_and_misshapen_outputs_fail_with_a_sentence(output, said):
    assert said in only(ask(made.clamp(), **output)).sentence


@pytest.mark.parametrize("reply", [{}, {"status": None}, {"status": 1}, {"status": "OK"}])
def test_a_status_of_another_kind_fails(reply):
    assert "expected status" in only(judge(made.clamp(), reply, "f8")).sentence


def test_outputs_must_be_an_object():
    assert (
        "expected an object"
        in only(judge(made.clamp(), {"status": "ok", "output": [1]}, "f8")).sentence
    )


def test_an_unsupported_case_is_not_judged():
    assert judge(made.clamp(), {"status": "unsupported"}, "f8").result == NOT_SUPPORTED


def test_nan_and_infinity_pass_only_where_they_are_expected():
    case = made.clamp()._replace(expected={"multipliers": made.values([math.nan, math.inf])})
    assert ask(case, multipliers=["nan", "inf"]).result == PASSED
    assert ask(case, multipliers=["nan", "-inf"]).result == FAILED
    assert ask(case, multipliers=["inf", "nan"]).result == FAILED


def test_bad_input_must_be_refused_and_the_offender_may_be_left_out():
    case = made.bad_input()
    assert ask(case, status="refused").result == PASSED
    assert ask(case, status="refused", offender=0).result == PASSED
    assert only(ask(case, status="refused", offender=1)).output == "offender"
    assert "must refuse" in only(ask(case)).sentence


def test_good_input_must_be_answered():
    case = made.fine_input()
    assert ask(case).result == PASSED
    reply = {"status": "refused", "message": "too flat"}
    assert "too flat" in only(judge(case, reply, "f8")).sentence


def test_an_acceptable_case_may_be_refused_or_answered_rightly():
    case = made.near_tie()
    assert ask(case, status="refused").result == PASSED
    assert ask(case, meets=1).result == PASSED
    assert ask(case, meets=0).result == FAILED


@pytest.mark.parametrize("bad", [2, True, 1.0, "1", None])
def test_a_flag_is_0_or_1(bad):
    assert only(ask(made.apart(), meets=bad)).output == "meets"


def test_pairs_may_be_written_in_any_order_and_more_may_be_listed():
    case = made.pairs()
    assert ask(case, vertex_face=[3, 2, 0, 1], edge_edge=[]).result == PASSED
    more = [3, 0, 1, 2, 3, 0, 1, 2]
    assert ask(case, vertex_face=more, edge_edge=[]).result == PASSED


def test_a_missed_pair_is_named():
    wrong = only(ask(made.pairs(), vertex_face=[], edge_edge=[]))
    assert wrong.sentence == "the vertex-face pair (3, 0, 1, 2) meets on the path and is missing"


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ([3, 0, 1], "rows of 4"),
        ([3, 0, 1, 4], "no vertex"),
        ([3, 0, 1, -1], "no vertex"),
        ([0, 0, 1, 2], "common vertex"),
        ([2, 0, 1, 3], "no face of the mesh"),
    ],
)
def test_what_is_listed_must_be_a_pair_of_the_mesh(row, said):
    outcome = ask(made.pairs(), vertex_face=[3, 0, 1, 2, *row], edge_edge=[])
    assert said in only(outcome).sentence


def test_edges_of_pairs_are_edges_of_the_mesh():
    outcome = ask(made.pairs(), vertex_face=[3, 0, 1, 2], edge_edge=[0, 1, 2, 3])
    assert "no edge of the mesh" in only(outcome).sentence
    inputs = {**made.SHEET, "positions_t0": [0.0] * 18, "faces": [0, 1, 2, 3, 4, 5]}
    expected = {"edge_edge": {"judge": "superset", "kind": "edge-edge", "pairs": [0, 1, 3, 4]}}
    case = made.case("S1-edges-01", inputs, expected)
    assert ask(case, edge_edge=[4, 3, 1, 0]).result == PASSED
    assert ask(case, edge_edge=[4, 0, 1, 3]).result == FAILED
    assert "common vertex" in ask(case, edge_edge=[0, 1, 1, 2]).differences[0].sentence


def test_a_time_may_be_early_and_never_late():
    case = made.time_of_impact()
    exact, early = ask(case, meets=1, toi=0.5), ask(case, meets=1, toi=0.4999)
    assert (exact.result, exact.early) == (PASSED, False)
    assert (early.result, early.early) == (PASSED, True)
    assert ask(case, meets=1, toi=0.5 + 4 * EPS).result == PASSED
    assert only(ask(case, meets=1, toi=0.5 + 8 * EPS)).sentence.startswith("the time is late")
    assert "too early" in only(ask(case, meets=1, toi=0.499)).sentence
    assert only(ask(case, meets=1)).output == "toi"


def test_what_is_not_expected_of_a_pair_that_is_apart_is_not_judged():
    assert ask(made.apart(), meets=0, toi="nan").result == PASSED


def test_zones_may_have_any_numbers():
    case = made.groups()
    assert ask(case, zone_of_impact=[7, 7, 2, -1]).result == PASSED
    assert ask(case, zone_of_impact=[-2, -2, 5, -1]).result == PASSED


@pytest.mark.parametrize(
    ("zones", "said"),
    [
        ([0, 1, 2, -1], "element 1 belongs to the group of element 0"),
        ([0, 0, 0, -1], "element 2 belongs to another group than element 0"),
        ([0, 0, 1, 2], "element 3 belongs to no group"),
        ([0, 0, -1, -1], "element 2 belongs to a group"),
    ],
)
def test_wrong_zones_are_named(zones, said):
    assert said in only(ask(made.groups(), zone_of_impact=zones)).sentence


def test_a_number_in_a_range_passes():
    bounds = {"judge": "range", "low": 0.25, "high": 0.5, "scale": 1.0, "multiple": 4}
    case = made.time_of_impact()._replace(expected={"toi": bounds})
    for got, result in ((0.25, PASSED), (0.5, PASSED), (0.2, FAILED), (0.6, FAILED)):
        assert ask(case, toi=got).result == result


WEIGHTS = [1.0, -0.5, -0.25, -0.25]


def test_a_frame_passes_by_its_properties():
    assert ask(made.frame(), weights=WEIGHTS, normal=[0, 0, 1]).result == PASSED
    assert ask(made.frame(), weights=WEIGHTS, normal=[0.6, 0, 0.8]).result == PASSED


@pytest.mark.parametrize(
    ("normal", "said"),
    [
        ([0, 0, -1], "wrong side"),
        ([0, 0, 1.001], "length"),
        ([0, 0, 1e300], "length"),
        ([1, 0, 0], "at least 0.5"),
    ],
)
def test_a_wrong_normal_is_named(normal, said):
    assert said in only(ask(made.frame(), weights=WEIGHTS, normal=normal)).sentence


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        ([1.0, -0.5, -0.5, -0.25], "second side: expected -1, got -1.25"),
        ([1.0, -0.25, -0.5, -0.25], "not the closest"),
        ([1.0, -1.5, 0.25, 0.25], "negative or 0"),
        ([1e308, -1e308, -1e308, -1e308], "the sum of the weights"),
    ],
)
def test_wrong_weights_are_named(weights, said):
    outcome = ask(made.frame(), weights=weights, normal=[0, 0, 1])
    first = outcome.differences[0]
    assert (first.output, said in first.sentence) == ("weights", True)


def test_a_normal_without_weights_cannot_be_judged():
    outcome = ask(made.frame(), normal=[0, 0, 1])
    assert [item.output for item in outcome.differences] == ["weights", "normal"]
    assert "cannot be judged without weights" in outcome.differences[1].sentence


def test_multipliers_pass_by_the_conditions_of_the_optimum():
    case = made.optimum()
    assert ask(case, feasible=1, positions=made.SOLVED, multipliers=[1.0]).result == PASSED
    assert ask(case, feasible=1, positions=made.SOLVED).result == PASSED  # may be left out


@pytest.mark.parametrize(
    ("z", "multiplier", "said"),
    [
        (0.1, -1.0, "is negative"),
        (0.1, 0.5, "x - y is 0.5 m and M^-1 A^T l is 0.25 m"),
        (0.35, 1.5, "pushes (1.5 kg) and is not in contact"),
        (-0.4, 0.0, "violated by 0.5 m"),
    ],
)
def test_wrong_multipliers_are_named(z, multiplier, said):
    positions = [0.25, 0.25, z, *made.SOLVED[3:]]
    case = made.optimum()
    case = case._replace(expected={"multipliers": case.expected["multipliers"]})
    outcome = ask(case, positions=positions, multipliers=[multiplier])
    assert outcome.result == FAILED
    assert any(said in item.sentence for item in outcome.differences)


def test_gaps_may_have_a_scale_of_their_own_and_types_a_multiple_of_their_own():
    case = made.optimum()
    kkt = {"judge": "kkt", "scale": [1.0], "gap_scale": [0.0], "multiple": 1, "multiple_f8": 2**50}
    case = case._replace(expected={"multipliers": kkt})
    positions = [0.25, 0.25, 0.1 + 2.0**-30, *made.SOLVED[3:]]
    near, far = {"positions": positions, "multipliers": [1.0]}, 8.0 * 2.0**-30
    assert [d.output for d in ask(case, **near).differences] == ["multipliers"]  # only the gap
    kkt["gap_scale"] = [far]
    assert ask(case, **near).result == PASSED
    assert ask(case, "f4", **near).result == FAILED


def test_multipliers_cannot_be_judged_without_positions():
    outcome = ask(made.optimum(), feasible=1, positions=[None] * 12, multipliers=[1.0])
    assert "cannot be judged without positions" in outcome.differences[-1].sentence


def test_the_element_of_an_array_of_rows_is_row_and_column():
    positions = list(made.SOLVED)
    positions[7] = 9.0
    assert place(only(ask(made.optimum(), feasible=1, positions=positions))) == "positions (2, 1)"


def step_ends(z, x=0.0):
    """Return end positions of `made.step`: height of the vertex, and one corner of the face."""
    return [x, *made.SHEET["positions_t1"][1:11], z]


def test_a_free_path_is_certified():
    assert ask(made.step(), free=1, positions=step_ends(0.125)).result == PASSED
    assert ask(made.step(), "f4", free=1, positions=step_ends(0.125)).result == PASSED


def test_a_path_that_is_said_to_be_free_and_is_not_fails():
    wrong = only(ask(made.step(), free=1, positions=step_ends(-1.0)))
    assert "1 pairs meet on it; the first is the vertex-face pair (3, 0, 1, 2)" in wrong.sentence


def test_positions_that_are_farther_than_needed_fail():
    assert "farther" in only(ask(made.step(), free=1, positions=step_ends(0.5))).sentence


def test_pinned_vertices_are_judged_bit_for_bit():
    wrong = only(ask(made.step(), free=1, positions=step_ends(0.125, 1e-300)))
    assert place(wrong) == "positions (0, 0)"
    assert ask(made.step(), free=1, positions=step_ends(0.125, -0.0)).result == PASSED


def test_a_path_that_is_not_said_to_be_free_is_asked_nothing_else():
    for x in (0.0, 1e-300):  # the second one moves a pinned vertex
        outcome = ask(made.step(), free=0, positions=step_ends(-1.0, x))
        assert [item.output for item in outcome.differences] == ["free"]


def test_a_reply_has_to_say_whether_its_path_is_free():
    case = made.step()
    case = case._replace(expected={"positions": case.expected["positions"]}, verdict=ACCEPTABLE)
    assert ask(case, free=0, positions=step_ends(-1.0)).result == PASSED
    assert ask(case, positions=step_ends(-1.0)).result == FAILED
    assert ask(case, free=2, positions=step_ends(-1.0)).result == FAILED


def test_end_positions_are_rounded_as_the_port_holds_them():
    """A port may print nine digits of a float32, which is another float64."""
    inputs = {**made.SHEET, "masses": [1.0] * 4, "pinned": [0] * 4, "thickness": 0.125}
    inputs["positions_t1"] = [*inputs["positions_t0"][:11], 0.100000001490116]
    expected = {**made.step().expected["positions"], "objective_at_most": 0.0}
    case = made.step()._replace(inputs=inputs)
    case = case._replace(expected={**case.expected, "positions": expected})
    assert ask(case, "f4", free=1, positions=step_ends(0.1)).result == PASSED
    assert "farther" in only(ask(case, free=1, positions=step_ends(0.1))).sentence


def test_positions_that_ignore_the_thickness_fail():
    case = made.step()
    case.expected["positions"]["objective_at_least"] = 1.25
    assert ask(case, free=1, positions=step_ends(0.125)).result == PASSED
    assert "nearer" in only(ask(case, free=1, positions=step_ends(2.0**-10))).sentence


RUBBISH = [
    b'{"status": "ok", "output": {"multipliers": {"a": 1}}}',
    b'{"status": "ok", "output": null}',
    b'{"status": ["ok"], "output": {}}',
    b'{"status": "ok", "output": {"": "\\ud800"}}',
    b'{"status": "ok", "output": {"multipliers": ["\\ud800", 1e999]}}',
    b'{"status": "refused", "message": {"a": "\\u0000"}}',
    b'{"status": "ok", "output": {"multipliers": [[[[]]], -0]}}',
]


@pytest.mark.parametrize("line", RUBBISH, ids=range(len(RUBBISH)))
@pytest.mark.parametrize("case", [*made.small_cases(), made.step()], ids=lambda case: case.id)
def test_no_reply_raises_an_exception(case, line):
    reply = object_of(line)
    outcome = judge(case, reply, "f8")
    assert outcome.result in (PASSED, FAILED)
    assert all(isinstance(item.sentence, str) for item in outcome.differences)
    names = {field.name for field in STAGE[case.stage].outputs}
    everything = {"status": "ok", "output": {name: [None, {}] for name in names}}
    expects_outputs = case != made.fine_input()
    assert (judge(case, everything, "f4").result == FAILED) == expects_outputs

"""The plan: what it leaves out changes no result, and it lists what it leaves out."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.options import RULES, Options
from tests.helpers.shapes import grid, two_sheets, vertex_over_face
from tests.helpers.steps import load_step

SCENES = ("cloth-on-sphere", "moving-obstacle", "at-rest", "pinch-free", "pinch-blocked")
QUICK_STEPS = (
    "cloth-funnel-clean",
    "crumple-10k",
    "ipctd-thick-cloth",
    "ipctd-two-cubes-far-intersecting",
    "pinch-blocked-10k",
    "pinch-free-20k",
    "sheets-10k",
    "sphere-10k",
    "stack-6k",
)
SLOW_STEPS = ("sheets-50k", "armadillo-rollers", "cloth-ball-clean")


def lines(scene, **options):
    """Return {part: line} of the plan of a scene."""
    needed = izo_ref.plan(scene, Options(**options))
    return {line.stage: line for line in needed.lines}


def far_apart(*scenes):
    """Join several scenes into one, so far apart that they cannot meet."""
    firsts = np.cumsum([0] + [len(scene.masses) for scene in scenes])
    shifts = 10.0 * np.arange(len(scenes))[:, None] * (1.0, 0.0, 0.0)
    return izo_ref.Scene(
        np.concatenate([s.positions_t0 + d for s, d in zip(scenes, shifts, strict=True)]),
        np.concatenate([s.positions_t1 + d for s, d in zip(scenes, shifts, strict=True)]),
        np.concatenate([s.faces + k for s, k in zip(scenes, firsts[:-1], strict=True)]),
        np.concatenate([s.masses for s in scenes]),
        np.concatenate([s.pinned for s in scenes]),
    )


def same_results(a, b):
    """Check that two results have the same bits and the same history."""
    for x, y in zip(a.impacts, b.impacts, strict=True):
        np.testing.assert_array_equal(x, y)
    np.testing.assert_array_equal(a.positions, b.positions)
    np.testing.assert_array_equal(a.multipliers, b.multipliers)
    assert a.status is b.status
    assert [row.found for row in a.history] == [row.found for row in b.history]


def check_step(name):
    """Resolve a step with the plan and without it, and compare."""
    scene = load_step(name)
    needed = izo_ref.resolve(scene, 1e-4)
    same_results(needed, izo_ref.resolve(scene, 1e-4, options=Options(plan=("closed-form",))))
    everything = izo_ref.resolve(scene, 1e-4, options=Options(plan="everything"))
    assert everything.status is needed.status
    # Zones agree to their tolerance, and the same judge finds each optimal.
    assert everything.converged == needed.converged
    assert everything.objective == pytest.approx(needed.objective, rel=1e-6)


@pytest.mark.parametrize(
    "name", [*SCENES, *(pytest.param(name, marks=pytest.mark.data) for name in QUICK_STEPS)]
)
def test_a_step_has_the_same_bits_with_and_without_the_plan(name):
    check_step(name)


@pytest.mark.data
@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW_STEPS)
def test_a_long_step_has_the_same_bits_with_and_without_the_plan(name):
    check_step(name)


@pytest.mark.parametrize("left_out", sorted(set(RULES) - {"closed-form"}))
@pytest.mark.parametrize("pinned_below", [False, True])
def test_each_rule_alone_changes_no_bit(rng, left_out, pinned_below):
    scene = two_sheets(rng, pinned_below=pinned_below)
    scene.positions_t1[::3] = scene.positions_t0[::3]  # so that some vertices rest
    rules = tuple(rule for rule in RULES if rule != left_out)
    result = izo_ref.resolve(scene)
    assert len(result.impacts.toi) > 10
    same_results(result, izo_ref.resolve(scene, options=Options(plan=rules)))


def test_unchanged_large_zones_end_with_the_same_bits(rng):
    """With `small_zone=1`, all zones of several impacts are solved from their last solution."""
    scene = far_apart(two_sheets(rng), two_sheets(rng, n=6), two_sheets(rng, n=10))
    rules = tuple(rule for rule in RULES if rule != "changed-zones")
    once = izo_ref.resolve(scene, options=Options(small_zone=1))
    again = izo_ref.resolve(scene, options=Options(small_zone=1, plan=rules))
    same_results(once, again)
    assert [row.solved for row in again.history] != [row.solved for row in once.history]


def test_closed_form_changes_last_digits_only(rng):
    scene = vertex_over_face()
    rules = tuple(rule for rule in RULES if rule != "closed-form")
    a, b = izo_ref.resolve(scene), izo_ref.resolve(scene, options=Options(plan=rules))
    assert len(a.impacts.toi) == 1
    # Measured: differences of at most 2.1e-14, and of at most 7.4e-13 of the coordinate.
    np.testing.assert_allclose(a.positions, b.positions, rtol=1e-12, atol=1e-14)


def test_a_scene_at_rest_is_not_searched():
    scene = vertex_over_face(drop=0.0)
    assert lines(scene)["detection"].needed == "none"
    assert lines(scene, plan="everything")["detection"].needed == "all"
    result = izo_ref.resolve(scene)
    assert result.certificate.candidates == 0
    assert result.history[0].candidates == 0
    np.testing.assert_array_equal(result.positions, scene.positions_t1)


# A face in the plane z = 0, and another one that touches it from above, or goes through it.
BELOW = [[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]
ABOVE = {
    "touching": [[1.0, 1, 0], [1, 2, 1], [2, 1, 1]],
    "excluded": [[1.0, 1, -1], [1, 2, 1], [2, 1, 1]],
}


@pytest.mark.parametrize("mode", ["ratchet", "exclude"])
def test_a_scene_at_rest_that_touches_is_not_called_free_of_contact(mode):
    """The pair is an impact from t = 0 on, so detection, solving and rechecking are needed."""
    points = np.array(BELOW + ABOVE["touching"])
    scene = izo_ref.Scene(points, points, [[0, 1, 2], [3, 4, 5]], initial_intersections=mode)
    assert scene.touching is not None
    assert len(izo_ref.find_impacts(scene).toi) > 0
    needed = lines(scene)
    for stage in ("detection", "pairs at rest", "later detections", "later solves"):
        assert needed[stage].needed == "some", stage
    assert not any("free of contact" in line.reason for line in needed.values())
    result = izo_ref.resolve(scene, 0.1)
    assert result.history[0].found > 0
    assert result.status is izo_ref.Status.FREE


@pytest.mark.parametrize("mode", ["ratchet", "exclude"])
def test_a_scene_at_rest_that_crosses_needs_no_detection_but_is_not_free_of_contact(mode):
    points = np.array(BELOW + ABOVE["excluded"])
    scene = izo_ref.Scene(points, points, [[0, 1, 2], [3, 4, 5]], initial_intersections=mode)
    assert scene.touching is None
    assert scene.excluded is not None
    assert len(izo_ref.find_impacts(scene).toi) == 0
    needed = lines(scene)
    for stage in ("detection", "pairs at rest"):
        assert needed[stage].needed == "none"
        assert needed[stage].reason.endswith("the pairs that meet at the start are left out")


def test_a_rule_that_is_switched_off_is_named_and_leaves_nothing_out():
    line = lines(vertex_over_face(), plan="everything")["exact arithmetic"]
    assert (line.rule, line.needed) == ("float-verdicts", "all")


def test_a_component_that_nothing_reaches_is_in_no_tree(rng):
    scene = two_sheets(rng)
    points, faces = grid(5, 50.0)
    n = len(scene.positions_t0)
    start, end = (np.vstack((x, points)) for x in (scene.positions_t0, scene.positions_t1))
    larger = izo_ref.Scene(start, end, np.vstack((scene.faces, faces + n)))
    line = lines(larger)["components in trees"]
    assert line.needed == "some"
    assert f"1 of 3 components, with {len(faces)} of {len(larger.faces)} triangles" in line.reason
    proposed = [izo_ref.certify_path(s, s.positions_t1) for s in (scene, larger)]
    assert proposed[0].candidates == proposed[1].candidates
    every = izo_ref.certify_path(larger, end, frozenset())
    assert every.candidates > proposed[1].candidates
    for a, b in zip(proposed[1].meeting, every.meeting, strict=True):
        np.testing.assert_array_equal(a, b)


def test_the_plan_is_kept_and_prints_itself(rng):
    scene = two_sheets(rng)
    result = izo_ref.resolve(scene)
    assert result.plan == izo_ref.plan(scene)
    text = str(result.plan)
    assert len(text.splitlines()) == len(result.plan.lines) + 1
    for line in result.plan.lines:
        assert line.stage in text
        assert line.reason in text
    assert {line.rule for line in result.plan.lines} <= {*RULES, ""}


def test_a_rule_that_is_switched_off_leaves_nothing_out(rng):
    scene = two_sheets(rng)
    for stage, line in lines(scene, plan="everything").items():
        if lines(scene)[stage].rule:
            assert line.needed == "all"


@pytest.mark.parametrize("plan", ["nothing", ("still", "stil")])
def test_unknown_rules_are_named(plan):
    with pytest.raises(izo_ref.base.errors.OptionError, match=r"plan.*'(nothing|stil)'"):
        Options(plan=plan)

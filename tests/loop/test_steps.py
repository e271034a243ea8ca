"""Real steps from start to end, against recorded results of peers and independent judges."""

import functools

import numpy as np
import pytest

import izo_ref
from izo_ref import Status
from tests.helpers import own_scenes
from tests.helpers.steps import load_step, peers
from validation import judge
from validation.scenes import stored

STEPS = [
    "armadillo-rollers",
    "cloth-ball-clean",
    "cloth-funnel-clean",
    "crumple-10k",
    "ipctd-thick-cloth",
    "ipctd-two-cubes-far-intersecting",
    "pinch-free-20k",
    "sheets-10k",
    "sheets-50k",
    "sphere-10k",
    "stack-6k",
]
SLOW = {"cloth-ball-clean"}
THICKNESS = 1e-4


@functools.cache
def resolved(name):
    """Return a step and its result; each process resolves a step once."""
    scene = load_step(name)
    return scene, izo_ref.resolve(scene, THICKNESS)


def ratio_to_arcsim(name):
    """Return the objective of our result divided by the recorded one of ARCSim."""
    return resolved(name)[1].objective / peers()[name]["arcsim_0_2_1"]["objective_g"]


def check_that_it_ends_free(scene, result):
    """Check what every step that can be solved has to satisfy."""
    assert result.status is Status.FREE
    assert result.certificate.free
    assert len(result.certificate.meeting_toi) == 0
    for residuals in result.residuals:
        assert residuals.solved(1e-9, 1e-9)
    np.testing.assert_array_equal(result.positions[scene.pinned], scene.positions_t1[scene.pinned])
    assert result.certificate.exact <= 1e-4 * result.certificate.candidates
    path_facts, certificate = judge.path(scene, result.positions)
    end_facts, _ = judge.end(certificate)
    facts = [fact for fact in path_facts + end_facts if not fact.answer.startswith("not asked")]
    assert [fact.by for fact in facts if not fact.passed] == []


@pytest.mark.parametrize("name", own_scenes.FREE_STEPS)
def test_scene_ends_free(name):
    """The objective is compared with the recorded one in tests/data/test_scenes.py."""
    check_that_it_ends_free(own_scenes.scene(name), own_scenes.result(name))


@pytest.mark.parametrize("number", range(len(stored.index()["sleeve"]["steps"])))
def test_animation_ends_free_frame_by_frame(number):
    check_that_it_ends_free(*own_scenes.results("sleeve")[number])


@pytest.mark.data
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in SLOW)) for n in STEPS]
)
def test_step_ends_free(name):
    scene, result = resolved(name)
    check_that_it_ends_free(scene, result)
    ratio = ratio_to_arcsim(name)
    print(
        f"\n{name}: objective {ratio:.5f} of ARCSim's, {len(result.history)} detections, "
        f"{result.timings['total']:.1f} s"
    )
    assert ratio <= 1.005


@pytest.mark.data
def test_objectives_are_below_those_of_arcsim_in_the_geometric_mean():
    """A single step may be a little above 1; the mean is over all steps but the slow one."""
    ratios = [ratio_to_arcsim(name) for name in STEPS if name not in SLOW]
    mean = float(np.exp(np.mean(np.log(ratios))))
    print(f"\ngeometric mean of {len(ratios)} steps: {mean:.4f} of ARCSim's")
    assert mean <= 0.995


def test_no_judge_passes_the_proposed_positions():
    """Each of the four judges can fail a path."""
    scene = own_scenes.scene("mass-ratios")
    facts, certificate = judge.path(scene, scene.positions_t1)
    facts += judge.end(certificate)[0]
    assert len(facts) == 4
    assert [fact.by for fact in facts if fact.passed] == []


def test_an_intersecting_frame_of_an_animation_is_refused_as_start():
    arrays = stored.load("sleeve")
    start, end = arrays["positions"][-2:]
    with pytest.raises(izo_ref.IzoError, match="without intersections"):
        izo_ref.Scene(start, end, arrays["faces"])


@pytest.mark.data
def test_cloth_ball_is_refused_because_its_start_intersects():
    with pytest.raises(izo_ref.IzoError, match="without intersections"):
        load_step("cloth-ball")


@pytest.mark.parametrize(
    "name", ["pinch-blocked", pytest.param("pinch-blocked-10k", marks=pytest.mark.data)]
)
def test_pinch_blocked_is_blocked_with_pairs_and_time(name):
    scene = load_step(name, prescribed="exclude")
    result = izo_ref.resolve(scene, THICKNESS)
    assert result.status is Status.BLOCKED
    assert 0.0 < result.time_free < 1.0
    assert scene.pinned[result.certificate.excluded.nodes].all(axis=1).any()
    part = scene.positions_t0 + 0.999 * result.time_free * (result.positions - scene.positions_t0)
    assert izo_ref.certify_path(scene, part).free

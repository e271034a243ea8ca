"""The check of a step: which judges reject what, and what the command writes."""

import json
import sys
import time

import numpy as np
import pytest

import izo_ref
from izo_ref.app.files import SavedResult, load_result, save_result, save_scene
from izo_ref.base.errors import SizeError
from tests.helpers.seams import seams
from tests.helpers.shapes import grid, two_sheets, vertex_over_face
from tests.helpers.views import content_of
from validation import judge
from validation.__main__ import main
from validation.check import check, verdict_line
from validation.oracles import ipc
from validation.oracles.answer import mass_norm
from validation.report.page import verdict_page

needs_ipctk = pytest.mark.skipif(bool(ipc.unusable()), reason=f"ipctk: {ipc.unusable()}")


def positions_only(positions):
    """Return a saved result that has positions and no zones."""
    return SavedResult(positions, None, None, None)


def failed(verdict):
    """Return the judges that rejected, and check that the verdict agrees with them."""
    assert verdict.passed is not any(fact.passed is False for fact in verdict.facts)
    return {fact.by for fact in verdict.facts if fact.passed is False}


CERTIFICATE, OTHERS = "izo_ref.certify_path", "ipctk Tight Inclusion, hits decided by flint"


def test_our_own_result_passes(rng):
    verdict = check(two_sheets(rng), None, 1e-3)
    assert failed(verdict) == set()
    asked = {fact.by for fact in verdict.facts}
    assert {CERTIFICATE, OTHERS, "python-fcl", "ipctk", "exact rational arithmetic"} <= asked


@needs_ipctk
def test_the_proposed_positions_fail_by_every_judge():
    scene = vertex_over_face()
    verdict = check(scene, positions_only(scene.positions_t1), 1e-3)
    assert failed(verdict) == {CERTIFICATE, OTHERS, "python-fcl", "ipctk"}
    assert [3, 0, 1, 2] in verdict.meeting.nodes.tolist()
    assert verdict.crossing.tolist() == [[0, 1]]


@needs_ipctk
@pytest.mark.parametrize(("height", "through"), [(1e-9, False), (-1e-9, True)])
def test_a_vertex_pushed_through_by_a_nanometre_is_found(height, through):
    scene = vertex_over_face()
    end = scene.positions_t0.copy()
    end[3, 2] = height
    end += 0.1 * np.arange(3)  # without this drift, boxes alone would separate the pair
    verdict = check(scene, positions_only(end), 1e-3)
    assert (failed(verdict) >= {CERTIFICATE, OTHERS, "python-fcl"}) is through
    assert verdict.passed is not through


@needs_ipctk
def test_layers_that_swapped_are_found_though_the_end_is_free():
    """A check of the end positions alone cannot see this."""
    a, faces = grid(6)
    start = np.concatenate((a, a + (0.01, 0.02, 0.1)))
    end = np.concatenate((a + (0.0, 0.0, 0.2), a + (0.01, 0.02, 0.1)))
    scene = izo_ref.Scene(start, end, np.concatenate((faces, faces + 36)))
    assert failed(check(scene, positions_only(end), 1e-3)) == {CERTIFICATE, OTHERS}


def test_a_pinned_vertex_that_was_moved_is_found():
    scene = vertex_over_face(pinned=(True, True, True, False))
    result = izo_ref.resolve(scene, 1e-3)
    end = result.positions.copy()
    end[1, 0] += 1e-12
    verdict = check(scene, positions_only(end), 1e-3)
    assert failed(verdict) == {"comparison"}
    assert "first is vertex 1" in next(f.answer for f in verdict.facts if f.by == "comparison")


def test_a_result_in_float32_has_its_pinned_vertices_where_float32_can(tmp_path):
    made = vertex_over_face()
    start, end = made.positions_t0 + 0.1, made.positions_t1 + 0.1
    scene = izo_ref.Scene(start, end, made.faces, pinned=[1, 1, 1, 0, 0, 0])
    end = izo_ref.resolve(scene, 1e-3).positions.astype(np.float32)
    assert (end != scene.positions_t1)[:3].any()
    save_result(tmp_path / "out.npz", positions_only(end))
    verdict = check(scene, load_result(tmp_path / "out.npz"), 1e-3)
    assert "comparison" not in failed(verdict)
    end[1, 0] = np.nextafter(end[1, 0], np.float32(2.0))
    assert "comparison" in failed(check(scene, positions_only(end), 1e-3))


def test_a_report_does_not_replace_the_step(tmp_path, capsys):
    step = tmp_path / "step.npz"
    save_scene(step, vertex_over_face())
    content = step.read_bytes()
    assert main(["check", str(step), "--json", str(step)]) == 2
    assert "is the same file as the step" in capsys.readouterr().err
    assert step.read_bytes() == content


def test_zones_that_are_not_optimal_are_found(rng):
    """The first result is farther from the proposed positions than its own impacts require."""
    scene = two_sheets(rng, 5)
    result = izo_ref.resolve(scene, 1e-3)
    end = scene.positions_t0 + 0.99 * (result.positions - scene.positions_t0)
    saved = SavedResult(end, result.thickness, result.impacts, result.multipliers)
    assert failed(check(scene, saved)) >= {"izo_ref.residuals", "exact rational arithmetic"}
    nothing = SavedResult(result.positions, 1e-3, result.impacts, 0.0 * result.multipliers)
    assert failed(check(scene, nothing)) == {"izo_ref.residuals"}


def test_other_results_are_compared_by_objective_if_they_are_free(rng):
    scene = two_sheets(rng)
    result = izo_ref.resolve(scene, 1e-3)
    verdict = check(scene, positions_only(result.positions), 1e-3)
    assert verdict.passed
    assert any("not judged" in fact.answer for fact in verdict.facts)
    back = 0.5 * (scene.positions_t0 + result.positions)
    known = {"half": back, "proposal": scene.positions_t1}
    verdict = check(scene, positions_only(back), 1e-3, known=known)
    # The proposed path is not free, so it has no objective to compare.
    assert set(verdict.objectives) == {"izo_ref.resolve", "half"}
    assert verdict.objectives["half"] > verdict.objectives["izo_ref.resolve"]


@needs_ipctk
def test_pairs_that_intersect_at_the_start_do_not_fail_a_result():
    scene = vertex_over_face()
    start = scene.positions_t0.copy()
    start[3, 2] = -0.5
    end = scene.positions_t0  # the vertex moves back up through the face
    crossing = izo_ref.Scene(start, end, scene.faces, initial_intersections="exclude")
    verdict = check(crossing, positions_only(end), 1e-3)
    assert verdict.passed
    assert any("left out" in fact.answer for fact in verdict.facts)


def test_a_judge_that_is_not_usable_is_reported_as_not_asked(monkeypatch):
    monkeypatch.setattr(ipc, "unusable", lambda: "no such instruction")
    scene = vertex_over_face()
    verdict = check(scene, positions_only(scene.positions_t1), 1e-3)
    assert failed(verdict) == {CERTIFICATE, "python-fcl"}
    not_asked = [fact for fact in verdict.facts if "not asked: no such instruction" in fact.answer]
    assert [fact.by for fact in not_asked] == [OTHERS, "ipctk"]


def test_a_missing_package_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "validation.check", None)
    assert main(["check", "step.npz"]) == 2
    assert "pip install -e .[validation]" in capsys.readouterr().err


def test_the_command_writes_its_verdict(tmp_path, capsys):
    scene = vertex_over_face()
    save_scene(tmp_path / "step.npz", scene)
    save_result(tmp_path / "bad.npz", positions_only(scene.positions_t1))
    step = str(tmp_path / "step.npz")
    files = ["--json", str(tmp_path / "v.json"), "--html", str(tmp_path / "v.html")]
    assert main(["check", step, "--thickness", "1e-3", *files]) == 0
    assert json.loads((tmp_path / "v.json").read_text())["passed"] is True
    page = (tmp_path / "v.html").read_text()
    content = content_of(page)
    assert [side["name"] for side in content["sides"]] == ["Proposed", "Judged"]
    assert [side["nPairs"][1] for side in content["sides"]] == [1, 0]
    assert "<td>path is free</td>" in page

    assert main(["check", step, "--result", str(tmp_path / "bad.npz"), *files]) == 1
    content = json.loads((tmp_path / "v.json").read_text())
    assert content["passed"] is False
    assert content["meeting"]["vertex_face"] >= 1
    assert content["crossing_faces"]["first"] == [[0, 1]]
    page = (tmp_path / "v.html").read_text()
    assert "meet at t = 0.5" in page
    assert "face (0 1 2) and face (3 4 5) cross" in page
    assert '<tr class="failed">' in page
    assert content_of(page)["sides"][1]["nPairs"][1] >= 2
    assert "FAILED" in capsys.readouterr().out


def test_a_result_file_with_its_zones_is_judged_by_them(tmp_path, capsys):
    scene = vertex_over_face()
    save_scene(tmp_path / "step.npz", scene)
    save_result(tmp_path / "out.npz", izo_ref.resolve(scene, 1e-3))
    arguments = ["check", str(tmp_path / "step.npz"), "--result", str(tmp_path / "out.npz")]
    assert main(arguments) == 0
    assert "1 zones, 0 not to tolerance" in capsys.readouterr().out


def test_bad_input_is_refused_and_nothing_is_written(tmp_path, capsys):
    scene = vertex_over_face()
    save_scene(tmp_path / "step.npz", scene)
    save_result(tmp_path / "short.npz", positions_only(scene.positions_t0[:4]))
    np.savez(tmp_path / "nan.npz", positions=np.nan * scene.positions_t0)
    step = str(tmp_path / "step.npz")
    for name, word in (("short", "shape"), ("nan", "finite"), ("none", "cannot be read")):
        out = ["--json", str(tmp_path / "v.json")]
        assert main(["check", step, "--result", str(tmp_path / f"{name}.npz"), *out]) == 2
        assert word in capsys.readouterr().err
        assert not (tmp_path / "v.json").exists()
    result = izo_ref.resolve(scene, 1e-3)
    wrong = result.impacts._replace(nodes=result.impacts.nodes + 100)
    save_result(
        tmp_path / "wrong.npz", SavedResult(result.positions, 1e-3, wrong, result.multipliers)
    )
    assert main(["check", step, "--result", str(tmp_path / "wrong.npz")]) == 2
    assert "impact_nodes" in capsys.readouterr().err


@needs_ipctk
def test_judges_that_do_not_decide_are_counted_apart(tmp_path, capsys, monkeypatch):
    """What the other judges prove still stands; on a busy machine they may take any time."""
    true_limited = judge.limited

    def limited(limits, asked, *args):
        is_slow = asked is judge._path_by_others
        return true_limited(limits if is_slow else limits._replace(seconds=3600.0), asked, *args)

    monkeypatch.setattr(judge, "limited", limited)
    monkeypatch.setattr(ipc, "path_hits", lambda *_args: time.sleep(1e6))
    monkeypatch.setattr(ipc, "has_intersections", lambda *_args: np.ones(1 << 28))
    scene, report = vertex_over_face(), tmp_path / "v.json"
    save_scene(tmp_path / "step.npz", scene)
    arguments = ["check", str(tmp_path / "step.npz"), "--seconds", "1", "--gib", "0.5"]
    assert main([*arguments, "--json", str(report)]) == 0
    said = capsys.readouterr().out
    assert "not decided: needs more than 1 s" in said
    assert "not decided: needs more than 0.5 GiB of memory" in said
    assert said.endswith("passed; 2 judges did not decide within the limits\n")
    assert json.loads(report.read_text())["not_decided"] == 2
    save_result(tmp_path / "bad.npz", positions_only(scene.positions_t1))
    assert main([*arguments, "--result", str(tmp_path / "bad.npz")]) == 1
    assert "failed; 2 judges" in capsys.readouterr().out


@needs_ipctk
def test_a_welded_step_passes_by_every_judge(rng, tmp_path, capsys):
    """For ipctk, a copy would touch the faces at its place."""
    mesh = seams(rng)["pinned soup"]
    scene = izo_ref.Scene(**mesh, weld=0)
    verdict = check(scene, None, 1e-3)
    assert failed(verdict) == set()
    assert OTHERS in {fact.by for fact in verdict.facts}
    assert failed(check(scene, positions_only(scene.positions_t1), 1e-3)) >= {CERTIFICATE, OTHERS}
    np.savez(tmp_path / "step.npz", **mesh)
    assert main(["check", str(tmp_path / "step.npz"), "--thickness", "1e-3", "--weld"]) == 0
    assert main(["check", str(tmp_path / "step.npz")]) == 2
    assert "pass --weld:" in capsys.readouterr().err


@pytest.mark.parametrize("length", [-700, 700])
def test_results_of_any_size_are_judged_like_the_same_near_1(rng, length):
    scene = two_sheets(rng, 4)
    other = check(scene, None, 1e-3)
    start, end = (np.ldexp(p, length) for p in (scene.positions_t0, scene.positions_t1))
    scaled = izo_ref.Scene(start, end, scene.faces, scene.masses, scene.pinned)
    thickness = float(np.ldexp(1e-3, length))
    verdict = check(scaled, None, thickness)
    assert verdict.thickness == thickness
    assert failed(verdict) == set()
    assert np.array_equal(verdict.positions, np.ldexp(other.positions, length))
    assert [f.passed for f in verdict.facts[1:]] == [f.passed for f in other.facts]
    known = {"proposal": end, "ours": verdict.positions}
    wrong = check(scaled, positions_only(end), thickness, known=known)
    assert CERTIFICATE in failed(wrong)
    assert set(wrong.objectives) == {"izo_ref.resolve", "ours"}
    content = content_of(verdict_page("a step", scaled, wrong))
    near = content_of(
        verdict_page("a step", scene, check(scene, positions_only(scene.positions_t1)))
    )
    assert content["sides"][1]["nPairs"] == near["sides"][1]["nPairs"]
    assert content["radius"] == np.ldexp(near["radius"], length)


def test_unused_vertices_far_out_are_judged():
    scene = vertex_over_face()
    far = [1.79e308] * 3
    start, end = (np.vstack((p, far)) for p in (scene.positions_t0, scene.positions_t1))
    verdict = check(izo_ref.Scene(start, end, scene.faces), None, 1e-3)
    assert failed(verdict) == set()
    assert np.array_equal(verdict.positions[-1], far)


def test_an_impact_between_pinned_points_is_no_traceback():
    """A pinned vertex hits the pinned corner of a face whose other corners are free."""
    face = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    start = np.concatenate((face, [[0.0, 0.0, 0.5]]))
    end = start.copy()
    end[3, 2] = -0.5
    scene = izo_ref.Scene(start, end, [[0, 1, 2]], pinned=[1, 0, 0, 1])
    impacts = izo_ref.find_impacts(scene)
    assert len(impacts.toi) == 1
    verdict = check(scene, SavedResult(end, 1e-3, impacts, np.ones(1)))
    assert not verdict.passed
    assert verdict.excluded["count"] == 1
    assert "1 pair was left out" in verdict_line(verdict)
    assert "1 pair was left out" in verdict_page("a step", scene, verdict)
    questions = {fact.question: fact.passed for fact in verdict.facts}
    assert questions["each zone is optimal"] is False


@pytest.mark.parametrize("part", ["normals", "weights"])
def test_an_impact_without_a_normal_or_weights_is_no_traceback(part):
    """Its constraint asks that 0 is at least the thickness, so its zone is not solved."""
    scene = vertex_over_face()
    result = izo_ref.resolve(scene, 1e-3)
    impacts = result.impacts._replace(**{part: 0.0 * getattr(result.impacts, part)})
    saved = SavedResult(result.positions, 1e-3, impacts, result.multipliers)
    assert failed(check(scene, saved)) >= {"izo_ref.residuals"}


def test_a_message_about_a_known_result_names_its_file(tmp_path, capsys):
    scene = vertex_over_face()
    save_scene(tmp_path / "step.npz", scene)
    save_result(tmp_path / "out.npz", positions_only(scene.positions_t0))
    bad = scene.positions_t0.copy()
    bad[2, 1] = np.nan
    save_result(tmp_path / "bad.npz", positions_only(bad))
    words = ["check", str(tmp_path / "step.npz"), "--result", str(tmp_path / "out.npz")]
    assert main([*words, "--known", str(tmp_path / "bad.npz")]) == 2
    said = capsys.readouterr().err
    assert "bad.npz: positions: expected finite numbers" in said
    assert "[2, 1]" in said


@pytest.mark.parametrize("size", [1e-200, 1.0, 1e300])
def test_norms_are_those_of_any_size(size):
    """Two vertices of 4 kg and 1 kg that move by 3 m and 8 m: sqrt(4 9 + 64) = 10; one is fixed."""
    vectors = size * np.array([[3.0, 0, 0], [0, 8, 0], [5, 5, 5]])
    assert mass_norm(np.array([4.0, 1.0, np.inf]), vectors) == pytest.approx(
        10.0 * size, rel=1e-15, abs=0.0
    )


def test_a_result_that_is_far_out_is_judged_without_a_warning():
    """Warnings are errors; squares of these distances overflow."""
    scene = vertex_over_face()
    far = scene.positions_t0.copy()
    far[0, 1] = 1e300
    verdict = check(scene, positions_only(far))
    assert verdict.facts[-1].answer.startswith("the objective is inf m^2")


@pytest.mark.parametrize("part", ["normals", "weights"])
@pytest.mark.parametrize("factor", [1e300, 1e-300])
def test_impacts_of_absurd_sizes_are_refused(part, factor):
    scene = vertex_over_face()
    result = izo_ref.resolve(scene, 1e-3)
    row = [1.0, -1.0, 0.0, 0.0] if part == "weights" else [0.0, 0.0, 1.0]
    impacts = result.impacts._replace(**{part: factor * np.array([row])})
    saved = SavedResult(result.positions, 1e-3, impacts, result.multipliers)
    with pytest.raises(SizeError, match=f"{part}: .* the first is row 0"):
        check(scene, saved)


def test_an_impact_that_names_a_vertex_twice_is_refused(tmp_path, capsys):
    """All its weights together are 0 then, which was a division by zero in an oracle."""
    scene = vertex_over_face()
    save_scene(tmp_path / "step.npz", scene)
    result = izo_ref.resolve(scene, 1e-3)
    impacts = result.impacts._replace(nodes=np.array([[2, 2, 2, 2]], np.int32))
    saved = SavedResult(result.positions, 1e-3, impacts, result.multipliers)
    save_result(tmp_path / "out.npz", saved)
    words = ["check", str(tmp_path / "step.npz"), "--result", str(tmp_path / "out.npz")]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "out.npz: impact_nodes: expected four different vertices" in said
    assert "row 0: [2, 2, 2, 2]" in said

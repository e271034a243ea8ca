"""Small random steps full of trouble: no claim is wrong, and a wrong claim is found."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

import izo_ref
from izo_ref import Status
from izo_ref.base.errors import InitialIntersectionError, MassError, SizeError, WeldError
from tests.helpers.shapes import two_sheets, vertex_over_face
from validation.rows import Rows
from validation.stability_steps import __main__ as command
from validation.stability_steps import exact, judge, refusals, zones
from validation.stability_steps.case import Case
from validation.stability_steps.draw import draw
from validation.stability_steps.families import FAMILIES
from validation.stability_steps.kinds import KINDS
from validation.stability_steps.run import run_case
from validation.study import random_steps

SEED = 20261129
NUMBER = 1000  # beyond the numbers of the study
# Presets load code that nothing else of the tests needs.
SLOW_KINDS = ("presets",)


def seen(kind, families):
    """Run a case of some families, and return the statuses, judged steps and violations."""
    statuses, judged, wrong = Counter(), 0, []
    for family in families:
        case = draw(family, kind, SEED, NUMBER)
        outcome = run_case(case, np.random.default_rng(SEED))
        statuses.update(outcome.statuses)
        judged += outcome.by_oracle
        wrong += [f"{family}, {kind}, {SEED}, {NUMBER}: {line}" for line in outcome.violations]
    return statuses, judged, wrong


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in SLOW_KINDS])
def test_no_claim_of_a_random_step_is_wrong(kind):
    """Every other family meets every other kind; each is there with half of the others."""
    families = list(FAMILIES)[list(KINDS).index(kind) % 2 :: 2]
    statuses, _, wrong = seen(kind, families)
    assert wrong == []
    assert statuses.total() >= len(families)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_no_claim_of_a_random_step_of_any_family_is_wrong(kind):
    statuses, judged, wrong = seen(kind, FAMILIES)
    print(f"\n{kind}: {dict(statuses)}, {judged} judged by the second oracle")
    assert wrong == []
    assert statuses.total() >= len(FAMILIES)


def test_a_case_is_the_same_each_time():
    for family, kind in (("soup", "mixed"), ("touching", "start")):
        first, second = (draw(family, kind, 3, 4) for _ in range(2))
        np.testing.assert_array_equal(first.positions_t0, second.positions_t0)
        assert first.settings == second.settings
        other = draw(family, kind, 4, 4)
        assert first.positions_t0.tobytes() != other.positions_t0.tobytes()


def rules(lines):
    """Return the rules that some lines say are broken."""
    return {line.split(":")[0] for line in lines}


def one_corner_through(rng):
    """Return a scene of two sheets, of which one corner is pushed through the other sheet."""
    scene = two_sheets(rng, 4)
    end = scene.positions_t0.copy()
    end[16:18, 2] -= 0.1
    return izo_ref.Scene(scene.positions_t0, end, scene.faces, scene.masses)


def test_each_wrong_claim_is_found(rng):
    """A right result breaks no rule; each claim is then made wrong by itself."""
    scene = one_corner_through(rng)
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is Status.FREE

    def found(**changed):
        other = dataclasses.replace(result, **changed)
        return rules(judge.judge_result(scene, other) + zones.judge_residuals(scene, other))

    assert found() == set()
    assert found(status=Status.BLOCKED) == {"status"}
    assert found(time_free=0.5) >= {"time_free"}
    assert found(objective=result.objective * (1 + 1e-9)) == {"objective"}
    assert found(objective=np.nan) >= {"not a number >= 0", "objective"}
    untouched = np.setdiff1d(np.arange(len(result.positions)), result.impacts.nodes)
    for vertex in (untouched[0], result.impacts.nodes[0, 0]):
        moved = result.positions.copy()
        moved[vertex, 2] = np.nextafter(moved[vertex, 2], 9.0)
        is_untouched = bool(vertex == untouched[0])
        assert ("untouched" in found(positions=moved)) is is_untouched
    moved = result.positions.copy()
    moved[result.impacts.nodes[0, 0]] += 0.01
    assert {"gap", "objective"} <= found(positions=moved)
    assert "gap" in found(multipliers=result.multipliers * 1.001)
    assert "not finite" in found(multipliers=result.multipliers * np.nan)
    crossing = dataclasses.replace(result, positions=scene.positions_t1.copy())
    assert "fresh certificate" in rules(judge.judge_result(scene, crossing))


def test_a_pinned_vertex_elsewhere_is_found():
    scene = vertex_over_face(pinned=(True, True, True, False))
    result = izo_ref.resolve(scene, 1e-3)
    moved = result.positions.copy()
    moved[1, 0] = -0.0 if moved[1, 0] == 0.0 else np.nextafter(moved[1, 0], 9.0)
    wrong = judge.prescribed(scene, dataclasses.replace(result, positions=moved))
    assert rules(wrong) == {"pinned"}


def test_a_certificate_that_says_too_much_or_too_little_is_found(rng):
    """The second oracle finds a pair that was left out, and one that was named in vain."""
    scene = two_sheets(rng, 3)
    certificate = izo_ref.certify_path(scene, scene.positions_t1)
    assert len(certificate.meeting_toi) > 1
    assert exact.judge_path(certificate) == []
    one = np.arange(len(certificate.meeting_toi)) > 0
    fewer = certificate._replace(
        meeting=izo_ref.Pairs(*(column[one] for column in certificate.meeting)),
        meeting_toi=certificate.meeting_toi[one],
    )
    assert any("not named" in line for line in exact.judge_path(fewer))
    later = certificate._replace(time_free=1.0, free=True)
    assert any("time_free" in line for line in exact.judge_path(later))
    free = izo_ref.resolve(scene, 1e-3).certificate
    more = free._replace(meeting=certificate.meeting)
    assert any("named, apart" in line for line in exact.judge_path(more))


def test_a_zone_that_is_off_by_more_than_was_proved_is_found(monkeypatch, rng):
    scene = two_sheets(rng, 3)
    result = izo_ref.resolve(scene, 1e-3)
    assert zones.judge_exactly(scene, result).wrong == []
    monkeypatch.setattr(zones, "distance_bound", lambda *_: 0.0)
    counts = zones.judge_exactly(scene, result)
    assert counts.asked > 0
    assert rules(counts.wrong) == {"distance bound"}


def test_a_refusal_of_what_is_allowed_is_found():
    case = draw("few", "plain", 1, 1)
    for error in (SizeError(""), MassError("")):
        assert rules(refusals.judge_refusal(case, 0, error)) == {"refused"}
    start = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, -1], [0.25, 0.25, 1], [9, 9, 1.0]]
    )
    crossing = Case(positions_t0=start, ends=(start,), faces=np.arange(6).reshape(2, 3))
    with pytest.raises(InitialIntersectionError) as refused:
        crossing.scene()
    assert refusals.judge_refusal(crossing, 0, refused.value) == []
    apart = crossing.change(positions_t0=start + (np.arange(6) > 2)[:, None] * 5.0)
    assert rules(refusals.judge_refusal(apart, 0, refused.value)) == {"refused"}


def test_a_seam_that_a_later_step_tears_open_may_be_refused():
    start = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])
    faces, torn = np.array([[0, 1, 2], [4, 5, 3]]), start.copy()
    torn[3, 2] = 0.5
    error = WeldError("expected welded vertices at one place")
    for weld, end, wrong in ((0.0, torn, []), (0.0, start, ["refused"]), (None, torn, ["refused"])):
        modes = {"weld": weld}
        case = Case(positions_t0=start, ends=(start, end), faces=faces, modes=modes)
        assert list(rules(refusals.judge_refusal(case, 1, error))) == wrong


def test_a_case_that_crashes_or_hangs_is_a_row(tmp_path, monkeypatch):
    """A process that ends, and a case that takes too long, are counted; the others are judged."""
    import os
    import time

    real = random_steps.run_case

    def run(case, rng):
        if case.thickness == 7.0:
            os._exit(11)
        if case.thickness == 8.0:
            while True:
                time.process_time()
        return real(case, rng)

    def drawn(family, kind, seed, number):
        return draw(family, "plain", seed, 1).change(thickness={1: 7.0, 2: 8.0}.get(number, 1e-3))

    monkeypatch.setattr(random_steps, "run_case", run)
    monkeypatch.setattr(random_steps, "draw", drawn)
    monkeypatch.setattr(random_steps, "STEP_S", 1.0)
    monkeypatch.setattr(random_steps, "BATCH_S", 1.0)
    row = random_steps.batch_row("few", "plain", 1, range(4))
    assert (row["cases"], row["crashed"], row["slow"], row["violations"]) == (4, 1, 1, 1)
    assert "its process ended with 11" in str(row["first_violations"])


def test_the_study_resumes(tmp_path, monkeypatch):
    monkeypatch.setattr(random_steps, "FAMILIES", {"few": FAMILIES["few"]})
    monkeypatch.setattr(random_steps, "KINDS", {"plain": KINDS["plain"]})
    said = []
    for _ in range(2):
        random_steps.random_steps(tmp_path, said.append, rounds=1, seed=5)
    rows = Rows(tmp_path, "random-steps", random_steps.KEYS).all()
    assert len(said) == len(rows) == 1
    assert rows[0]["cases"] == 10
    assert rows[0]["violations"] == 0


def test_a_step_can_be_drawn_and_judged_by_command(tmp_path, capsys):
    step = str(tmp_path / "step.npz")
    assert command.main(["draw", "few", "plain", "1", "1", step]) == 0
    assert command.main(["judge", step]) == 0
    assert command.main(["judge"]) == 2
    assert "FREE" in capsys.readouterr().out

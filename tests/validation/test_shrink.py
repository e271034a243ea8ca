"""The shrinker: planted faults come out as small as they can be, and files are written whole."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.exact_path import first_meeting
from tests.helpers.shapes import random_problem
from validation.__main__ import main
from validation.oracles.pairs import meeting_pairs
from validation.shrink import command, failing, numbers, snippet, steps
from validation.shrink.search import Search
from validation.stability_steps.case import Case, load_case
from validation.stability_steps.draw import draw
from validation.stability_steps.meshes import join, sheet


def layers(rng, **more):
    """Return a case of two sheets, of which the upper one falls through the lower one."""
    start, faces = join([sheet(3), sheet(3, 0.1)])
    start = start + 0.01 * rng.normal(size=start.shape) + (1000.25, 0.0, 0.0)
    end = start + 0.01 * rng.normal(size=start.shape)
    end[9:, 2] -= 0.3
    return Case(positions_t0=start, ends=(end,), faces=faces.astype(np.int32)).change(**more)


def shrunk(case, judge, kind=command.STEP, seconds=120.0):
    """Return the smallest case, and check that it fails as the first one does."""
    failure = judge(case)
    assert failure is not None
    best, ended = command.shrink(case, kind, judge, failure, seconds, lambda _: None)
    assert judge(best) == failure
    assert ended.startswith("nothing more")
    return best


def meets(case):
    """Fail if any pair meets on the proposed path."""
    found = meeting_pairs(case.positions_t0, case.ends[0], case.faces)
    return "meets" if len(found.vertex_face) + len(found.edge_edge) else None


def test_a_step_that_fails_when_a_pair_meets_ends_with_two_triangles(rng):
    case = layers(
        rng,
        masses=1.0 + rng.random(18),
        pinned=np.arange(18) < 5,
        settings={"selection": "all", "max_iterations": 7},
        modes={"prescribed": "block"},
        thickness=0.00123,
    )
    best = shrunk(case, meets)
    assert len(best.faces) <= 2
    assert len(best.positions_t0) <= 6
    assert (best.ends[0] != best.positions_t0).any(axis=1).sum() <= 2
    assert best.masses is None
    assert best.pinned is None
    assert (best.modes, best.settings, best.thickness) == ({}, {}, None)
    assert np.abs(best.positions_t0).max() < 10.0
    assert numbers.length(np.array([best.positions_t0, *best.ends])) < 40
    best.scene()  # the start is still valid


def test_a_fault_in_a_copy_of_the_certificate_ends_with_one_pair(rng):
    """The copy takes no edge-edge pair for meeting; only steps fail where nothing else meets."""

    def faulty_certificate_says_free(case):
        found = meeting_pairs(case.positions_t0, case.ends[0], case.faces)
        certificate = izo_ref.certify_path(case.scene(), case.ends[0])
        kept = ~certificate.meeting.is_edge_edge  # the fault
        free = not kept.any()
        return "said free, but meets" if free and len(found.edge_edge) else None

    start = np.array([[-2, 0, 0], [2, 0.125, 0], [0, 0.375, -3]])
    other = np.array([[0.125, -2, 0.5], [-0.125, 2, 0.75], [0.25, 0.125, 4]])
    far = rng.normal(size=(6, 3)) + np.repeat([[20.0], [40.0]], 3, axis=0)
    start = np.concatenate((far, start, other))
    end = start + 0.001 * rng.normal(size=start.shape)
    end[9:, 2] -= 1.5
    case = Case(positions_t0=start, ends=(end,), faces=np.arange(12).reshape(4, 3).astype(np.int32))
    best = shrunk(case, faulty_certificate_says_free)
    assert len(best.faces) == 2
    found = meeting_pairs(best.positions_t0, best.ends[0], best.faces)
    assert len(found.edge_edge) >= 1
    assert len(found.vertex_face) == 0
    nodes = found.edge_edge[0]
    assert first_meeting(True, best.positions_t0[nodes], best.ends[0][nodes]) is not None


def test_what_the_failure_needs_is_kept(rng):
    """A failure that needs a mass, a pinned vertex and an option keeps exactly these."""

    def needs(case):
        heavy = case.masses is not None and (case.masses > 100.0).any()
        held = case.pinned is not None and case.pinned.sum() >= 2
        return "fails" if heavy and held and case.settings.get("method") == "pgs" else None

    case = layers(
        rng,
        masses=10.0 ** rng.uniform(0, 4, 18),
        pinned=rng.random(18) < 0.5,
        settings={"method": "pgs", "max_steps": 7},
    )
    best = shrunk(case, needs)
    assert best.settings == {"method": "pgs"}
    assert best.pinned.sum() == 2
    assert len(best.positions_t0) == 2
    assert sorted(best.masses)[-1] > 100.0


def test_a_sequence_loses_the_steps_that_the_failure_does_not_need(rng):
    case = layers(rng)
    case = case.change(ends=(case.ends[0], case.positions_t0 + 7.0, case.ends[0]))
    best = shrunk(case, lambda c: "far" if any(e.max() > 1004.0 for e in c.ends[:2]) else None)
    assert len(best.ends) == 1
    assert len(best.positions_t0) == 1


def test_a_start_that_is_refused_stays_refused_in_the_same_way(rng):
    case = layers(rng)
    start = case.positions_t0.copy()
    start[9:, 2] -= 0.1  # the sheets cross at the start
    case = case.change(positions_t0=start)
    best = shrunk(case, failing.by_check)
    assert failing.by_check(best) == "InitialIntersectionError" == steps.door(best)
    assert len(best.faces) <= 2


def test_delta_debugging_keeps_what_is_needed_together():
    """Two items far apart are needed together; nothing else is left."""
    search = Search(tuple(range(100)), lambda c: {3, 97} <= set(c), repr_of, 10.0, lambda _: None)
    assert search.keep_few(range(100), lambda _, kept: tuple(kept)) == [3, 97]
    assert search.best == (3, 97)
    assert search.tried < 200


def repr_of(value):
    return repr(value).encode()


def test_when_the_time_is_over_the_best_so_far_is_the_answer(rng):
    case = layers(rng)
    best, ended = command.shrink(case, command.STEP, meets, "meets", 0.01, lambda _: None)
    assert "not minimal" in ended
    assert meets(best) == "meets"


def test_a_zone_ends_with_the_impacts_that_the_failure_needs(rng):
    """Fail if some impact is between vertices of masses that differ by more than 100."""

    def uneven(problem):
        masses = problem.masses[problem.nodes]
        return "uneven" if (masses.max(axis=1) > 100 * masses.min(axis=1)).any() else None

    problem = random_problem(rng, 20, 1e6)
    best = shrunk(problem, uneven, command.ZONE)
    assert best.nodes.shape == (1, 4)
    assert len(best.masses) == 4
    assert sorted(np.abs(best.normals[0])) == [0.0, 0.0, 1.0]
    assert (best.masses == 1.0).sum() == 3
    assert best.weights.sum() == 0.0
    assert (best.proposed == 0.0).all()
    exec(snippet.zone_snippet(best), {})


def test_our_own_zone_solver_does_not_fail_on_random_zones(rng):
    assert failing.by_zone(random_problem(rng, 3, 1e3)) in (None, "infeasible")


@pytest.mark.parametrize(
    ("family", "kind"), [("soup", "mixed"), ("few", "sequence"), ("cage", "start")]
)
def test_a_case_and_its_program_come_back_bit_for_bit(family, kind, tmp_path):
    case = draw(family, kind, 5, 3)
    case.save(tmp_path / "step.npz")
    assert steps.key(load_case(tmp_path / "step.npz")) == steps.key(case)
    program = snippet.step_snippet(case)
    start, _, _ = program.partition("result =")
    names = {}
    exec(start, names)
    made, scene = names["scene"], case.scene()
    for name in ("positions_t0", "positions_t1", "faces", "masses", "pinned"):
        np.testing.assert_array_equal(getattr(made, name), getattr(scene, name))


def test_the_command_shrinks_writes_and_prints_a_program(tmp_path, rng, capsys):
    step, out = tmp_path / "step.npz", tmp_path / "out.npz"
    start, faces = sheet(2)
    end = start + rng.normal(size=start.shape)
    Case(positions_t0=start, ends=(end,), faces=faces).save(step)
    program = tmp_path / "fails.py"
    program.write_text(
        "import sys, zipfile\n"
        "names = zipfile.ZipFile(sys.argv[1]).namelist()\n"
        "if 'positions_t1.npy' in names: raise ValueError('no')\n"
    )
    words = ["shrink", str(step), "-o", str(out)]
    assert main([*words, "--while", f"python -S {program} {{}}"]) == 0
    said = capsys.readouterr().out
    assert "fails: exit code 1, ValueError" in said
    assert "nothing more can be left out" in said
    assert "import izo_ref" in said
    assert len(load_case(out).positions_t0) == 1
    out.unlink()
    assert main([*words, "--while", "python -S -c pass"]) == 1
    assert not out.exists()


def test_the_result_does_not_replace_the_input(tmp_path, rng, capsys):
    step = tmp_path / "step.npz"
    layers(rng).save(step)
    assert main(["shrink", str(step), "-o", str(step)]) == 2
    assert "is the same file" in capsys.readouterr().err

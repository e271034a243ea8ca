"""The scenes of `data/scenes`: what is stored, and what izo_ref finds in them."""

import subprocess
import sys

import numpy as np
import pytest

import izo_ref
from data.scenes import make, truth
from tests.helpers import own_scenes
from validation.oracles.pairs import meeting_pairs
from validation.scenes import stored

NAMES = stored.names()
KINDS = {  # each of these scenes has to be there
    "cloth-on-sphere", "sheets", "stack", "crumple", "pinch-free", "pinch-blocked",
    "moving-obstacle", "mass-ratios", "sleeve",
}  # fmt: skip
# The exact oracle computes the pairs of these scenes again, in two seconds together.
RECOMPUTED = ("at-rest", "pinch-free")
LARGEST_FILE, LARGEST_SUM = 200_000, 1_500_000  # [bytes]
# Times of impact are rounded towards t = 0; on these scenes by at most 2.8e-12, as measured.
EARLY = 1e-10
SAME = 1e-6  # relative difference; two machines may differ in the last digits of an objective
STEP_NUMBERS = [
    pytest.param(name, number, id=name if len(facts["steps"]) == 1 else f"{name}-{number}")
    for name, facts in stored.index().items()
    for number in range(len(facts["steps"]))
]


def step_facts(name, number):
    """Return what the index says of one step."""
    return stored.index()[name]["steps"][number]


def true_pairs(name, number):
    """Return {pair: exact time} of one step."""
    arrays, pairs = stored.load(name), {}
    for kind in ("vf", "ee"):
        nodes, times = arrays[f"true_{kind}"], arrays[f"true_{kind}_time"]
        if f"true_{kind}_step" in arrays:
            own = arrays[f"true_{kind}_step"] == number
            nodes, times = nodes[own], times[own]
        pairs |= own_scenes.pair_times(nodes, kind == "ee", times)
    return pairs


def proposed_step(name, number):
    """Return the stored step; pairs that intersect at its start are excluded."""
    if name in own_scenes.STEPS:
        return own_scenes.scene(name)
    arrays = stored.load(name)
    start, end = arrays["positions"][number : number + 2]
    return izo_ref.Scene(
        start,
        end,
        arrays["faces"],
        arrays["masses"],
        arrays["pinned"],
        initial_intersections="exclude",
    )


def test_the_scenes_are_there_and_small():
    sizes = {name: (stored.FOLDER / f"{name}.npz").stat().st_size for name in NAMES}
    assert set(NAMES) >= KINDS
    assert list(sizes) == list(make.SCENES)
    assert {path.stem for path in stored.FOLDER.glob("*.npz")} == set(NAMES)
    assert max(sizes.values()) <= LARGEST_FILE
    assert sum(sizes.values()) <= LARGEST_SUM


def test_the_recipes_make_the_stored_meshes_bit_for_bit():
    """The command runs as a newcomer would run it, from another folder and without izo_ref."""
    file = str(stored.FOLDER / "make.py")
    command = [sys.executable, "-X", "importtime", file, "--check"]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=stored.FOLDER.parent
    )
    assert done.returncode == 0, done.stdout + done.stderr
    imported = {line.split("|")[-1].strip() for line in done.stderr.splitlines()}
    assert "data.scenes.recipes" in imported
    assert not [name for name in imported if name.split(".")[0] == "izo_ref"]
    assert done.stdout.splitlines() == [f"{name}: the same" for name in NAMES]


def test_the_check_names_what_differs(monkeypatch, capsys):
    changed = stored.load("at-rest")
    changed["positions_t1"][3, 1] = np.nextafter(changed["positions_t1"][3, 1], 9.0)
    changed["masses"] = changed["masses"].astype(np.float32)
    monkeypatch.setattr(make, "stored", lambda name: changed)
    assert make.main(["--check", "at-rest"]) == 1
    assert "at-rest: differs in positions_t1, masses" in capsys.readouterr().out


def test_the_check_notices_a_table_that_drifted(monkeypatch, capsys, tmp_path):
    other = tmp_path / "README.md"
    other.write_text(make.README.read_text().replace("| 714 |", "| 715 |"))
    monkeypatch.setattr(make, "README", other)
    assert make.main(["--check", "at-rest"]) == 1
    assert "README.md: its table differs" in capsys.readouterr().out


@pytest.mark.parametrize("name", NAMES)
def test_the_index_says_what_is_stored(name):
    arrays, facts = stored.load(name), stored.index()[name]
    assert facts["kind"] == ("sequence" if "positions" in arrays else "step")
    assert facts["vertices"] == len(arrays["masses"])
    assert facts["triangles"] == len(arrays["faces"])
    assert facts["pinned"] == arrays["pinned"].sum()
    assert facts["thickness_m"] == make.SCENES[name].thickness
    for key in (key for key in arrays if key.startswith("positions")):
        assert arrays[key].dtype == np.float64
    assert arrays["faces"].dtype == np.int32
    counted = [step["pairs"]["vertex_face"] for step in facts["steps"]]
    assert sum(counted) == len(arrays["true_vf"])
    counted = [step["pairs"]["edge_edge"] for step in facts["steps"]]
    assert sum(counted) == len(arrays["true_ee"])


@pytest.mark.parametrize("name", RECOMPUTED)
def test_the_oracle_finds_the_recorded_pairs_again(name):
    arrays = stored.load(name)
    assert make.differences(truth.pairs_of(arrays)[0], arrays) == []


@pytest.mark.parametrize(("name", "number"), STEP_NUMBERS)
def test_detection_finds_the_true_pairs_and_no_other(name, number):
    scene = proposed_step(name, number)
    impacts = izo_ref.find_impacts(scene)
    found = own_scenes.pair_times(impacts.nodes, impacts.is_edge_edge, impacts.toi)
    expected = true_pairs(name, number)
    left_out = own_scenes.excluded_keys(scene.excluded)
    missed = expected.keys() - found.keys() - left_out
    false_alarms = found.keys() - expected.keys()
    assert not missed
    assert not false_alarms
    assert not found.keys() & left_out
    early = [expected[pair] - time for pair, time in found.items()]
    assert all(0.0 <= by <= EARLY for by in early)


@pytest.mark.parametrize(("name", "number"), STEP_NUMBERS)
def test_the_certificate_of_the_proposed_path_names_the_true_pairs(name, number):
    scene = proposed_step(name, number)
    certificate = izo_ref.certify_path(scene, scene.positions_t1)
    meeting = {own_scenes.pair_key(*pair) for pair in zip(*certificate.meeting, strict=True)}
    expected = true_pairs(name, number)
    if certificate.excluded is None:
        assert meeting == expected.keys()
        assert certificate.free is not bool(expected)
        first = min(expected.values(), default=1.0)
        assert first - EARLY <= certificate.time_free <= first
    else:
        assert meeting == expected.keys() - own_scenes.excluded_keys(certificate.excluded)


@pytest.mark.parametrize("name", NAMES)
def test_resolve_gives_the_recorded_answer(name):
    for (scene, result), facts in zip(
        own_scenes.results(name), stored.index()[name]["steps"], strict=True
    ):
        answer = facts["answer"]
        assert result.status.name == answer["status"]
        assert result.objective == pytest.approx(answer["objective_m2"], rel=SAME)
        assert result.time_free == pytest.approx(answer["time_free"], rel=SAME)
        assert len(result.impacts.toi) == answer["impacts"]
        assert len(result.zones) == answer["zones"]
        free = answer["status"] != "BLOCKED"
        assert result.certificate.free is free
        assert (answer["pairs_that_meet_on_the_way_there"] == 0) is free
        left_out = len(own_scenes.excluded_keys(result.certificate.excluded))
        meeting = len(result.certificate.meeting_toi)
        assert meeting + left_out == answer["pairs_that_meet_on_the_way_there"]
        np.testing.assert_array_equal(
            result.positions[scene.pinned], scene.positions_t1[scene.pinned]
        )


def test_the_oracle_finds_the_path_to_an_answer_free():
    """Most answers are judged when the truth is made; this one is judged in each run."""
    result = own_scenes.result("at-rest")
    scene = own_scenes.scene("at-rest")
    met = meeting_pairs(scene.positions_t0, result.positions, scene.faces)
    assert len(met.vertex_face) + len(met.edge_edge) == 0
    assert met.decided > 100


def test_the_blocked_scene_says_which_pinned_pairs_meet_and_when():
    facts = stored.index()["pinch-blocked"]["pinned_pairs"]
    scene, result = own_scenes.scene("pinch-blocked"), own_scenes.result("pinch-blocked")
    pinned = {
        pair: time
        for pair, time in true_pairs("pinch-blocked", 0).items()
        if scene.pinned[np.hstack(pair)].all()
    }
    assert len(pinned) == facts["vertex_face"] + facts["edge_edge"]
    first = own_scenes.pair_key(facts["first_nodes"], facts["first_is_edge_edge"])
    assert pinned[first] == min(pinned.values()) == pytest.approx(facts["first_time"], rel=1e-8)
    assert 0.0 < result.time_free < 1.0
    assert pinned.keys() == own_scenes.excluded_keys(result.certificate.excluded)
    step = {name: getattr(scene, name) for name in ("positions_t0", "positions_t1", "faces")}
    blocked = izo_ref.Scene(**step, pinned=scene.pinned, prescribed="block")
    result = izo_ref.resolve(blocked, 1e-3)
    assert result.status is izo_ref.Status.BLOCKED
    assert 0.0 < result.time_free <= pinned[first]
    certificate = result.certificate
    meeting = {own_scenes.pair_key(*pair) for pair in zip(*certificate.meeting, strict=True)}
    assert pinned.keys() <= meeting
    prescribed = certificate.meeting.nodes[certificate.meeting_prescribed]
    assert scene.pinned[prescribed].all()


def test_the_swapped_sheets_are_free_at_both_ends():
    """A check of start and end alone would pass this path."""
    from validation.oracles.fcl import crossing_faces

    scene = own_scenes.scene("swapped")
    for positions in (scene.positions_t0, scene.positions_t1):
        assert len(crossing_faces(positions, scene.faces)) == 0
    assert step_facts("swapped", 0)["pairs"]["vertex_face"] > 0


def test_most_bodies_of_the_scene_at_rest_do_not_move():
    scene = own_scenes.scene("at-rest")
    moving = (scene.positions_t0 != scene.positions_t1).any(axis=1)
    assert 0.0 < moving.mean() < 0.1
    lines = {line.rule: line.needed for line in izo_ref.plan(scene).lines}
    assert lines["one-box"] == "some"


def test_the_masses_of_a_scene_range_over_six_decades():
    masses = stored.load("mass-ratios")["masses"]
    assert np.unique(np.log10(masses).round(12)).tolist() == [-3, -2, -1, 0, 1, 2, 3]

"""A dump that is right agrees at every stage, and a fault is found at its own stage."""

import json

import numpy as np
import pytest

from izo_ref import Options, Scene
from izo_ref.app.cli import main
from izo_ref.base.errors import FileFormatError, IzoError
from izo_ref.base.records import no_impacts
from izo_ref.porting.dump import judge_dump
from izo_ref.porting.dumped.zones import _is_some_order
from izo_ref.porting.reading import lines_of
from izo_ref.porting.stages import STAGE
from izo_ref.porting.trace import trace_resolve
from izo_ref.porting.trace_files import load_arrays
from tests.helpers.shapes import pinched_sheet, two_sheets
from tests.helpers.steps import SEED
from tests.helpers.traced import NAMES, scenes

FIRST = "iteration-0001"
FOUND = ("nodes", "edge_edge_impacts", "toi", "weights", "normals", "hopeful", "deep", "selected")


@pytest.fixture(scope="module")
def traced(tmp_path_factory):
    """Return the arrays of a trace in which a sheet is driven through a pinned one."""
    folder = tmp_path_factory.mktemp("dump") / "trace"
    scene = two_sheets(np.random.default_rng(SEED), 4, pinned_below=True)
    trace_resolve(scene, folder, 1e-3)
    return load_arrays(folder)


@pytest.fixture
def arrays(traced):
    """Return the arrays of the scene and of the first iteration; the caller may change them."""
    return {key: values for key, values in traced.items() if key.startswith(("scene", FIRST))}


@pytest.fixture
def judge(tmp_path):
    """Return a function that writes arrays as a dump and judges it."""

    def write_and_judge(arrays):
        np.savez(tmp_path / "dump.npz", **arrays)
        return judge_dump(tmp_path / "dump.npz")

    return write_and_judge


def found(arrays, name):
    """Return a column of the impacts of the first iteration, which may be changed."""
    arrays[f"{FIRST}/found/{name}"] = arrays[f"{FIRST}/found/{name}"].copy()
    return arrays[f"{FIRST}/found/{name}"]


def differing(report):
    """Return the stages and arrays that differ."""
    return [(finding.stage, finding.place) for finding in report.findings if finding.problem]


@pytest.mark.parametrize("name", NAMES)
def test_a_trace_is_a_dump_that_agrees(rng, tmp_path, name):
    scene, thickness, options = scenes(rng)[name]
    trace_resolve(scene, tmp_path / "trace", thickness, options=options)
    report = judge_dump(tmp_path / "trace")
    gives_up = [("S12", "result/positions")] if name == "scaled back" else []
    assert differing(report) == gives_up, report.text()
    assert report.agrees == (name != "scaled back")
    assert report.dtype == "f8"
    assert not report.notes
    judged = {finding.stage for finding in report.findings}
    assert judged >= {"S2", "S3", "S4", "S5", "S6", "S11", "S12"}


def test_a_trace_without_new_normals_and_with_every_rule_agrees(rng, tmp_path):
    for selection in ("independent", "first-of-any", "all"):
        options = Options(selection=selection, relinearize=0)
        trace_resolve(two_sheets(rng, 4), tmp_path / selection, 1e-3, options=options)
        (tmp_path / selection / "index.json").unlink()  # as a port that names no rule
        report = judge_dump(tmp_path / selection)
        assert report.agrees, report.text()
        notes = {finding.note for finding in report.findings if finding.stage == "S4"}
        assert any(selection in note for note in notes)


def test_what_enters_deep_zones_is_judged_by_their_rule(rng, tmp_path):
    scene, thickness, options = scenes(rng)["deep"]
    trace_resolve(scene, tmp_path / "trace", thickness, options=options)
    arrays = load_arrays(tmp_path / "trace")
    for name in [name for name in arrays if name.endswith("found/deep")]:
        (tmp_path / "trace" / f"{name}.npy").unlink()
    index = (tmp_path / "trace" / "index.json").read_text()
    (tmp_path / "trace" / "index.json").unlink()
    report = judge_dump(tmp_path / "trace")  # a port that names neither zones nor rule
    assert report.agrees, report.text()
    assert any("'deep'" in finding.note for finding in report.findings)
    (tmp_path / "trace" / "index.json").write_text(index)  # the rule is `independent`
    assert ("S4", f"{FIRST}/found/selected") in differing(judge_dump(tmp_path / "trace"))


def test_rows_may_come_in_any_order_and_sides_too(arrays, judge):
    rows = np.argsort(found(arrays, "toi"), kind="stable")[::-1]
    for name in FOUND:
        arrays[f"{FIRST}/found/{name}"] = found(arrays, name)[rows]
    nodes, kinds = found(arrays, "nodes"), found(arrays, "edge_edge_impacts")
    weights, normals = found(arrays, "weights"), found(arrays, "normals")
    for row in range(len(nodes)):
        turned = [2, 3, 0, 1] if kinds[row] else [0, 2, 3, 1]
        sign = -1.0 if kinds[row] else 1.0
        nodes[row], weights[row] = nodes[row][turned], sign * weights[row][turned]
        normals[row] *= sign
    report = judge(arrays)
    assert report.agrees, report.text()


def drop_a_pair(arrays):
    """Leave out the first impact that was selected."""
    row = int(np.flatnonzero(arrays[f"{FIRST}/found/selected"])[0])
    for name in FOUND:
        arrays[f"{FIRST}/found/{name}"] = np.delete(arrays[f"{FIRST}/found/{name}"], row, axis=0)


def add_a_pair(arrays):
    """Add a vertex and a face that do not meet."""
    faces, nodes = arrays["scene/faces"], arrays[f"{FIRST}/found/nodes"]
    listed = {(row[0], *sorted(row[1:])) for row in nodes.tolist()}
    start = arrays["scene/positions_t0"]
    far = [
        [vertex, *face]
        for vertex in np.flatnonzero(~arrays["scene/pinned"]).tolist()
        for face in faces.tolist()
        if np.abs(start[face] - start[vertex]).max() > 0.8 and (vertex, *sorted(face)) not in listed
    ]
    new = {"nodes": far[0], "edge_edge_impacts": False, "toi": 0.5, "weights": [1, 0, 0, -1]}
    new |= {"normals": [0, 0, 1], "hopeful": False, "deep": False, "selected": False}
    for name in FOUND:
        key = f"{FIRST}/found/{name}"
        row = np.asarray(new[name], arrays[key].dtype)
        arrays[key] = np.concatenate((arrays[key], row[None]))


def late(arrays):
    found(arrays, "toi")[:] = np.minimum(found(arrays, "toi") + 1e-6, 1.0)


def too_early(arrays):
    found(arrays, "toi")[3] *= 0.5


def no_number(arrays):
    found(arrays, "toi")[3] = np.nan


def weights_of_other_corners(arrays):
    row = int(np.flatnonzero(~arrays[f"{FIRST}/found/edge_edge_impacts"])[0])
    found(arrays, "weights")[row, 1:] = np.roll(found(arrays, "weights")[row, 1:], 1)


def weights_without_sign(arrays):
    found(arrays, "weights")[:] = np.abs(found(arrays, "weights"))


def weights_that_do_not_sum(arrays):
    found(arrays, "weights")[2] *= 1.001


def normals_turned(arrays):
    found(arrays, "normals")[5] *= -1.0


def normals_tilted(arrays):
    tilted = found(arrays, "normals") + 1e-4
    arrays[f"{FIRST}/found/normals"] = tilted / np.linalg.norm(tilted, axis=1)[:, None]


def normals_long(arrays):
    found(arrays, "normals")[:] *= 1.01


def one_more_selected(arrays):
    selected = found(arrays, "selected")
    selected[np.flatnonzero(~selected)[0]] = True


def zones_joined(arrays):
    arrays[f"{FIRST}/zones/zone_of_impact"] = 0 * arrays[f"{FIRST}/zones/zone_of_impact"]


def zones_split(arrays):
    key = f"{FIRST}/zones/zone_of_impact"
    arrays[key] = np.arange(len(arrays[key]))


def zones_dropped(arrays):
    key = f"{FIRST}/zones/zone_of_impact"
    arrays[key] = np.where(np.arange(len(arrays[key])) == 1, -1, arrays[key])


def too_far(arrays):
    proposed = arrays["scene/positions_t1"]
    key = f"{FIRST}/positions"
    arrays[key] = proposed + 1.001 * (arrays[key] - proposed)


def not_far_enough(arrays):
    proposed = arrays["scene/positions_t1"]
    key = f"{FIRST}/positions"
    arrays[key] = proposed + 0.999 * (arrays[key] - proposed)


def pinned_by_displacement(arrays):
    vertex = int(np.flatnonzero(arrays["scene/pinned"])[0])
    key = f"{FIRST}/positions"
    arrays[key] = arrays[key].copy()
    arrays[key][vertex] = np.nextafter(arrays[key][vertex], np.inf)


def multipliers_of_the_mean(arrays):
    arrays[f"{FIRST}/multipliers"] = 2.0 * arrays[f"{FIRST}/multipliers"]


def multipliers_below_zero(arrays):
    arrays[f"{FIRST}/multipliers"] = -arrays[f"{FIRST}/multipliers"]


def half_the_objective(arrays):
    arrays[f"{FIRST}/objective"] = 0.5 * arrays[f"{FIRST}/objective"]


def proposed_at_the_end(arrays):
    arrays["result/positions"] = arrays["scene/positions_t1"]
    arrays["result/objective"] = np.array(0.0)


def start_at_the_end(arrays):
    pinned = arrays["scene/pinned"][:, None]
    ends = arrays["scene/positions_t0"] + (0.0, 0.0, 1e-3)
    arrays["result/positions"] = np.where(pinned, arrays["scene/positions_t1"], ends)
    del arrays["result/objective"]


def pinned_moved_at_the_end(arrays):
    ends = arrays["result/positions"].copy()
    ends[np.flatnonzero(arrays["scene/pinned"])[0], 0] += 1e-15
    arrays["result/positions"] = ends


def given_up(arrays):
    proposed_at_the_end(arrays)
    arrays["result/free"] = np.array(False)


FAULTS = [
    (drop_a_pair, "S2", "found/nodes", "are not listed"),
    (add_a_pair, "S2", "found/nodes", "do not meet on the path"),
    (late, "S2", "found/toi", "is late"),
    (too_early, "S2", "found/toi", "is early"),
    (no_number, "S2", "found/toi", "is no number"),
    (weights_of_other_corners, "S3", "found/weights", "closest points"),
    (weights_without_sign, "S3", "found/weights", "do not sum to 1"),
    (weights_that_do_not_sum, "S3", "found/weights", "do not sum to 1"),
    (normals_turned, "S3", "found/normals", "the gap at t = 0 is negative"),
    (normals_tilted, "S3", "found/normals", "is not that of the face"),
    (normals_long, "S3", "found/normals", "no unit vector"),
    (one_more_selected, "S4", "found/selected", "is selected, but must not be"),
    (zones_joined, "S5", "zones/zone_of_impact", "share no unpinned vertex"),
    (zones_dropped, "S5", "zones/zone_of_impact", "is in none"),
    (too_far, "S11", "positions", "times as far"),
    (not_far_enough, "S11", "positions", "a constraint is violated"),
    (pinned_by_displacement, "S11", "positions", "is pinned"),
    (multipliers_of_the_mean, "S11", "multipliers", "do not balance"),
    (multipliers_below_zero, "S11", "multipliers", "is negative"),
    (half_the_objective, "S6", "objective", "0.5 times"),
    (proposed_at_the_end, "S12", "result/positions", "the path is not free"),
    (start_at_the_end, "S12", "result/positions", "times as far"),
    (pinned_moved_at_the_end, "S12", "result/positions", "is pinned"),
    (given_up, "S12", "result/positions", "found no free path"),
]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[0].__name__)
def test_a_fault_is_found_at_its_stage(traced, arrays, judge, fault):
    spoil, stage, place, words = fault
    if stage == "S12":
        own = {key: values for key, values in traced.items() if not key.startswith("iteration")}
        arrays = own
    spoil(arrays)
    report = judge(arrays)
    assert not report.agrees
    assert report.first.stage == stage, report.text()
    assert report.first.place == (place if place.startswith("result") else f"{FIRST}/{place}")
    assert words in report.first.problem.sentence
    if place.startswith("found") and place != "found/selected":
        assert report.first.problem.vertices
    text = report.text()
    assert f"First difference: {stage}" in text
    assert STAGE[stage].formula in text
    assert str(lines_of(STAGE[stage])) in text


def test_one_early_difference_does_not_hide_that_the_rest_is_right(arrays, judge):
    for spoil in (late, normals_turned, half_the_objective, zones_joined):
        own = dict(arrays)
        spoil(own)
        assert len(differing(judge(own))) == 1


def test_equal_times_may_be_selected_in_any_order():
    """A fan of impacts at one vertex: any one of those at the first time may enter."""
    times = np.array([0.25, 0.25, 0.5, 0.75])
    nodes = np.array([[0, 1, 2, 3], [4, 5, 2, 6], [7, 8, 9, 6], [7, 10, 11, 12]])
    found = no_impacts()._replace(nodes=nodes, toi=times)
    pinned = np.zeros(13, bool)
    for chosen, expected in (
        ([True, False, True, False], True),
        ([False, True, False, True], True),
        ([True, True, False, True], False),  # two of them share a vertex
        ([False, True, True, False], False),
        ([True, False, False, True], False),  # nothing before it has its vertices
    ):
        assert _is_some_order(found, np.array(chosen), pinned) is expected


def test_zones_that_are_split_differ(rng, tmp_path, judge):
    trace_resolve(two_sheets(rng, 4), tmp_path / "trace", 1e-3, options=Options(selection="all"))
    arrays = load_arrays(tmp_path / "trace")
    zones_split(arrays)
    report = judge(arrays)
    assert report.first.stage == "S5"
    assert "a chain of impacts connects them" in report.first.problem.sentence


def test_positions_are_judged_on_the_zones_of_the_port(arrays, judge):
    """A port whose normals are wrong may still solve its zones rightly."""
    from izo_ref import Impacts, build_zones, solve_zone, zone_problem

    scene = Scene(*(arrays[f"scene/{n}"] for n in ("positions_t0", "positions_t1", "faces")))
    scene = Scene(
        scene.positions_t0, scene.positions_t1, scene.faces, arrays["scene/masses"],
        arrays["scene/pinned"],
    )  # fmt: skip
    normals_tilted(arrays)
    chosen = arrays[f"{FIRST}/found/selected"]
    impacts = Impacts(*(arrays[f"{FIRST}/found/{name}"][chosen] for name in FOUND[:5]))
    zones, ends = build_zones(scene, impacts), scene.positions_t1.copy()
    for zone in range(len(zones)):
        solution = solve_zone(zone_problem(scene, impacts, zones, zone, 1e-3))
        ends[np.unique(impacts.nodes[zones.impacts_of(zone)])] = solution.positions
    kept = {k: v for k, v in arrays.items() if k.startswith((f"{FIRST}/found", "scene"))}
    report = judge(kept | {f"{FIRST}/positions": ends})
    assert differing(report) == [("S3", f"{FIRST}/found/normals")]
    last = report.findings[-1]
    assert (last.place, last.given) == (
        f"{FIRST}/positions", "the impacts that the port selected"
    )  # fmt: skip


def test_float32_dumps_get_the_tolerances_of_float32(arrays, judge):
    rounded = {
        key: values.astype(np.float32) if values.dtype == np.float64 else values
        for key, values in arrays.items()
    }
    report = judge(rounded)
    assert report.dtype == "f4"
    assert report.agrees, report.text()
    as_float64 = {
        key: values.astype(np.float64) if values.dtype == np.float32 else values
        for key, values in rounded.items()
    }
    assert not judge(as_float64).agrees
    normals_tilted(rounded)
    assert judge(rounded).first.stage == "S3"


def test_times_may_be_a_little_early(arrays, judge):
    found(arrays, "toi")[:] *= 0.9
    assert judge(arrays).agrees


def test_candidates_have_to_hold_every_pair_that_meets(arrays, judge):
    nodes, kinds = arrays[f"{FIRST}/found/nodes"], arrays[f"{FIRST}/found/edge_edge_impacts"]
    scene = {key: values for key, values in arrays.items() if key.startswith("scene")}
    lists = {f"{FIRST}/vertex_face": nodes[~kinds], f"{FIRST}/edge_edge": nodes[kinds]}
    assert judge(scene | lists).agrees
    short = judge(scene | lists | {f"{FIRST}/edge_edge": nodes[kinds][1:]})
    assert differing(short) == [("S1", f"{FIRST}/edge_edge")]
    wrong = nodes[~kinds].copy()
    wrong[0, 0] = wrong[0, 1]
    assert "share a vertex" in judge(scene | {f"{FIRST}/vertex_face": wrong}).first.problem.sentence


def test_a_blocked_step_is_no_failure_of_the_port(tmp_path, judge):
    scene = pinched_sheet(-0.01, bump=0.2, side=2)
    trace_resolve(scene, tmp_path / "trace", 1e-3)
    arrays = load_arrays(tmp_path / "trace")
    assert not arrays["result/free"]
    assert judge(arrays).agrees
    arrays["result/free"] = np.array(True)
    assert "the path is not free" in judge(arrays).first.problem.sentence


def test_the_command_prints_the_report_and_exits_with_one(arrays, tmp_path, capsys):
    dump, report = str(tmp_path / "dump.npz"), tmp_path / "report.json"
    np.savez(dump, **arrays)
    assert main(["conform", "--dump", dump]) == 0
    assert "agree with the reference" in capsys.readouterr().out
    late(arrays)
    np.savez(dump, **arrays)
    assert main(["conform", "--dump", dump, "--json", str(report)]) == 1
    assert "First difference: S2 time of impact" in capsys.readouterr().out
    record = json.loads(report.read_text())
    assert record["first"]["place"] == f"{FIRST}/found/toi"
    assert record["first"]["reference"].startswith("izo_ref/detection/formulas/advance.py:")


def test_the_command_refuses_flags_of_the_vectors_and_bad_dumps(arrays, tmp_path, capsys):
    dump = str(tmp_path / "dump.npz")
    np.savez(dump, **arrays)
    assert main(["conform", "--dump", dump, "--stage", "S7"]) == 2
    assert "--stage: --dump judges no vectors" in capsys.readouterr().err
    assert main(["conform", "--dump", str(tmp_path / "none")]) == 2
    assert "there is no such folder" in capsys.readouterr().err


def test_a_scene_alone_says_nothing(arrays, judge):
    report = judge({key: values for key, values in arrays.items() if key.startswith("scene")})
    assert not report.agrees
    assert "nothing was judged" in report.text()
    assert report.record()["first"] is None


def test_what_is_not_judged_is_said(arrays, judge):
    kept = {k: v for k, v in arrays.items() if k.startswith(("scene", f"{FIRST}/found"))}
    del kept[f"{FIRST}/found/selected"]
    kept[f"{FIRST}/positions"] = arrays[f"{FIRST}/positions"]
    kept["iteration-0001/velocity"] = np.zeros(3)
    del kept["scene/thickness"]
    notes = " ".join(judge(kept).notes)
    assert "no stage takes these arrays: iteration-0001/velocity" in notes
    assert "zones and positions were not judged" in notes
    assert "the default of izo_ref was taken" in notes


@pytest.mark.parametrize(
    ("key", "values", "message"),
    [
        ("scene/faces", None, "scene/faces missing"),
        (f"{FIRST}/found/weights", np.zeros((2, 4)), r"expected shape \(\d+, 4\) of floats"),
        (f"{FIRST}/found/toi", np.zeros(3, int), "of floats, got"),
        (f"{FIRST}/found/edge_edge_impacts", None, "which says of which kind"),
        (f"{FIRST}/found/selected", np.zeros((2, 2), bool), r"expected shape \(\d+,\) of flags"),
        (f"{FIRST}/positions", np.zeros((3, 3)), r"expected shape \(32, 3\)"),
        (f"{FIRST}/zones/zone_of_impact", np.zeros(1), "of integers"),
        ("scene/thickness", np.ones(2), r"expected shape \(\)"),
    ],
)
def test_wrong_shapes_and_missing_arrays_are_refused(arrays, judge, key, values, message):
    if values is None:
        del arrays[key]
    else:
        arrays[key] = values
    with pytest.raises(FileFormatError, match=message):
        judge(arrays)


def test_bad_scenes_and_vertices_that_do_not_exist_are_refused(arrays, judge):
    nodes = found(arrays, "nodes")
    nodes[2, 1] = 99
    with pytest.raises(FileFormatError, match="expected vertices from 0 to 31, got 99 in row 2"):
        judge(arrays)
    arrays["scene/masses"] = -arrays["scene/masses"]
    with pytest.raises(IzoError, match="masses"):
        judge(arrays)

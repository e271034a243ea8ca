"""The study of animations measures what it says, and its checks can fail."""

import numpy as np
import pytest

from izo_ref.detection.intersections import find_intersections
from izo_ref.scene import edges_of
from tests.helpers.shapes import two_sheets
from validation.oracles import ipc
from validation.oracles.animation_files import held
from validation.report import sequences as report
from validation.rows import Rows
from validation.scenes import tangles
from validation.scenes.animation_files import FORMATS, only, write_animation
from validation.scenes.moving_garment import FIRST_CONTACT, moving_garment
from validation.study import sequence_formats, sequence_memory, sequence_speed, sequence_tangles
from validation.study.sequence_judges import judge_frames, meeting_by_ipctk, unexplained_by_fcl

needs_ipctk = pytest.mark.skipif(ipc.unusable() is not None, reason=f"ipctk: {ipc.unusable()}")
LIBRARIES = {"usd": "pxr", "abc": "alembic3d"}


def needs(kind):
    """Skip a test if the library of a format is not installed."""
    if kind in LIBRARIES:
        pytest.importorskip(LIBRARIES[kind], reason=f"{kind} needs the package {LIBRARIES[kind]}")


@pytest.fixture
def garment(rng):
    """Return a small garment that goes into its body in the last two of its frames."""
    moving = moving_garment(rng, FIRST_CONTACT + 2, 400, 2, 0.5)
    return moving._replace(positions=moving.positions[FIRST_CONTACT - 2 :])


@pytest.mark.parametrize(("n_triangles", "n_layers", "pressed"), [(400, 1, 0.3), (1500, 3, 1.0)])
def test_the_garment_is_inside_the_body_from_its_frame_on(rng, n_triangles, n_layers, pressed):
    moving = moving_garment(rng, FIRST_CONTACT + 3, n_triangles, n_layers, pressed)
    edges = edges_of(moving.faces)
    found = [find_intersections(frame, edges, moving.faces).n_found for frame in moving.positions]
    assert found[:FIRST_CONTACT] == [0] * FIRST_CONTACT
    assert min(found[FIRST_CONTACT:]) > 0
    assert abs(len(moving.faces) / n_triangles - 1.0) < 0.3
    assert np.array_equal(moving.positions, moving.positions.astype(np.float32))
    assert moving.pinned_vertices.sum() == moving.parts[0].n_vertices


@pytest.mark.parametrize("kind", FORMATS)
def test_what_is_written_is_what_the_second_reader_finds(garment, tmp_path, kind):
    needs(kind)
    written = write_animation(tmp_path, kind, garment)
    found = held(kind, written.path)
    expected = only(garment, list(written.parts)).positions
    # an offset from the base is a float32 number in glTF
    tolerance = 1e-7 if kind == "gltf" else 0.0
    np.testing.assert_allclose(found.positions, expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("kind", FORMATS)
def test_the_second_reader_notices_what_changes(garment, tmp_path, kind):
    needs(kind)
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
    parts = [part._replace(faces=part.faces[::-1]) for part in garment.parts]
    others = garment._replace(parts=tuple(parts))
    moved = garment._replace(positions=garment.positions + 0.5)
    paths = [
        write_animation(tmp_path / name, kind, moving).path
        for name, moving in (("a", garment), ("b", others), ("c", moved))
    ]
    first, turned, shifted = (held(kind, path) for path in paths)
    assert (first.rest == turned.rest) == (kind in ("pc2", "mdd"))  # they hold no faces
    assert first.rest == shifted.rest
    assert not np.array_equal(first.positions, shifted.positions)


@needs_ipctk
@pytest.mark.parametrize("kind", ["npz", "usd"])
def test_a_format_is_resolved_judged_killed_and_resumed(garment, tmp_path, kind):
    needs(kind)
    row = sequence_formats.format_row(garment, kind, tmp_path, {})
    assert (row["frames"], row["paths"], row["exit_code"]) == (4, 3, 0)
    assert (row["free_paths"], row["free_by_ipctk"], row["free_by_fcl"]) == (3, 3, 3)
    assert row["impacts"] > 0
    assert row["still"] == row["still_same"] == 2
    assert row["killed_after"] >= 3
    assert row["rest_kept"]
    assert row["same_bytes"]


@needs_ipctk
def test_judges_notice_frames_that_are_not_free(garment):
    before = judge_frames(garment.positions, garment.faces, garment.pinned_vertices)
    assert before.paths == 3
    for found in before[1:]:
        assert 0 < found < 3


@needs_ipctk
def test_pairs_that_are_left_out_may_meet_and_others_may_not(rng):
    scene = two_sheets(rng, 4)
    path = scene.positions_t0, scene.positions_t1, scene.edges, scene.faces
    assert (meeting_by_ipctk(*path) or 0) > 0
    hits = ipc.path_hits(*path)
    left_out = hits.nodes, hits.is_edge_edge
    assert len(ipc.path_hits(*path, left_out=left_out).nodes) == 0
    some = hits.nodes[1:], hits.is_edge_edge[1:]
    assert np.array_equal(ipc.path_hits(*path, left_out=some).nodes, hits.nodes[:1])


def test_faces_that_cross_without_a_pair_that_is_left_out_are_counted():
    tangle = tangles.crossed_corner(9)
    edges = edges_of(tangle.faces)
    assert unexplained_by_fcl(tangle.positions_t0, edges, tangle.faces, None) > 0


@needs_ipctk
@pytest.mark.parametrize("make", [tangles.crossed_corner, tangles.crossed_sheets])
def test_a_tangled_start_is_counted(make):
    still = sequence_tangles.generated(lambda: make(9))
    rows = list(sequence_tangles.tangle_rows(still, 0.0, (0, 1, 3)))
    assert [row["frame"] for row in rows] == [0, 1, 3]
    edges = edges_of(still.faces)
    crossings = len(find_intersections(still.start, edges, still.faces).crossing_edges)
    assert [row["crossings"] for row in rows] == [crossings] * 3  # nothing pulls
    assert rows[-1]["judged"] == 3
    for name in ("most_new", "grown", "left_out_grown", "met_by_ipctk", "crossing_by_fcl"):
        assert rows[-1][name] == 0


@needs_ipctk
def test_protected_pairs_do_not_meet_in_a_tangle_that_sways():
    swaying = sequence_tangles.generated(lambda: tangles.crossed_sheets(9), 0.1)
    assert np.any(swaying.sway[81:])
    assert not np.any(swaying.sway[:81])
    row = list(sequence_tangles.tangle_rows(swaying, 0.0, (0, 4)))[-1]
    assert row["judged"] == 4
    assert row["most_new"] > 0  # the contour moves along the level sheet
    assert row["left_out_grown"] == row["met_by_ipctk"] == row["crossing_by_fcl"] == 0


def test_shells_are_tangled():
    tangle = tangles.layered_shells(16)
    edges = edges_of(tangle.faces)
    assert len(find_intersections(tangle.positions_t0, edges, tangle.faces).crossing_edges) > 50


def test_a_new_crossing_is_counted():
    tangle = tangles.crossed_corner(9)
    still = sequence_tangles.generated(lambda: tangle)
    apart = still.start.copy()
    apart[81:] += 5.0  # the upright sheet
    count = sequence_tangles._Count(still, edges_of(still.faces), ())
    for number, positions in enumerate((apart, still.start)):
        count.add(_FakeFrame(number, positions, 7 * number))
    row = count.row(_FakeFrame(1, still.start, 7))
    assert row["most_new"] == row["grown"] == row["crossings"] > 0
    assert row["left_out_grown"] == 7


class _FakeFrame:
    """What `_Count` reads of a frame."""

    def __init__(self, number, positions, excluded):
        self.number, self.positions, self.excluded = number, positions, excluded
        self.substeps, self.certificate = 1, None
        self.status = sequence_formats.Status.FREE


def test_frames_are_timed():
    row = sequence_speed.speed_row(600, "light", 1, 3)
    assert row["repeats"] == 3
    assert row["frames_per_s"] == pytest.approx(1.0 / row["median_s"])
    assert row["impacts"] > 0


def test_memory_of_a_short_sequence_is_measured():
    row = sequence_memory.generator_row(12, 6)
    assert row["early_mib"] > 1.0
    assert row["impacts"] > 0
    sequence_memory.require_flat("frames", row | {"last_mib": row["early_mib"]})
    with pytest.raises(sequence_memory.MemoryGrowsError, match=r"grew by 4\.0 MiB"):
        sequence_memory.require_flat("frames", row | {"last_mib": row["early_mib"] + 4.0})


def test_the_memory_of_the_command_is_measured(tmp_path):
    sequence_memory.memory(tmp_path, lambda line: None, 16, 11)
    found = {row["what"]: row for row in Rows(tmp_path, "memory", ()).all()}
    assert set(found) == {"resolve_sequence", "izo sequence"}
    assert all(row["early_mib"] > 1.0 and row["impacts"] > 0 for row in found.values())


def test_the_page_says_which_rows_are_wrong(tmp_path):
    rows = Rows(tmp_path / "rows", "formats", sequence_formats.KEYS)
    good = dict.fromkeys(report.STATUSES, 0) | {"FREE": 3, "frames": 3, "impacts": 5}
    good |= {"nudged": 0, "held": 0, "paths": 2, "free_paths": 2, "free_by_ipctk": None}
    good |= {"free_by_fcl": 2, "rest_kept": True, "still": 1, "still_same": 1}
    good |= {"killed_after": 2, "same_bytes": True}
    wrong = ({}, {"free_paths": 1}, {"rest_kept": False}, {"same_bytes": False}, {"still": 2})
    for number, change in enumerate(wrong):
        rows.add(animation=f"a{number}", format="npz", **(good | change))
    text = report.page(tmp_path / "rows", tmp_path).read_text()
    assert "| a0 | npz | 3 | 3 FREE | 5 | 0 | 2 of 2 | not asked | 2 of 2 | yes |" in text
    assert "Not measured yet." in text
    (headline,) = report.headlines(tmp_path / "rows")
    assert headline.figure == "1 of 5"

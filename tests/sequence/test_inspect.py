"""Inspection: what crosses in each frame is counted again by a slow program, and timed by hand."""

import tracemalloc

import numpy as np
import pytest

import izo_ref
from izo_ref import errors
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.sides import Side
from izo_ref.detection.touching import contacts_through, tell_sides
from izo_ref.sequence.crossings import CrossingMesh
from izo_ref.sequence.inspect import inspect_sequence
from izo_ref.sequence.inspection import ORDER, Verdict
from tests.helpers.dips import HEIGHTS, dipping_spike, passing_sheets, tangle
from tests.helpers.shapes import grid
from tests.naive.crossings import edges_through_faces, groups_of_crossings
from tests.naive.start import pairs_that_meet

THROUGH = range(3, 8)  # frames in which the spike is through the plate


def verdicts(found):
    """Return the verdict of each frame."""
    return [frame.verdict for frame in found]


def crossings_of(frame):
    """Return the edges and faces of an inspected frame as a set of two tuples."""
    rows = zip(frame.edges.tolist(), frame.faces.tolist(), strict=True)
    return {(tuple(edge), tuple(face)) for edge, face in rows}


def test_a_spike_that_dips_through_a_plate_is_seen_from_its_first_frame_to_its_last():
    frames, faces, parts = dipping_spike()
    found = list(inspect_sequence(frames, faces, None, parts))
    assert [frame.number for frame in found] == list(range(len(frames)))
    for frame, height in zip(found, HEIGHTS, strict=True):
        if frame.number not in THROUGH:
            assert frame.verdict is Verdict.CLEAN
            assert frame.crossings == frame.contours == frame.passing == 0
            assert frame.depth == frame.reach == frame.width == 0.0
            continue
        assert frame.verdict is Verdict.RESOLVABLE
        assert frame.crossings == 3
        assert frame.contours == 1
        assert frame.depth == pytest.approx(-height)
        assert frame.reach == pytest.approx(-height)
        (pair,) = frame.pairs
        assert (pair.parts, pair.since, pair.crossings, pair.kept) == ((0, 1), 3, 3, 0)
        # The edges of the spike have the corners of its rim one above the tip.
        corners = np.array([(0.3, -0.1), (-0.3, -0.1), (0.0, 0.3)]) * -height
        assert frame.width == pytest.approx(np.linalg.norm(np.ptp(corners, axis=0)))
    assert [frame.new for frame in found] == [0, 0, 0, 3, 0, 0, 0, 0, 0, 0]
    assert [frame.gone for frame in found] == [0, 0, 0, 0, 0, 0, 0, 0, 3, 0]


def test_the_depth_is_at_most_half_an_edge_and_the_reach_is_not():
    """A fine sheet that goes 0.2 through a plate, with edges of 0.1."""
    sheet, faces = grid(11)
    sheet = sheet[:, [0, 2, 1]] + (0.003, 0.001, -0.23)
    plate = np.array([(-9.0, -9.0, 0.0), (9.0, -9.0, 0.0), (0.0, 9.0, 0.0)])
    positions = np.concatenate((sheet, plate))
    faces = np.concatenate((faces, [(121, 122, 123)]))
    (frame,) = inspect_sequence([positions], faces)
    assert frame.reach == pytest.approx(0.23)
    assert frame.depth <= 0.05 * np.sqrt(2.0) + 1e-12
    assert frame.contours == 1


def test_the_reach_of_a_part_that_goes_through_itself():
    """The spike hangs from a bridge to a corner of the plate, so all is one component."""
    frames, faces, _ = dipping_spike()
    bridged = np.concatenate((faces, [(6, 1, 9)]))
    frames = [np.concatenate((frame, [(5.0, -5.0, 3.0)])) for frame in frames]
    for frame, height in zip(inspect_sequence(frames, bridged), HEIGHTS, strict=True):
        assert frame.crossings == (3 if height < 0.0 else 0)
        assert frame.reach == pytest.approx(max(0.0, -height))


def test_a_contour_that_ends_at_a_border_cuts_nothing_off():
    """A corner of a sheet is through the border of another one."""
    positions, faces = grid(2)
    upright = positions[:, [0, 2, 1]] + (0.5, 0.2, -0.5)
    (frame,) = inspect_sequence(
        [np.concatenate((positions, upright))], np.concatenate((faces, faces + 4))
    )
    assert frame.crossings > 0
    assert frame.depth > 0.0
    assert frame.reach == 0.0


@pytest.mark.parametrize("case", range(4))
def test_crossings_and_contours_are_those_of_a_slow_program(rng, case):
    if case < 3:
        frames = [tangle(rng, 12) for _ in range(4)]
        faces, frames = frames[0][1], [positions for positions, _ in frames]
    else:
        jitter = 0.05 * rng.normal(size=(32, 3))
        frames, faces, _ = passing_sheets((0.02, 0.0, -0.02), 4, jitter)
    before = set()
    for number, frame in enumerate(inspect_sequence(frames, faces)):
        wanted = edges_through_faces(frames[number], faces)
        assert crossings_of(frame) == wanted
        assert frame.crossings == len(wanted) > 0
        assert frame.new == len(wanted - before)
        assert frame.gone == len(before - wanted)
        assert frame.contours == groups_of_crossings(wanted, faces)
        assert frame.touching == 0
        before = wanted


def test_another_library_agrees_which_frames_cross(rng):
    ipctk = pytest.importorskip("ipctk", reason="ipctk is not installed: izo-ref[validation]")
    jitter = 0.01 * rng.normal(size=(50, 3))
    heights = np.concatenate((np.linspace(0.1, -0.1, 12), np.linspace(-0.1, 0.1, 5)))
    frames, faces, _ = passing_sheets(heights, 5, jitter)
    edges = edges_of(faces.astype(np.int32))
    mesh = ipctk.CollisionMesh(frames[0], edges, faces)
    found = [frame.crossings > 0 for frame in inspect_sequence(frames, faces)]
    assert found == [ipctk.has_intersections(mesh, positions) for positions in frames]
    assert 0 < sum(found) < len(found)


def test_a_path_that_passes_through_between_two_free_frames_is_seen():
    frames, faces, parts = passing_sheets((0.3, 0.1, -0.1, -0.3))
    found = list(inspect_sequence(frames, faces, None, parts))
    clean, through = Verdict.CLEAN, Verdict.RESOLVABLE
    assert verdicts(found) == [clean, clean, through, clean]
    assert not any(frame.crossings for frame in found)
    scene = izo_ref.Scene(frames[1], frames[2], faces)
    n = len(izo_ref.find_impacts(scene).toi)
    assert found[2].met == found[2].passing == n > 0
    (pair,) = found[2].pairs
    assert (pair.parts, pair.passing, pair.since) == ((0, 1), n, None)


def test_all_pairs_that_meet_on_the_way_are_counted(rng):
    frames, faces, _ = passing_sheets((0.1, -0.15), 3, 0.01 * rng.normal(size=(18, 3)))
    last = list(inspect_sequence(frames, faces))[1]
    assert last.met == last.passing == len(pairs_that_meet(*frames, faces)) > 0


def test_what_meets_on_the_way_into_a_crossing_does_not_pass():
    frames, faces, _ = dipping_spike((0.5, -0.2, 0.5))
    found = list(inspect_sequence(frames, faces))
    assert found[1].met > 0
    # On the way out, the pairs that cross at its start are not looked at again.
    assert [frame.passing for frame in found] == [0, 0, 0]
    assert verdicts(found) == [Verdict.CLEAN, Verdict.RESOLVABLE, Verdict.CLEAN]


def test_pinned_parts_that_cross_cannot_be_resolved():
    frames, faces, parts = dipping_spike()
    found = list(inspect_sequence(frames, faces, np.ones(9, bool), parts))
    wanted = [Verdict.PINNED if k in THROUGH else Verdict.CLEAN for k in range(len(frames))]
    assert verdicts(found) == wanted
    assert [pair.pinned for frame in found for pair in frame.pairs] == [3] * 5
    # With one free vertex of the spike, its edges have a vertex that may move.
    some = np.arange(9) != 5
    found = inspect_sequence(frames, faces, some, parts)
    assert set(verdicts(found)) == {Verdict.CLEAN, Verdict.RESOLVABLE}


def test_pinned_parts_that_pass_through_cannot_be_resolved_either():
    frames, faces, parts = passing_sheets((0.1, -0.1))
    found = list(inspect_sequence(frames, faces, np.ones(50, bool), parts))
    assert verdicts(found) == [Verdict.CLEAN, Verdict.PINNED]
    assert found[1].pairs[0].pinned == found[1].passing


def test_what_crosses_since_the_start_is_told_from_what_comes_later():
    frames, faces, parts = dipping_spike((-0.1, -0.2, 0.1, -0.1))
    found = list(inspect_sequence(frames, faces, None, parts, first=10))
    start, later = Verdict.SINCE_START, Verdict.RESOLVABLE
    assert verdicts(found) == [start, start, Verdict.CLEAN, later]
    assert [frame.kept for frame in found] == [3, 3, 0, 0]
    assert [[pair.since for pair in frame.pairs] for frame in found] == [[10], [10], [], [13]]


def test_surfaces_that_cross_exactly_at_vertices_cross_and_others_touch():
    """Two squares through each other along a diagonal of both, and one that stands on the other."""
    flat = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    upright = np.array([(0.5, 0.25, -1.0), (0.5, 0.75, -1.0), (0.5, 0.75, 1.0), (0.5, 0.25, 1.0)])
    both = np.concatenate((faces, faces + 4))
    through, standing = (np.concatenate((flat, upright + (0.0, 0.0, z))) for z in (0.0, 1.0))
    found = list(inspect_sequence([through, standing], both))
    assert edges_through_faces(standing, both)
    assert verdicts(found) == [Verdict.SINCE_START, Verdict.TOUCHES]
    assert found[0].crossings > 0
    assert found[1].crossings == 0
    assert found[1].touching > 0
    assert found[1].pairs[0].touching == found[1].touching


@pytest.mark.parametrize("case", range(5))
def test_what_touches_at_vertices_of_both_sides_need_not_be_asked(rng, case):
    """On a coarse lattice, many elements touch, in all ways that there are."""
    positions = rng.integers(0, 4, size=(36, 3)).astype(float)
    faces = np.array([rng.permutation(36)[:3] for _ in range(24)], np.int32)
    edges = edges_of(faces)
    found = find_intersections(positions, edges, faces)
    told = tell_sides(positions, faces, found.touching)
    _, through, lost = contacts_through(found, told)
    seen = CrossingMesh(edges, faces).crossings(positions)
    assert np.array_equal(seen.edges, found.crossing_edges[through])
    assert np.array_equal(seen.faces, found.crossed_faces[through])
    assert np.array_equal(seen.touching.nodes, found.touching.nodes[~lost])
    assert 0 < np.count_nonzero(told.sides == Side.CROSSING) < len(told.sides)


def test_welded_vertices_of_a_seam_do_not_touch():
    sheet, faces = grid(4)
    seam = np.concatenate((sheet, sheet[:4]))
    faces = np.array(faces)
    first = faces[:, 0] < 4
    # Half of the faces along one border have copies of its vertices.
    rows = np.flatnonzero(first)[::2]
    faces[rows] = np.where(faces[rows] < 4, faces[rows] + 16, faces[rows])
    apart = list(inspect_sequence([seam, seam + 1.0], faces))
    assert verdicts(apart) == [Verdict.TOUCHES] * 2
    welded = list(inspect_sequence([seam, seam + 1.0], faces, weld=0.0))
    assert verdicts(welded) == [Verdict.CLEAN] * 2
    torn = seam + 1.0
    torn[16:, 2] += 0.1
    with pytest.raises(errors.WeldError, match="frame 1"):
        list(inspect_sequence([seam, torn], faces, weld=0.0))


@pytest.mark.parametrize("exponent", [-900, -300, 300, 900])
def test_the_size_of_the_scene_does_not_matter(exponent):
    frames, faces, parts = dipping_spike()
    found = list(inspect_sequence(frames, faces, None, parts))
    scaled = list(inspect_sequence([np.ldexp(f, exponent) for f in frames], faces, None, parts))
    for one, other in zip(found, scaled, strict=True):
        assert (one.crossings, one.contours, one.verdict) == (
            other.crossings,
            other.contours,
            other.verdict,
        )
        assert np.ldexp(one.depth, exponent) == pytest.approx(other.depth)
        assert np.ldexp(one.width, exponent) == pytest.approx(other.width)
        assert np.ldexp(one.reach, exponent) == pytest.approx(other.reach)


def test_frames_are_taken_one_at_a_time_and_not_kept(rng):
    base, faces, _ = passing_sheets((0.02,), 12, 0.01 * rng.normal(size=(288, 3)))
    taken = []

    def frames(n):
        for number in range(n):
            taken.append(number)
            yield base[0] + 1e-4 * rng.normal(size=base[0].shape)

    run = inspect_sequence(frames(240), faces)
    tracemalloc.start()
    for number in range(150):  # until all that is kept for good is there
        assert next(run).crossings > 0
        assert taken[-1] == number
    before = tracemalloc.get_traced_memory()[0]
    for _ in range(64):
        next(run)
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert after - before < base[0].nbytes  # less than one of the 64 frames


def test_wrong_input_is_refused_with_the_number_of_the_frame():
    frames, faces, _ = dipping_spike()
    with pytest.raises(errors.ShapeError, match="expected at least one frame"):
        list(inspect_sequence([], faces))
    with pytest.raises(errors.ShapeError, match=r"frame 1: positions: .*\(9, 3\)"):
        list(inspect_sequence([frames[0], frames[1][:8]], faces))
    bad = frames[1].copy()
    bad[2, 1] = np.nan
    with pytest.raises(errors.NonFiniteError, match="frame 8"):
        list(inspect_sequence([frames[0], bad], faces, first=7))
    with pytest.raises(errors.ShapeError, match="parts: expected a part of each of 9 vertices"):
        list(inspect_sequence(frames, faces, parts=[0, 1]))
    with pytest.raises(errors.IndexRangeError, match="parts"):
        list(inspect_sequence(frames, faces, parts=[-1] * 9))
    with pytest.raises(errors.OptionError, match="weld"):
        list(inspect_sequence(frames, faces, weld=-1.0))


def test_the_verdicts_are_in_order():
    assert ORDER[0] is Verdict.CLEAN
    assert ORDER[-1] is Verdict.PINNED

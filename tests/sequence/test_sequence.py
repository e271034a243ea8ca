"""Sequences: what is written is what is certified, frame after frame."""

from itertools import pairwise

import numpy as np
import pytest

import izo_ref
from izo_ref import Scene, Status, certify_path
from izo_ref.base.errors import NonFiniteError, OptionError, ShapeError
from izo_ref.sequence import rounding
from izo_ref.sequence.resolve import resolve_sequence
from izo_ref.sequence.rounding import round_end, rounded
from tests.helpers.shapes import grid, two_sheets, vertex_over_face


def swinging(rng, n_frames, n=6):
    """Return frames in which a sheet swings through a pinned one, the faces and the flags."""
    scene = two_sheets(rng, n, pinned_below=True)
    travel = scene.positions_t1 - scene.positions_t0
    parts = np.sin(np.linspace(0.0, 2.0 * np.pi, n_frames))
    return [scene.positions_t0 + part * travel for part in parts], scene.faces, scene.pinned


def judged(frames, faces, pinned):
    """Certify the way between frames that took one step; return how many were certified."""
    count = 0
    for before, frame in pairwise(frames):
        if frame.substeps == 1 and frame.reached == 1.0:
            scene = Scene(before.positions, frame.positions, faces, None, pinned)
            assert certify_path(scene, frame.positions).free
            count += 1
    return count


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_each_frame_is_certified_as_it_is_written(rng, precision):
    proposed, faces, pinned = swinging(rng, 9)
    found = list(resolve_sequence(proposed, faces, None, pinned, precision=precision))
    assert [frame.number for frame in found] == list(range(9))
    assert {frame.status for frame in found} == {Status.FREE}
    assert judged(found, faces, pinned) == 8
    assert any(frame.impacts for frame in found)
    for frame, wanted in zip(found, proposed, strict=True):
        nearest = rounded(wanted, precision)
        assert np.array_equal(frame.positions, rounded(frame.positions, precision))
        assert np.array_equal(frame.positions[pinned], nearest[pinned])
        if not frame.impacts:
            assert np.array_equal(frame.positions, nearest)


@pytest.mark.parametrize(("away", "thickness"), [(1e3, 1e-6), (1e5, 1e-3)])
def test_vertices_give_way_where_rounding_alone_makes_contact(rng, away, thickness):
    """A float32 near 1e5 m has a spacing of 8 mm, which is eight times this thickness."""
    proposed, faces, pinned = swinging(rng, 5)
    proposed = [frame + away for frame in proposed]
    found = list(
        resolve_sequence(proposed, faces, None, pinned, thickness=thickness, precision="float32")
    )
    assert judged(found, faces, pinned) == 4
    assert any(len(frame.nudged) for frame in found)
    assert not any(len(frame.held) for frame in found)


def test_zones_that_nothing_else_frees_stay_at_the_start(rng, monkeypatch):
    """Without the few floats that vertices may go farther, rounding leaves pairs that meet."""
    monkeypatch.setattr(rounding, "TRIES", ())
    proposed, faces, pinned = swinging(rng, 2)
    start, end = (rounded(frame + 1e5, "float32") for frame in (proposed[0], proposed[1]))
    end[~pinned, 2] -= 0.3
    scene = Scene(start, rounded(end, "float32"), faces, None, pinned)
    result = izo_ref.resolve(scene, 1e-3)
    assert result.certificate.free
    assert not certify_path(scene, rounded(result.positions, "float32")).free
    found = round_end(scene, result, "float32")
    assert found.certificate.free
    assert len(found.held) > 0
    assert len(found.nudged) == 0
    assert np.array_equal(found.positions[found.held], start[found.held])
    assert not pinned[found.held].any()
    assert certify_path(scene, found.positions).free


def test_a_run_that_is_resumed_ends_with_the_same_bits(rng):
    proposed, faces, pinned = swinging(rng, 9)
    whole = list(resolve_sequence(proposed, faces, None, pinned, precision="float32"))
    for at in (1, 4, 7):
        rest = [whole[at].positions, *proposed[at + 1 :]]
        more = {"thickness": whole[1].result.thickness, "first": at}
        again = list(resolve_sequence(rest, faces, None, pinned, precision="float32", **more))
        assert [frame.number for frame in again] == list(range(at, 9))
        for one, other in zip(whole[at:], again, strict=True):
            assert np.array_equal(one.positions, other.positions)


def closing_walls(n_frames):
    """Return frames in which two pinned walls close on a free sheet and pass through each other."""
    low, faces = grid(3, z=-1.0, size=4.0)
    high, _ = grid(3, z=1.0, size=4.0)
    middle, own = grid(3, z=0.0)
    middle[:, :2] += 1.5
    start = np.concatenate((low, high, middle))
    pinned = np.arange(27) < 18
    faces = np.concatenate((faces, faces + 9, own + 18))
    travel = np.zeros((27, 3))
    travel[:9, 2], travel[9:18, 2] = 1.0, -1.0
    return [start + part * travel for part in np.linspace(0.0, 2.0, n_frames)], faces, pinned


def test_a_blocked_frame_is_cut_into_substeps_and_the_sequence_goes_on():
    proposed, faces, pinned = closing_walls(3)
    frames = resolve_sequence(proposed, faces, None, pinned, thickness=1e-3, max_substeps=8)
    start, closed, passed = frames
    assert start.status is Status.FREE
    assert closed.status is Status.BLOCKED
    assert 0.5 <= closed.reached < 1.0
    assert closed.substeps >= 2
    assert len(closed.meeting.nodes) == len(closed.meeting_toi) > 0
    assert (closed.meeting_toi > closed.reached).all()
    assert passed.status is Status.BLOCKED
    assert not np.array_equal(passed.positions, proposed[2])
    heights = passed.positions[:, 2]
    assert heights[:9].max() < heights[18:].min()
    assert heights[18:].max() < heights[9:18].min()


def test_what_crosses_at_the_start_is_left_out_until_it_is_apart():
    """A corner pokes through a pinned face, is lifted out, and is then driven down again."""
    scene = vertex_over_face(pinned=(True, True, True, False))
    start, lift = scene.positions_t0.copy(), np.zeros((6, 3))
    start[3, 2], lift[3, 2] = -0.1, 1.0
    proposed = [start + height * lift for height in (0.0, 0.05, 0.5, -0.5)]
    own = {"thickness": 1e-3, "pinned": scene.pinned}
    found = list(resolve_sequence(proposed, scene.faces, **own))
    counts = [frame.excluded for frame in found]
    assert counts[0] > 0
    assert counts[1] == counts[0]
    assert counts[2:] == [0, 0]
    assert np.array_equal(found[1].positions, proposed[1])
    assert found[1].status is Status.FREE_EXCEPT_EXCLUDED
    assert found[3].status is Status.FREE
    assert found[3].positions[3, 2] == pytest.approx(1e-3)
    with pytest.raises(izo_ref.errors.InitialIntersectionError, match=r"^frame 0: "):
        next(resolve_sequence(proposed, scene.faces, **own, initial_intersections="raise"))


def test_errors_name_the_frame(rng):
    proposed, faces, pinned = swinging(rng, 4)
    proposed[2] = proposed[2][:-1]
    with pytest.raises(ShapeError, match=r"^frame 2: positions: expected shape"):
        list(resolve_sequence(proposed, faces, None, pinned))
    proposed[2] = np.full_like(proposed[1], np.nan)
    with pytest.raises(NonFiniteError, match=r"^frame 12: positions: "):
        list(resolve_sequence(proposed, faces, None, pinned, first=10))
    with pytest.raises(ShapeError, match=r"^frame 0: positions: expected shape"):
        next(resolve_sequence([proposed[0][:, :2]], faces, None, pinned))
    with pytest.raises(ShapeError, match="at least one frame"):
        list(resolve_sequence([], faces))
    for bad in ({"precision": "float16"}, {"max_substeps": 3}, {"max_substeps": 0}):
        with pytest.raises(OptionError, match=next(iter(bad))):
            next(resolve_sequence(proposed, faces, None, pinned, **bad))


def test_frames_are_taken_when_they_are_asked_for(rng):
    proposed, faces, pinned = swinging(rng, 4)
    taken = []

    def frames():
        for number, frame in enumerate(proposed):
            taken.append(number)
            yield frame

    sequence = resolve_sequence(frames(), faces, None, pinned)
    assert taken == []
    next(sequence)
    assert taken == [0]
    next(sequence)
    assert taken == [0, 1]

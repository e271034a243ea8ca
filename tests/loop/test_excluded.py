"""Pairs that are left out: what is resolved beside them, and what is said about them."""

import numpy as np
import pytest
import trimesh

import izo_ref
from izo_ref import Status
from izo_ref.base.records import Exclusion, PairState
from tests.helpers.shapes import grid
from tests.helpers.touching import PARTS
from tests.naive.start import keys_of, pairs_that_meet

THICKNESS = 1e-3
# Ties between impacts at equal times fall another way if there are other parts, and rounds of new
# normals end earlier or later.
NEARLY = THICKNESS


def joined(*parts):
    """Return start, end, faces and pinned of parts, each given by the same four."""
    n, faces = 0, []
    for start, _, own, _ in parts:
        faces.append(np.asarray(own) + n)
        n += len(start)
    starts, ends, _, pinned = zip(*parts, strict=True)
    pins = [np.full(len(start), pin) for start, pin in zip(starts, pinned, strict=True)]
    return np.concatenate(starts), np.concatenate(ends), np.concatenate(faces), np.concatenate(pins)


def sheet(size, height, fall=0.0, shift=0.0, pinned=False):
    """Return a flat sheet of a width of 1 m that falls."""
    start, faces = grid(size)
    start = start - start.mean(axis=0) + (shift, 0.0, height)
    return start, start - (0.0, 0.0, fall), faces, pinned


def scene_of(*parts, **modes):
    """Return the scene of some parts."""
    start, end, faces, pinned = joined(*parts)
    return izo_ref.Scene(start, end, faces, pinned=pinned, **modes)


def bad_and_good():
    """Two pinned sheets that go through each other, and far away a sheet that falls on another."""
    bad = sheet(3, 0.0, pinned=True), sheet(4, 0.1, 0.2, pinned=True)
    good = sheet(4, 0.0, shift=9.0, pinned=True), sheet(5, 0.1, 0.2, shift=9.0)
    return *bad, *good


def test_pinned_parts_that_meet_do_not_stop_the_rest():
    scene = scene_of(*bad_and_good())
    result = izo_ref.resolve(scene, THICKNESS)
    certificate = result.certificate
    assert result.status is Status.FREE_EXCEPT_EXCLUDED
    assert result.converged
    assert set(result.zone_statuses) == {Status.FREE}
    assert scene.pinned[certificate.excluded.nodes].all()
    assert set(certificate.excluded.reasons.tolist()) == {Exclusion.PRESCRIBED}
    assert (certificate.excluded_ends == PairState.APART).all()  # they have gone through
    # the good half alone has the same answer
    alone = izo_ref.resolve(scene_of(*bad_and_good()[2:]), THICKNESS)
    own = result.positions[-len(alone.positions) :]
    np.testing.assert_allclose(own, alone.positions, rtol=0.0, atol=NEARLY)
    with pytest.raises(AttributeError):
        certificate.free = True


@pytest.mark.parametrize("seed", range(12))
def test_pinned_parts_that_cross_in_a_part_of_a_scene_are_the_pairs_that_are_left_out(seed):
    """Random pinned sheets go through each other; the exact pairs are found one by one."""
    rng = np.random.default_rng(seed)
    parts = []
    for k in range(int(rng.integers(2, 4))):
        start, _, faces, _ = sheet(int(rng.integers(2, 4)), 0.2 * k, shift=rng.uniform(-0.3, 0.3))
        start = start @ np.linalg.qr(np.eye(3) + 0.1 * rng.normal(size=(3, 3)))[0]
        parts.append((start, start + rng.uniform(-0.1, 0.1, 3) - (0, 0, 0.35 * k), faces, True))
    parts.append(sheet(4, 0.2 * len(parts) + 0.2, 0.2 * len(parts) + 0.5))
    parts.append(sheet(3, 0.1, shift=9.0, pinned=True))
    parts.append(sheet(4, 0.2, 0.2, shift=9.0))
    scene = scene_of(*parts)
    result = izo_ref.resolve(scene, THICKNESS)
    certificate = result.certificate
    pinned = np.flatnonzero(scene.pinned)
    ends = scene.positions_t0, scene.positions_t1
    expected = {
        key
        for key in pairs_that_meet(*ends, scene.faces[scene.pinned[scene.faces].all(axis=1)])
        if set().union(*key) <= set(pinned.tolist())
    }
    assert expected
    # where an edge goes through a face at the start, all five pairs of the two are left out
    assert keys_of(certificate.excluded) == expected | keys_of(scene.excluded)
    far = scene.positions_t0[:, 0] > 5.0
    for zone, status in enumerate(result.zone_statuses):
        if far[result.zones.vertices_of(zone)].all():
            assert status is Status.FREE
    if certificate.free:
        assert result.status is Status.FREE_EXCEPT_EXCLUDED
    else:
        assert not far[certificate.meeting.nodes].any()
    left = pairs_that_meet(scene.positions_t0, result.positions, scene.faces)
    left -= keys_of(certificate.excluded)
    assert (left == set()) is certificate.free
    assert left == keys_of(certificate.meeting)


def test_pinned_parts_that_meet_block_the_step_if_that_is_asked_for():
    scene = scene_of(*bad_and_good(), prescribed="block")
    result = izo_ref.resolve(scene, THICKNESS)
    certificate = result.certificate
    assert result.status is Status.BLOCKED
    assert certificate.excluded is None
    assert certificate.meeting_prescribed.all()
    assert (np.diff(certificate.meeting_toi) >= 0.0).all()
    assert certificate.time_free == certificate.meeting_toi[0] == result.time_free
    assert result.time_free == pytest.approx(0.5)


def test_pinned_parts_that_cross_at_the_start_are_left_out_and_named():
    needle = np.array([[0.1, 0.03, -0.3], [0.1, 0.03, 0.2], [0.2, 0.03, 0.2]])
    parts = sheet(3, 0.0, pinned=True), (needle, needle, [[0, 1, 2]], True), sheet(3, 0.5, 0.2)
    scene = scene_of(*parts)
    assert set(scene.excluded.reasons.tolist()) == {Exclusion.PRESCRIBED}
    result = izo_ref.resolve(scene, THICKNESS)
    assert result.status is Status.FREE_EXCEPT_EXCLUDED
    assert (result.certificate.excluded_ends == PairState.CROSSING).all()
    with pytest.raises(izo_ref.errors.InitialIntersectionError, match="through a face"):
        scene_of(*parts, prescribed="block")
    # an edge with a free end is no pinned part
    start, end, faces, pinned = joined(*parts)
    pinned[len(parts[0][0])] = False
    with pytest.raises(izo_ref.errors.InitialIntersectionError, match="2 edges that go through"):
        izo_ref.Scene(start, end, faces, pinned=pinned)


def test_a_blocked_zone_does_not_stop_the_others():
    """Two pinned plates shut on a sheet; far away and later, a sheet falls on another."""
    shut = [sheet(4, h, f, pinned=True) for h, f in ((0.2, 0.3), (-0.2, -0.3))]
    good = sheet(4, 0.0, shift=9.0, pinned=True), sheet(5, 0.18, 0.2, shift=9.0)
    parts = (*shut, sheet(3, 0.0), *good)
    scene = scene_of(*parts)
    result = izo_ref.resolve(scene, THICKNESS)
    certificate = result.certificate
    assert result.status is Status.BLOCKED
    assert {Status.FREE, Status.BLOCKED} <= set(result.zone_statuses)
    alone = izo_ref.resolve(scene_of(*good), THICKNESS)
    n = len(alone.positions)
    np.testing.assert_allclose(result.positions[-n:], alone.positions, rtol=0.0, atol=NEARLY)
    assert certificate.meeting.nodes.max() < len(scene.positions_t0) - n
    assert (np.diff(certificate.meeting_toi) >= 0.0).all()
    for zone, status in enumerate(result.zone_statuses):
        near = result.zones.vertices_of(zone).max() < len(scene.positions_t0) - n
        assert (status is Status.BLOCKED) is bool(near)
    part = scene.positions_t0 + 0.999 * result.time_free * (result.positions - scene.positions_t0)
    assert izo_ref.certify_path(scene, part).free


def test_a_step_is_not_free_if_pairs_are_left_out_that_fall_through():
    """A flat sheet on a flat table, in one plane: the mesh does not say which one is above."""
    parts = sheet(3, 0.0, pinned=True), sheet(2, 0.0, 0.1)
    for mode in ("ratchet", "exclude"):
        scene = scene_of(*parts, initial_intersections=mode)
        assert set(scene.excluded.reasons.tolist()) == {Exclusion.TOUCHING}
        result = izo_ref.resolve(scene, THICKNESS)
        assert result.status is Status.FREE_EXCEPT_EXCLUDED
        assert (result.certificate.excluded_ends == PairState.APART).all()
        following = scene.after(result, scene.positions_t0)  # protected once they are apart
        assert following.excluded is None
        assert izo_ref.resolve(following, THICKNESS).status is Status.FREE


def test_a_ratchet_only_closes():
    """A needle that pierces one of two faces slides to the other; nothing new is left out."""
    flat = np.array([[-4.0, -3, 0], [0, 3, 0], [4, -3, 0], [0, -3, 0]])
    needle = np.array([[-0.5, -1, -1], [-0.5, -1, 1], [-0.4, -1, 2]])
    start, faces = np.concatenate((flat, needle)), [[0, 1, 3], [1, 2, 3], [4, 5, 6]]
    slide = np.where(np.arange(7)[:, None] < 4, 0.0, (1.0, 0.0, 0.0))
    pinned = np.ones(7, bool)
    pinned[6] = False
    modes = {"pinned": pinned, "prescribed": "block"}
    counts = {}
    for mode in ("ratchet", "exclude"):
        step = izo_ref.Scene(start, start + slide, faces, **modes, initial_intersections=mode)
        first = set(map(tuple, step.excluded.nodes.tolist()))
        result = izo_ref.resolve(step, THICKNESS)
        assert result.status is Status.FREE_EXCEPT_EXCLUDED
        assert PairState.CROSSING in result.certificate.excluded_ends
        following = step.after(result, start + slide)
        own = set(map(tuple, following.excluded.nodes.tolist()))
        counts[mode] = len(own - first)
        assert own
    assert counts["ratchet"] == 0
    assert counts["exclude"] > 0


def test_a_vertex_that_lifts_off_and_comes_back_is_an_impact():
    """The vertex is 0.8 t - 1.2 t^2 above the face, which turns after it; or it rises faster."""
    face = np.array([[-4.0, -4, 0], [4, -4, 0], [0, 4, 0]])
    tip, own = PARTS["tip"]
    start = np.concatenate((face, tip))
    for height, meets in ((2.0, True), (6.0, False)):
        end = start.copy()
        end[3:] += (2.0, 0.0, height)
        end[:3, 2] = 0.3 * face[:, 0] ** 2 * (face[:, 0] > 0)  # corner 1 rises by 4.8 m
        faces = np.concatenate(([[0, 1, 2]], np.array(own) + 3))
        scene = izo_ref.Scene(start, end, faces, initial_intersections="ratchet")
        assert scene.excluded is None
        found = izo_ref.find_impacts(scene)
        assert ([3, 0, 1, 2] in found.nodes[~found.is_edge_edge].tolist()) is meets
        result = izo_ref.resolve(scene, THICKNESS)
        assert result.status is Status.FREE
        assert (result.objective == 0.0) is not meets


def test_a_soup_that_touches_everywhere_is_pushed_apart():
    """A ball of faces without common vertices; every pair of neighbours tells its side."""
    ball = trimesh.creation.icosphere(subdivisions=1)
    faces = np.arange(3 * len(ball.faces)).reshape(-1, 3)
    start = ball.vertices[ball.faces.ravel()]
    scene = izo_ref.Scene(start, start, faces, initial_intersections="ratchet")
    assert scene.excluded is None
    result = izo_ref.resolve(scene, THICKNESS)
    assert result.status is Status.FREE
    assert 0.0 < result.objective < 1e-5
    assert scene.after(result, start).touching is None


def test_exclusion_modes_are_checked():
    start, _, faces, _ = sheet(2, 0.0)
    with pytest.raises(izo_ref.errors.OptionError, match="prescribed: expected one of"):
        izo_ref.Scene(start, start, faces, prescribed="ignore")
    with pytest.raises(izo_ref.errors.OptionError, match="initial_intersections"):
        izo_ref.Scene(start, start, faces, initial_intersections=True)


def test_pinned_pairs_that_met_stay_left_out_when_their_vertices_are_set_free():
    start = np.array([[-1.0, 0, 1], [1, 0, 1], [0, 0, 3], [0, -1, 0], [0, 1, 0], [0, 0, -3]])
    end = start.copy()
    end[:3, 2] -= 1.5
    modes = {"pinned": [1, 1, 0, 1, 1, 0], "initial_intersections": "ratchet"}
    scene = izo_ref.Scene(start, end, [[0, 1, 2], [3, 4, 5]], **modes)
    result = izo_ref.resolve(scene, THICKNESS)
    assert result.certificate.excluded.nodes.tolist() == [[0, 1, 3, 4]]
    following = scene.after(result, result.positions, pinned=np.zeros(6, bool))
    assert following.excluded.nodes.tolist() == [[0, 1, 3, 4]]
    again = izo_ref.resolve(following, THICKNESS)
    assert again.status is Status.FREE_EXCEPT_EXCLUDED
    assert again.certificate.excluded_ends.tolist() == [PairState.CROSSING]


def test_pairs_that_met_between_pinned_corners_of_free_faces_stay_left_out():
    """A pinned corner goes through another one; two edges that begin there touch at the end."""
    start = np.array([[0.0, 0, 1], [1, 0, 3], [0, 1, 3], [0, 0, 0], [1, 0, 0], [0, 1, 0]])
    end = start.copy()
    end[:3, 2] -= 1.5
    modes = {"pinned": [1, 0, 0, 1, 0, 0], "initial_intersections": "ratchet"}
    scene = izo_ref.Scene(start, end, [[0, 1, 2], [3, 4, 5]], **modes)
    assert scene.excluded is None
    result = izo_ref.resolve(scene, THICKNESS)
    assert PairState.TOUCHING in result.certificate.excluded_ends
    following = scene.after(result, result.positions)
    assert izo_ref.resolve(following, THICKNESS).status is Status.FREE_EXCEPT_EXCLUDED

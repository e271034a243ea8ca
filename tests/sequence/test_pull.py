"""The pull: what is tangled comes apart, and no frame adds a crossing."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from izo_ref import Status
from izo_ref.base.errors import OptionError
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.scene import Scene
from izo_ref.sequence import pull as pulling
from izo_ref.sequence.pull import RINGS, Pull
from izo_ref.sequence.resolve import resolve_sequence
from tests.helpers.shapes import grid
from validation.oracles import fcl, ipc
from validation.scenes.tangles import Tangle, crossed_corner, crossed_sheets, layered_shells


def loop(n=20):
    """Return a sheet that is bent to a loop, so that its two ends go through each other.

    Its section is the trochoid x = c t - sin t, z = -cos t, which crosses itself where sin t is
    c t. The middle is pinned.
    """
    rng = np.random.default_rng(7)
    flat, faces = grid(n, size=1.0)
    angle = 2.7 * (2.0 * flat[:, 0] - 1.0)
    across = 5.0 * flat[:, 1] + 0.03 * angle  # half a cell, so that columns do not meet columns
    section = np.column_stack((0.4 * angle - np.sin(angle), across, -np.cos(angle)))
    positions = section + rng.uniform(-0.01, 0.01, section.shape)
    return Tangle(positions, faces.astype(np.int32), np.ones(n * n), np.abs(angle) < 0.2)


# name: what makes the tangle, number of frames, pull over the length of an edge, crossings left
TANGLES = {
    "corner": (crossed_corner, 10, 0.5, 0),
    "sheets": (crossed_sheets, 10, 0.5, 0),
    "shells": (layered_shells, 8, 0.5, 0),
    "loop": (loop, 12, 0.5, 65),
}


def edge_length(tangle):
    """Return the median length of the edges [m]."""
    ends = tangle.positions_t0[edges_of(tangle.faces)]
    return float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))


def crossings_of(tangle, positions):
    """Return the crossings of a mesh at rest, as a set of vertices of the edge and of the face."""
    found = find_intersections(positions, edges_of(tangle.faces), tangle.faces)
    rows = np.hstack((found.crossing_edges, np.sort(found.crossed_faces, axis=1)))
    return set(map(tuple, rows.tolist()))


def still(tangle, n_frames, **named):
    """Resolve an animation that stands still in a tangle."""
    frames = [tangle.positions_t0] * (n_frames + 1)
    return list(resolve_sequence(frames, tangle.faces, tangle.masses, tangle.pinned, **named))


@pytest.fixture(scope="module", params=TANGLES)
def pulled(request):
    """Return a tangle, its frames with a pull, and the largest number of crossings left."""
    make, n_frames, edges, left = TANGLES[request.param]
    tangle = make()
    return tangle, still(tangle, n_frames, pull=edges * edge_length(tangle)), left


def test_a_tangle_comes_apart_and_no_frame_adds_a_crossing(pulled):
    tangle, frames, left = pulled
    counts = [len(crossings_of(tangle, frame.positions)) for frame in frames]
    assert counts == [frame.crossings for frame in frames]
    assert counts[0] > 20
    assert (np.diff(counts) <= 0).all()
    assert (np.diff([frame.excluded for frame in frames]) <= 0).all()
    assert counts[-1] <= left
    assert (frames[-1].excluded == 0) == (counts[-1] == 0)
    assert frames[-1].status is not Status.BLOCKED


def test_pinned_vertices_stay_and_no_pull_changes_nothing(pulled):
    tangle, frames, _ = pulled
    for frame in frames:
        start = tangle.positions_t0
        assert np.array_equal(frame.positions[tangle.pinned], start[tangle.pinned])
    unpulled = still(tangle, 2)
    assert unpulled[0].crossings is None
    assert np.array_equal(unpulled[-1].positions, tangle.positions_t0)
    assert unpulled[-1].excluded == frames[0].excluded


def test_protected_pairs_never_meet_as_ipctk_sees_it(pulled):
    """Whatever Tight Inclusion finds on the path of a frame was left out in that frame."""
    if reason := ipc.unusable():
        pytest.skip(f"ipctk: {reason}")
    tangle, frames, _ = pulled
    edges, judged = edges_of(tangle.faces), 0
    for before, frame in pairwise(frames):
        if frame.substeps == 1:
            path = before.positions, frame.positions
            hits = ipc.path_hits(*path, edges, tangle.faces, at_most=10**5)
            left_out = frame.certificate.excluded
            known = set() if left_out is None else set(pair_keys(left_out))
            assert hits.complete
            assert set(pair_keys(hits)) <= known
            judged += len(hits.toi)
    assert judged > 0


def test_crossings_are_those_that_fcl_sees(pulled):
    """FCL lists pairs of faces that meet: an edge of one of the two goes through the other."""
    tangle, frames, _ = pulled
    for frame in frames[:: len(frames) - 1]:
        pairs = tangle.faces[fcl.crossing_faces(frame.positions, tangle.faces)]
        through = {
            (frozenset(row[:2]), frozenset(row[2:]))
            for row in crossings_of(tangle, frame.positions)
        }
        for pair in pairs.tolist():
            assert any(
                (frozenset(edge), frozenset(second)) in through
                for first, second in (pair, pair[::-1])
                for edge in combinations(first, 2)
            )
        assert (len(pairs) == 0) == (len(through) == 0)


def test_a_new_crossing_shares_a_pair_with_an_old_one(pulled):
    """So no contour arises where there was none."""
    tangle, frames, _ = pulled
    edges = edges_of(tangle.faces)
    checked = 0
    for before, frame in pairwise(frames):
        if frame.substeps > 1:
            continue
        known = set(pair_keys(find_intersections(before.positions, edges, tangle.faces).pairs()))
        new = crossings_of(tangle, frame.positions) - crossings_of(tangle, before.positions)
        found = find_intersections(frame.positions, edges, tangle.faces)
        for i, row in enumerate(np.hstack((found.crossing_edges, found.crossed_faces)).tolist()):
            if (*row[:2], *sorted(row[2:])) in new:
                own = found._replace(
                    crossing_edges=found.crossing_edges[i : i + 1],
                    crossed_faces=found.crossed_faces[i : i + 1],
                )
                assert known & set(pair_keys(own.pairs()))
                checked += 1
    assert checked > 0


@pytest.mark.parametrize("make", [crossed_corner, layered_shells])
def test_displacements_are_bounded_and_fade_away(make):
    tangle, bound = make(), 0.01
    start = tangle.positions_t0
    scene = Scene(start, start, *tangle[1:], initial_intersections="exclude")
    pull = Pull(scene, bound, start)
    moved = pull.displaced(start, pull.tangle, start, start, 1.0) - start
    length = np.linalg.norm(moved, axis=1)
    assert 0.3 * bound < length.max() <= bound * (1.0 + 1e-12)
    assert not moved[tangle.pinned].any()
    near = np.zeros(len(start), bool)
    near[pull.tangle.found.crossing_edges] = near[pull.tangle.found.crossed_faces] = True
    edges = edges_of(tangle.faces)
    for _ in range(RINGS):
        touched = edges[near[edges].any(axis=1)]
        near[touched] = True
    assert not moved[~near].any()
    assert np.array_equal(pull.staying(start, start), start)


def test_the_lighter_side_gives_way():
    tangle = crossed_corner()
    start, masses = tangle.positions_t0, tangle.masses.copy()
    level = np.arange(len(start)) < 17 * 17
    masses[level] *= 1e6
    scene = Scene(
        start, start, tangle.faces, masses, tangle.pinned, initial_intersections="exclude"
    )
    pull = Pull(scene, 0.01, start)
    moved = np.linalg.norm(pull.displaced(start, pull.tangle, start, start, 1.0) - start, axis=1)
    assert moved[level].max() < 1e-4 * moved[~level].max()


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_a_run_that_is_resumed_ends_with_the_same_bits(precision):
    tangle = crossed_sheets()
    named = {"pull": 0.05, "precision": precision}
    sway = np.array([0.01, 0.02, 0.005])
    frames = [tangle.positions_t0 + k * sway * ~tangle.pinned[:, None] for k in range(7)]
    mesh = tangle[1:]
    whole = list(resolve_sequence(frames, *mesh, **named))
    for at in (1, 4):
        rest = [whole[at].positions, *frames[at + 1 :]]
        more = {"thickness": whole[1].result.thickness, "first": at, "first_proposed": frames[at]}
        again = list(resolve_sequence(rest, *mesh, **named, **more))
        for one, other in zip(whole[at:], again, strict=True):
            assert one.number == other.number
            assert one.crossings == other.crossings
            assert np.array_equal(one.positions, other.positions)


def test_a_tangle_that_is_carried_along_comes_apart():
    """All vertices move, the pinned ones too; what comes apart is as if nothing moved."""
    tangle = crossed_corner()
    frames = [tangle.positions_t0 + 0.2 * k for k in range(11)]
    found = list(resolve_sequence(frames, *tangle[1:], pull=0.7 * edge_length(tangle)))
    counts = [frame.crossings for frame in found]
    assert (np.diff(counts) <= 0).all()
    assert counts[-1] == 0
    assert np.array_equal(found[-1].positions[tangle.pinned], frames[-1][tangle.pinned])


def test_where_nothing_is_tangled_a_pull_changes_no_bit():
    low, faces = grid(4)
    high, _ = grid(4, z=0.5)
    start = np.concatenate((low, high))
    frames = [
        start - (np.arange(32) >= 16)[:, None] * np.array([0.0, 0.0, 0.2 * k]) for k in range(5)
    ]
    both = np.concatenate((faces, faces + 16))
    one, other = (list(resolve_sequence(frames, both, pull=pull)) for pull in (0.0, 0.3))
    for left, right in zip(one, other, strict=True):
        assert np.array_equal(left.positions, right.positions)
        assert right.crossings == 0


@pytest.mark.parametrize("pull", [-1.0, np.nan, np.inf, "much", True])
def test_a_wrong_pull_is_refused(pull):
    tangle = crossed_corner()
    with pytest.raises(OptionError, match=r"^pull: expected a finite number of metres >= 0, got"):
        still(tangle, 1, pull=pull)
    with pytest.raises(OptionError, match=r"^pull: expected initial_intersections='ratchet'"):
        still(tangle, 1, pull=0.1, initial_intersections="exclude")


def test_an_obstacle_that_is_driven_deeper_pushes_the_sheet_and_adds_no_crossing():
    """All vertices of the corner are pinned; the level sheet gives way, with its rim pinned."""
    tangle = crossed_corner()
    of_corner = np.arange(len(tangle.positions_t0)) >= 17 * 17
    pinned = tangle.pinned | of_corner
    down = np.where(of_corner[:, None], (0.0, 0.0, -0.02), 0.0)
    frames = [tangle.positions_t0 + k * down for k in range(6)]
    found = list(resolve_sequence(frames, tangle.faces, None, pinned, pull=0.03))
    assert (np.diff([frame.crossings for frame in found]) <= 0).all()
    assert found[-1].crossings < found[0].crossings
    for frame, proposed in zip(found, frames, strict=True):
        assert frame.status is not Status.BLOCKED
        assert np.array_equal(frame.positions[pinned], proposed[pinned])


@pytest.mark.parametrize("exponent", [-200, 200])
def test_a_tangle_of_any_size_comes_apart(exponent):
    """A power of two changes no bit of the numbers but their exponents."""
    tangle, scale = crossed_corner(), 2.0**exponent
    pull = 0.5 * edge_length(tangle)
    large = tangle._replace(positions_t0=scale * tangle.positions_t0)
    one, other = still(tangle, 3, pull=pull), still(large, 3, pull=scale * pull)
    assert [frame.crossings for frame in one] == [frame.crossings for frame in other]
    assert other[-1].crossings < other[0].crossings


def test_without_the_count_frames_would_add_crossings(monkeypatch):
    """So the tests above can fail: a contour that moves passes states with more crossings."""
    monkeypatch.setattr(pulling.Tangle, "adds_to", lambda one, other: False)
    counts = [frame.crossings for frame in still(crossed_sheets(), 6, pull=0.02)]
    assert max(np.diff(counts)) > 0

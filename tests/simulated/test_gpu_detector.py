"""Detection on the GPU finds what detection on the CPU finds, with the same bits."""

from itertools import pairwise

import numpy as np
import pytest

import izo_ref
from izo_ref.base import gpu_arrays as arrays
from izo_ref.base.cuda import memory
from izo_ref.base.cuda.program import Program
from izo_ref.base.cuda.simulated import array_of
from izo_ref.base.records import ExcludedPairs
from izo_ref.detection import gpu_detector as detect
from izo_ref.detection.detector import Detector
from izo_ref.detection.serial import found_counts as places
from izo_ref.detection.trees import VertexBoxes
from tests.helpers.same import same_columns
from tests.helpers.shapes import two_sheets, vertex_over_face
from tests.helpers.touching import random_scene


def scenes(rng):
    """Return small scenes by name; nothing moves in the last one."""
    sheets = two_sheets(rng, 4)
    still = two_sheets(rng, 3)
    still.positions_t1[:9] = still.positions_t0[:9]
    apart = two_sheets(rng, 3)
    apart.positions_t1[:] = apart.positions_t0
    return {"face": vertex_over_face(), "sheets": sheets, "one-still": still, "nothing": apart}


@pytest.mark.parametrize("name", ["face", "sheets", "one-still", "nothing"])
def test_impacts_are_those_of_the_cpu(rng, name):
    scene = scenes(rng)[name]
    expected = izo_ref.find_impacts(scene)
    found = izo_ref.find_impacts(scene, device="cuda")
    assert (len(expected.toi) > 0) == (name != "nothing")
    for own, other in zip(found, expected, strict=True):
        assert own.dtype == other.dtype
        assert np.array_equal(own, other)


def test_most_pairs_are_settled_in_float32(rng):
    scene = two_sheets(rng, 4)
    detector, on_cpu = detect.Detector(scene), Detector.of_scene(scene)
    on_cpu.find(scene.positions_t1)
    n_contacts = detector.find(arrays.to_gpu(scene.positions_t1)).toi.shape[0]
    counts = detector.counts
    assert counts.pairs == on_cpu.counts.pairs
    n = sum(counts.pairs.values())
    assert 0.9 * (n - n_contacts) <= counts.settled <= n - n_contacts
    assert 0 < counts.steps <= on_cpu.counts.steps
    assert counts.most_steps <= on_cpu.counts.most_steps


def test_excluded_pairs_are_left_out(rng):
    scene = two_sheets(rng, 3)
    every = izo_ref.find_impacts(scene)
    scene.excluded = ExcludedPairs(
        every.nodes[::2], every.is_edge_edge[::2], np.zeros(len(every.toi[::2]), np.int8)
    )
    found = izo_ref.find_impacts(scene, device="cuda")
    assert len(found.toi) == len(every.toi) // 2
    assert np.array_equal(found.nodes, izo_ref.find_impacts(scene).nodes)


@pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
@pytest.mark.parametrize("twins", [False, True])
def test_starts_that_touch_or_cross_end_as_on_the_cpu(twins):
    """With and without faces that have the same corners as others."""
    seen = np.zeros(2, int)
    for seed in range(8):
        start, end, faces, pinned = random_scene(np.random.default_rng(seed))
        if twins:
            faces = np.concatenate((faces, faces[:, [1, 2, 0]]))
        scene = izo_ref.Scene(start, end, faces, pinned=pinned, initial_intersections="ratchet")
        seen += scene.touching is not None, scene.excluded is not None
        expected, found = (izo_ref.find_impacts(scene, device=name) for name in ("cpu", "cuda"))
        for own, other in zip(found, expected, strict=True):
            assert np.array_equal(own, other)
        by_cpu, by_gpu = (izo_ref.resolve(scene, 0.01, name) for name in ("cpu", "cuda"))
        assert by_gpu.status is by_cpu.status
        assert np.array_equal(by_gpu.positions, by_cpu.positions)
    assert seen.min() > 1


def test_boxes_hold_all_elements_and_lanes_mark_the_moving_ones(rng):
    scene = two_sheets(rng, 6)
    still = rng.random(len(scene.masses)) < 0.8
    scene.positions_t1[still] = scene.positions_t0[still]
    detector = detect.Detector(scene)
    for tree in detector.trees:  # old values in the boxes above leaves must not matter
        n, blocks = len(tree.nodes), array_of(tree.blocks)
        for first in arrays.to_cpu(tree.levels)[:-1]:
            for i in range(n):
                blocks[first + i // 8, :, i % 8] = 9e9
            n = -(-n // 8)
    detector.find(arrays.to_gpu(scene.positions_t1))
    none = np.zeros(len(still))
    of_vertices = VertexBoxes(scene.positions_t0, scene.positions_t1, none).boxes
    for tree in detector.trees:
        nodes, blocks, lanes, levels = (arrays.to_cpu(a) for a in tree[1:])
        ends = of_vertices[nodes]
        low, high = ends.min(axis=1), ends.max(axis=1)
        boxes = np.hstack((low[:, :3], high[:, :3], low[:, 3:6], high[:, 6:]))
        moves = ~still[nodes].all(axis=1)
        assert len(levels) > 2
        for first, end in pairwise(levels):
            found = blocks[first:end].transpose(0, 2, 1).reshape(-1, 12)[: len(boxes)]
            assert np.array_equal(found, boxes)
            bits = np.unpackbits(lanes[first:end], bitorder="little").astype(bool)
            assert np.array_equal(bits[: len(moves)], moves)
            assert not bits[len(moves) :].any()
            begins = np.arange(0, len(boxes), 8)
            least, most = np.minimum.reduceat(boxes, begins), np.maximum.reduceat(boxes, begins)
            is_low = np.arange(12) % 6 < 3
            boxes, moves = np.where(is_low, least, most), np.maximum.reduceat(moves, begins)


def test_lists_grow_until_everything_has_room(rng, monkeypatch):
    monkeypatch.setattr(detect, "PAIRS_PER_QUERY", 0)
    monkeypatch.setattr(detect, "CONTACTS_PER_VERTEX", 0)
    monkeypatch.setattr(detect, "LEAST_CONTACTS", 1)
    scene = two_sheets(rng, 3)
    expected, detector = izo_ref.find_impacts(scene), detect.Detector(scene)
    end, launched = arrays.to_gpu(scene.positions_t1), []
    prepare = detector.launches

    def counted(*arguments):
        launched.append(arguments)
        return prepare(*arguments)

    monkeypatch.setattr(detector, "launches", counted)
    same_columns(detector.find(end), expected)
    # there was no room for pairs, then too little for contacts, then enough
    assert len(launched) == 3
    assert detector.counts.moved == len(scene.masses)
    same_columns(detector.find(end), expected)
    assert len(launched) == 3
    assert detector.counts.moved == 0


def test_a_list_grows_at_least_to_twice_its_room(rng):
    detector = detect.Detector(two_sheets(rng, 2))
    room = detector._pairs.shape[0]
    counts = np.zeros(places.N_COUNTS, np.int64)
    assert not detector.grow(counts)
    for n_pairs, n_rows in ((room + 1, 2 * room), (9 * room, 9 * room)):
        counts[places.PAIRS] = n_pairs
        assert detector.grow(counts)
        assert detector._pairs.shape[0] == n_rows
        assert not detector.grow(counts)
    counts[places.CONTACTS] = detect.LEAST_CONTACTS + 1
    assert detector.grow(counts)
    assert detector._contacts.keys.shape[0] == 2 * detect.LEAST_CONTACTS


def test_detections_count_the_vertices_that_moved_since_the_last_one(rng):
    scene = two_sheets(rng, 2)
    detector, end = detect.Detector(scene), scene.positions_t1.copy()
    for n_moved in (len(end), 0, 3):
        end[:n_moved, 1] += 1e-3 if n_moved == 3 else 0.0
        detector.find(arrays.to_gpu(end))
        assert detector.counts.moved == n_moved


def test_a_detector_takes_the_start_of_the_step_that_follows(rng):
    scene = two_sheets(rng, 3)
    detector = detect.Detector(scene)
    detector.find(arrays.to_gpu(scene.positions_t1))
    result = izo_ref.resolve(scene, 1e-3)
    following = scene.after(result, result.positions + 0.1 * rng.normal(size=(18, 3)))
    every = izo_ref.find_impacts(following)
    assert len(every.toi) > 4
    detector.go_on(arrays.to_gpu(following.positions_t0))
    same_columns(detector.find(arrays.to_gpu(following.positions_t1)), every)
    assert detector.counts.moved == 18


def found_to_solve(scene, end):
    """Return a detector, and what its launches find without impacts between pinned points."""
    counts = arrays.empty(places.N_COUNTS, np.int64)
    detector = detect.Detector(scene, counts)
    Program(detector.launches(end, True)).run()
    return detector, detector.found(arrays.to_cpu(counts), end, True)


@pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
@pytest.mark.parametrize("gap", [0.05, 5e-324])
def test_impacts_between_pinned_points_are_left_out_and_counted(gap):
    """Two vertices fall onto faces, one of them pinned; the second time, from the faces."""
    start = np.concatenate([own.positions_t0 for own in (vertex_over_face(), vertex_over_face())])
    start[6:, 0] += 9.0
    start[[3, 9], 2] = gap
    end = start.copy()
    end[[3, 9], 2] -= 0.2
    faces = np.array([[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]])
    pinned = np.isin(np.arange(12), (0, 1, 2, 3, 6, 7, 8))
    scene = izo_ref.Scene(start, end, faces, pinned=pinned)
    expected = izo_ref.find_impacts(scene)
    kept = ~pinned[expected.nodes].all(axis=1)
    assert kept.tolist().count(False) == 1
    end = arrays.to_gpu(end)
    detector, found = found_to_solve(scene, end)
    same_columns(found.impacts, expected.take(kept))
    assert found.n_blocked == 1
    assert found.time_free == expected.toi[kept].min()
    same_columns(detector.find(end), expected)


def test_launches_detect_where_a_program_runs_them(rng):
    scene = two_sheets(rng, 3)
    expected = izo_ref.find_impacts(scene)
    counts, end = arrays.empty(64, np.int64), arrays.to_gpu(scene.positions_t0)
    own = counts[16 : 16 + places.N_COUNTS]
    detector = detect.Detector(scene, own)
    program = Program(detector.launches(end, True))
    assert len(program.launches) == 5
    program.run()
    assert arrays.to_cpu(own)[places.FOUND] == 0
    end.copy_to_device(scene.positions_t1)
    program.run()
    found = detector.found(arrays.to_cpu(own), end, True)
    same_columns(found.impacts, expected)
    assert (found.n_blocked, found.time_free) == (0, expected.toi.min())


def test_a_detection_makes_no_array_after_the_first_one(rng, monkeypatch):
    scene = two_sheets(rng, 2)
    detector, end = detect.Detector(scene), arrays.to_gpu(scene.positions_t1)
    detector.find(end)

    def refuse(*_):
        raise AssertionError("an array was made")

    monkeypatch.setattr(memory, "Block", refuse)
    assert detector.find(end).toi.shape[0] > 0


@pytest.mark.parametrize("n", [0, 1, 9])
def test_vertices_without_faces_have_no_impacts(rng, n):
    start, end = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    scene = izo_ref.Scene(start, end, np.empty((0, 3), np.int32))
    detector, found = found_to_solve(scene, arrays.to_gpu(end))
    assert found.impacts.toi.shape == (0,)
    assert (found.n_blocked, found.time_free) == (0, 1.0)
    assert detector.counts.moved == n

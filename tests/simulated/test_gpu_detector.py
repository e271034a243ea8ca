"""Detection on the GPU finds what detection on the CPU finds, with the same bits."""

from itertools import pairwise

import numpy as np
import pytest

import izo_ref
from izo_ref.base import gpu_arrays as arrays
from izo_ref.base.cuda.simulated import array_of
from izo_ref.base.records import ExcludedPairs
from izo_ref.detection import gpu_detector as detect
from izo_ref.detection.trees import VertexBoxes
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
    for seed in range(24):
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
    assert seen.min() > 5


def test_boxes_hold_all_elements_and_lanes_mark_the_moving_ones(rng):
    scene = two_sheets(rng, 6)
    still = rng.random(len(scene.masses)) < 0.8
    scene.positions_t1[still] = scene.positions_t0[still]
    detector = detect.Detector(scene)
    for elements in detector._elements:  # old values in the boxes above leaves must not matter
        n, blocks = len(elements.tree.nodes), array_of(elements.tree.blocks)
        for first in elements.levels[:-1]:
            for i in range(n):
                blocks[first + i // 8, :, i % 8] = 9e9
            n = -(-n // 8)
    detector.find(arrays.to_gpu(scene.positions_t1))
    none = np.zeros(len(still))
    of_vertices = VertexBoxes(scene.positions_t0, scene.positions_t1, none).boxes
    for elements in detector._elements:
        nodes, blocks, lanes, levels = (arrays.to_cpu(a) for a in elements.tree[1:])
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


def test_many_batches_find_what_one_batch_finds(rng, monkeypatch):
    scene = two_sheets(rng, 3)
    expected = izo_ref.find_impacts(scene, device="cuda")
    sizes, meeting_pairs = [], detect._meeting_pairs

    def counted_pairs(*trees):
        pairs = meeting_pairs(*trees)
        sizes.append(pairs.shape[0])
        return pairs

    monkeypatch.setattr(detect, "_meeting_pairs", counted_pairs)
    monkeypatch.setattr(detect, "BATCH", 7)
    found = izo_ref.find_impacts(scene, device="cuda")
    assert max(sizes) > 2 * detect.BATCH
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(own, other)

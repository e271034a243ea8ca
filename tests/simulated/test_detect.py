"""Detection on the device, against that of the processor: the same bits."""

import numpy as np
import pytest

import izo_ref
from izo_ref.gpu import detect
from izo_ref.types import Pairs
from tests.shapes import two_sheets, vertex_over_face


def scenes(rng):
    sheets = two_sheets(rng, 4)
    still = two_sheets(rng, 3)
    still.positions_t1[:9] = still.positions_t0[:9]
    apart = two_sheets(rng, 3)
    apart.positions_t1[:] = apart.positions_t0
    return {"face": vertex_over_face(), "sheets": sheets, "one-still": still, "nothing": apart}


@pytest.mark.parametrize("name", ["face", "sheets", "one-still", "nothing"])
def test_impacts_are_those_of_the_processor(rng, name):
    scene = scenes(rng)[name]
    expected = izo_ref.find_impacts(scene)
    found = izo_ref.find_impacts(scene, device="cuda")
    assert (len(expected.toi) > 0) == (name != "nothing")
    for own, other in zip(found, expected, strict=True):
        assert own.dtype == other.dtype
        assert np.array_equal(own, other)


def test_pairs_are_left_out(rng):
    scene = two_sheets(rng, 3)
    every = izo_ref.find_impacts(scene)
    scene.excluded = Pairs(every.nodes[::2], every.is_edge_edge[::2])
    found = izo_ref.find_impacts(scene, device="cuda")
    assert len(found.toi) == len(every.toi) // 2
    assert np.array_equal(found.nodes, izo_ref.find_impacts(scene).nodes)


def test_many_batches_are_as_one(rng, monkeypatch):
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

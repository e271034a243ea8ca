"""Starts that touch or cross: no status claims more than exact arithmetic grants, pair by pair."""

from collections import Counter

import numpy as np
import pytest

import izo_ref
from izo_ref import Status
from izo_ref.base.records import Exclusion, PairState
from tests.helpers.touching import random_scene
from tests.naive.simplices import simplices_meet
from tests.naive.start import edges_through_faces_soon, five_pairs, keys_of, pairs_that_meet

SCENES = 2000
THICKNESS = 0.01


def check_claims(scene, result):
    """Check each claim of a result against exact arithmetic; return what was claimed."""
    certificate = result.certificate
    excluded, touching = keys_of(certificate.excluded), keys_of(scene.touching)
    assert not excluded & touching
    assert (result.status is Status.FREE_EXCEPT_EXCLUDED) is (
        certificate.free and certificate.excluded is not None
    )
    start, end = scene.positions_t0, result.positions
    meeting = pairs_that_meet(start, end, scene.faces, touching) - excluded
    through = [
        five_pairs(*found) for found in edges_through_faces_soon(start, end, scene.faces, excluded)
    ]
    if certificate.free:
        assert not meeting
        assert not through
    else:
        named = keys_of(certificate.meeting)
        assert meeting <= named
        assert all(named & five for five in through)
        assert all(key in meeting or any(key in five for five in through) for key in named)
    return certificate


def check_ends(scene, result):
    """Check where the excluded pairs are at the end."""
    certificate, end = result.certificate, result.positions
    pairs = certificate.excluded
    for nodes, is_edge_edge, state in zip(
        pairs.nodes, pairs.is_edge_edge, certificate.excluded_ends, strict=True
    ):
        split = 2 if is_edge_edge else 1
        touch = simplices_meet(end[nodes[:split]], end[nodes[split:]])
        assert state == PairState.CROSSING or touch is bool(state == PairState.TOUCHING)


# Exact arithmetic takes seconds for a scene, so the quick run takes every seventh part.
PARTS = [pytest.param(k, marks=pytest.mark.slow if k % 7 else ()) for k in range(20)]


@pytest.mark.parametrize("part", PARTS)
def test_no_status_claims_more_than_exact_arithmetic_grants(part):
    seen = Counter()
    for seed in range(part, SCENES, 20):
        start, end, faces, pinned = random_scene(np.random.default_rng(seed))
        scene = izo_ref.Scene(start, end, faces, pinned=pinned, initial_intersections="ratchet")
        result = izo_ref.resolve(scene, THICKNESS)
        print(f"seed {seed}: {result.status.name}")
        certificate = check_claims(scene, result)
        if certificate.excluded is not None:
            check_ends(scene, result)
            seen.update(Exclusion(code).name for code in set(certificate.excluded.reasons.tolist()))
        seen[result.status.name] += 1
        seen["touching"] += scene.touching is not None
    print(dict(seen))
    assert min(seen[key] for key in ("FREE", "FREE_EXCEPT_EXCLUDED", "touching", "CROSSING")) > 5

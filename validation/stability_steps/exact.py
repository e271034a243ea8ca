"""What the second exact oracle says about a path, as far as a certificate speaks about it.

The oracle (`oracles/pairs.py`, `oracles/path.py`) compares all pairs by brute force and decides
them by python-flint. It shares no code with the certificate.
"""

from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import AnyInts, Positions
from izo_ref.base.records import PairState
from izo_ref.certificate.certify import PathCertificate
from izo_ref.scene import Scene
from validation.oracles import pairs, path

Key: TypeAlias = tuple[bool, frozenset[frozenset[int]]]  # a pair, whatever its order

# Reported times are early by the rounding of a proof; slow meetings of nearly coplanar pairs have
# the largest one.
EARLY = 1e-6


class Met(NamedTuple):
    """What meets on a path, by the oracle, without pairs that are left out."""

    first: float  # time of the first meeting; infinite if nothing meets
    keys: set[Key]


def key(nodes: Iterable[int], is_edge_edge: bool) -> Key:
    """Return a key of a pair that does not depend on the order of edges, ends and corners."""
    own = [int(v) for v in nodes]
    split = 2 if is_edge_edge else 1
    return bool(is_edge_edge), frozenset((frozenset(own[:split]), frozenset(own[split:])))


def keys_of(found: object) -> set[Key]:
    """Return the keys of `Pairs`, `ExcludedPairs` or `TouchingPairs`; none for None."""
    if found is None:
        return set()
    rows = zip(found.nodes, found.is_edge_edge, strict=True)  # type: ignore[attr-defined]
    return {key(nodes, kind) for nodes, kind in rows}


def all_meetings(
    start: Positions, end: Positions, faces: AnyInts, copies: AnyInts | None
) -> dict[Key, float]:
    """Return every pair that meets on a path, with the time at which it first does."""
    own = np.arange(len(start)) if copies is None else np.unique(copies)
    place = np.zeros(len(start), np.int32)
    place[own] = np.arange(len(own))
    if len(faces) == 0:
        return {}
    found = pairs.meeting_pairs(start[own], end[own], place[faces])
    times = {}
    for rows, row_times, kind in (
        (found.vertex_face, found.vertex_face_time, False),
        (found.edge_edge, found.edge_edge_time, True),
    ):
        times |= {key(own[r], kind): float(t) for r, t in zip(rows, row_times, strict=True)}
    return times


def judge_path(certificate: PathCertificate) -> list[str]:
    """Compare a certificate with the oracle: what meets, from when on, and what was left out.

    Args:
        certificate: The certificate, with its scene and its end.

    Returns:
        A line for each claim that is not true.
    """
    scene: Scene = certificate.scene  # type: ignore[assignment]
    start, end = scene.positions_t0, certificate.positions
    found = all_meetings(start, end, scene.faces, scene.copies)
    excluded, touching = keys_of(certificate.excluded), keys_of(scene.touching)
    left: dict[Key, float] = {}
    for own, time in found.items():
        if own in excluded:
            continue
        if own in touching:
            nodes = _nodes(own)
            if path.meets_after_start(own[0], start[nodes], end[nodes]):
                left[own] = 0.0
            continue
        left[own] = time
    said = keys_of(certificate.meeting)
    wrong = [f"second oracle: meets, not named: {_text(k)}" for k in set(left) - said]
    wrong += [f"second oracle: named, apart: {_text(k)}" for k in said - set(left) - touching]
    # the oracle tells whether a pair that touches at the start meets again, but not when
    first = min((time for own, time in left.items() if own not in touching), default=1.0)
    if certificate.time_free > first or (not touching and certificate.time_free < first - EARLY):
        wrong.append(f"second oracle: time_free {certificate.time_free!r}, first meeting {first!r}")
    if certificate.free and scene.touching is not None:
        for nodes in scene.touching.edge_faces:
            if path.goes_through_after_start(start[nodes], end[nodes]):
                wrong.append(f"second oracle: edge goes through its face: {nodes.tolist()}")
    return wrong[:3] + _judge_excluded(certificate, found)


def _judge_excluded(certificate: PathCertificate, found: dict[Key, float]) -> list[str]:
    """Judge where excluded pairs are said to be at the end, and that prescribed pairs meet."""
    own, scene = certificate.excluded, certificate.scene
    if own is None:
        return []
    wrong = []
    for nodes, kind, reason, state in zip(*own, certificate.excluded_ends, strict=True):
        at_end = certificate.positions[nodes]
        touches = path.meets(bool(kind), at_end, at_end)
        if (touches and state == PairState.APART) or (not touches and state == PairState.TOUCHING):
            wrong.append(f"second oracle: excluded_ends: {nodes.tolist()} is not {state}")
        if reason == 2 and key(nodes, kind) not in found:
            # a pair that crosses at the start between pinned vertices may never touch
            start = scene.positions_t0[nodes]
            if not scene.pinned[nodes].all() or path.meets(bool(kind), start, at_end):
                wrong.append(f"second oracle: prescribed pair {nodes.tolist()} does not meet")
    return wrong[:3]


def _nodes(own: Key) -> list[int]:
    """Return the nodes of a key in the order that the oracle takes."""
    sides = sorted(own[1], key=lambda side: (len(side), sorted(side)))
    return [v for side in sides for v in sorted(side)]


def _text(own: Key) -> str:
    return f"{'edge-edge' if own[0] else 'vertex-face'} {_nodes(own)}"

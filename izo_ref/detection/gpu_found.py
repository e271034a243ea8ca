"""What a detection on a GPU found, and what the CPU decides of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Indices, Positions
from izo_ref.base.records import Impacts, PairCounts
from izo_ref.detection.cpu import frames
from izo_ref.detection.doubts import settle_doubts
from izo_ref.detection.serial import found_counts as places


class Found(NamedTuple):
    """What a detection found.

    Attributes:
        impacts: `Impacts` on the GPU.
        n_blocked: Number of impacts that were left out because they are between pinned points.
        time_free: The least time of the impacts; 1 if there is none.
        in_place: Whether the impacts are where the launches wrote them; else the CPU took part.
    """

    impacts: Impacts
    n_blocked: int
    time_free: float
    in_place: bool


def pair_counts(counts: Indices) -> PairCounts:
    """Return the counts of a detection as the CPU has them.

    Args:
        counts: (N_COUNTS,) i8, of `serial/found_counts.py`.
    """
    own, n_vertex_face = PairCounts(int(counts[places.MOVED])), counts[places.VERTEX_FACE_PAIRS]
    own.add("vertex_face", n_vertex_face, counts[places.STEPS], counts[places.MOST_STEPS])
    n_settled = counts[places.PAIRS] - counts[places.OPEN]
    own.add("edge_edge", counts[places.PAIRS] - n_vertex_face, 0, 0, n_settled)
    return own


def settled(positions_t0: Positions, positions_t1: Positions, contacts: Impacts) -> Impacts:
    """Return the impacts among contacts of which some begin at t = 0, decided exactly.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start of the path.
        positions_t1: (n_vertices, 3) f8 [m], its end.
        contacts: The contacts with their frames, on the CPU; they are changed.
    """
    began = contacts.toi == 0.0
    meets = settle_doubts(positions_t0, positions_t1, *contacts[:3], contacts.normals)
    at = np.flatnonzero(began & meets)
    part = contacts.take(at)
    frame = np.empty((len(at), 4)), np.empty((len(at), 3))
    pairs = part.nodes, part.is_edge_edge, part.toi, part.normals
    frames.compute_impact_frames(positions_t0, positions_t1, *pairs, *frame)
    contacts.weights[at], contacts.normals[at] = frame
    return contacts.take(meets)

"""Judge weights and normals of a dump, each at the times of the dump.

The tolerance of a normal is the rounding of a coordinate over the size of the features.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices
from izo_ref.porting.dumped.arrays import Rows
from izo_ref.porting.dumped.paths import ROOM, Frame, Path, drift, length, matches, name_of
from izo_ref.porting.dumped.report import Problem

UNSURE = 0.1  # beyond this tolerance a normal is judged by its side alone


def judge_weights(path: Path, rows: Rows) -> Problem | None:
    """Judge weights: signs, sums, and whether they give the closest points at the port's times."""
    assert rows.weights is not None
    own, places = matches(path, rows)
    weights, kinds = rows.weights[own], rows.is_edge_edge[own]
    frame, slack = Frame(path, rows, own), ROOM * path.eps
    first = np.where(kinds, 2, 1)[:, None] > np.arange(4)
    wrong = {
        "are no numbers": ~np.isfinite(weights).all(axis=1),
        "do not sum to 1 on the first side and to -1 on the second": ~(
            (np.abs(np.where(first, weights, 0.0).sum(axis=1) - 1.0) <= slack)
            & (np.abs(np.where(first, 0.0, weights).sum(axis=1) + 1.0) <= slack)
        ),
        "are not positive on the first side and negative on the second": (
            np.where(first, weights, -weights) < -slack
        ).any(axis=1),
        "do not give the closest points": ~(
            length(frame.between(weights))
            <= length(frame.between(frame.weights)) + frame.error + drift(path, places, frame.toi)
        ),
    }
    return _first_wrong("weights", rows, own, wrong, frame.weights, weights)


def judge_normals(path: Path, rows: Rows) -> Problem | None:
    """Judge normals: unit vectors, on the right side, and orthogonal to the face or both edges."""
    assert rows.normals is not None
    own, places = matches(path, rows)
    normals, frame = rows.normals[own], Frame(path, rows, own)
    weights = frame.weights if rows.weights is None else rows.weights[own]
    gap = np.einsum("jx,jx->j", normals, frame.between(weights, at_start=True))
    angle = (frame.error + drift(path, places, frame.toi)) / frame.height
    unsure = frame.uncertain | ~(angle < UNSURE)
    off = length(normals - frame.normals)
    wrong = {
        "is no unit vector": ~(np.abs(length(normals) - 1.0) <= ROOM * path.eps),
        "points to the side on which the pair must not be: the gap at t = 0 is negative": (
            gap < -frame.error - drift(path, places, frame.toi)
        ),
        "is not that of the face or of both edges": ~unsure & ~(off <= angle + ROOM * path.eps),
    }
    return _first_wrong("normal", rows, own, wrong, frame.normals, normals)


def _first_wrong(
    what: str,
    rows: Rows,
    own: Indices,
    wrong: dict[str, Flags],
    expected: Floats,
    got: Floats,
) -> Problem | None:
    """Return the first row with something wrong.

    Args:
        what: What is judged, such as `weights`.
        rows: The impacts of the dump.
        own: (k,) i8, the rows that are judged.
        wrong: For each thing that can be wrong, in which of the judged rows it is, (k,) b1.
        expected: (k, .) f8, what the reference has.
        got: (k, .) f8, what the dump has.
    """
    for sentence, off in wrong.items():
        if not off.any():
            continue
        i = int(np.flatnonzero(off)[0])
        nodes = rows.nodes[own[i]]
        pair = name_of(nodes, bool(rows.is_edge_edge[own[i]]))
        texts = str(expected[i].tolist()), str(got[i].tolist())
        whole = f"the {what} of {pair} {sentence}"
        return Problem(whole, int(own[i]), tuple(nodes.tolist()), *texts, int(off.sum()))
    return None

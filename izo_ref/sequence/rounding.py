"""Round the end of a path to the floats of a file, and certify the rounded path.

What a file holds is what has to be certified. Rounding to float32 moves a vertex by up to 6e-8
(2^-24) of its coordinates, which is far less than the thickness in most scenes. Where it makes
contact all the same, vertices give way: first by a few of these floats, in the direction in which
the impacts push them. Where that does not help, they stay at the start of the step, which is such a
float already.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Flags, Indices, Nodes, Positions
from izo_ref.certificate.certify import PathCertificate, certify_path
from izo_ref.loop.resolve import Result
from izo_ref.scene import Scene
from izo_ref.zones.grouping import Zones
from izo_ref.zones.serial.grouping import group_by_zone

PRECISIONS = ("float64", "float32")
# Floats of a precision, or what a file holds where positions are transformed when they are written.
Precision: TypeAlias = str | Callable[[Positions], Positions]
# How many floats farther a vertex goes, one try after the other. Rounding moves each vertex by at
# most half a float in a coordinate, and so the gap of a pair by at most one along each axis. The
# push may be oblique to the normal of the pair.
TRIES = (1, 2, 4, 8)


class RoundedEnd(NamedTuple):
    """The end of a path in the floats of a file.

    Attributes:
        positions: (n, 3) f8 [m]; each number is a float of the file.
        certificate: Certificate of the path to them.
        nudged: (k,) i8, vertices that ended a few floats farther than the nearest ones.
        held: (k,) i8, vertices that stay at the start, because nothing else was free.
    """

    positions: Positions
    certificate: PathCertificate
    nudged: Indices
    held: Indices


def rounded(positions: Positions, precision: Precision) -> Positions:
    """Return the nearest positions that a file can hold, as float64.

    Args:
        positions: (n, 3) f8 [m].
        precision: One of PRECISIONS, or a function that returns these positions.
    """
    if callable(precision):
        return precision(positions)
    return positions if precision == "float64" else positions.astype(precision).astype(np.float64)


def round_end(
    scene: Scene, result: Result, precision: Precision, device: str = "cpu"
) -> RoundedEnd:
    """Round the end of a path, and let vertices give way until the rounded path is free.

    Args:
        scene: The step. The positions of its start, and the proposed ones of pinned vertices, are
            floats of the precision.
        result: The result of `resolve`.
        precision: As for `rounded`.
        device: Where certificates run, as for `certify_path`.

    Returns:
        The end. If the path of the result is free, that of the end is free, too, unless pinned
        vertices meet what stays at the start.
    """
    nothing = np.empty(0, np.int64)
    ends = rounded(result.positions, precision)
    if np.array_equal(ends, result.positions) or not result.certificate.free:
        return RoundedEnd(result.positions, result.certificate, nothing, nothing)
    rules = result.options.rules
    nearest, certificate = ends, certify_path(scene, ends, rules, device)
    push = result.positions - scene.positions_t1
    for count in TRIES:
        if certificate.free:
            break
        ends = _nudged(scene, ends, push, certificate.meeting.nodes, count, precision)
        certificate = certify_path(scene, ends, rules, device)
    held = np.zeros(len(ends), bool)
    met = [result.impacts.nodes]
    while not certificate.free:
        met.append(certificate.meeting.nodes)
        more = _in_trouble(np.concatenate(met), scene.pinned, certificate.meeting.nodes) & ~held
        if not more.any():
            break
        held |= more
        ends = _of_copies(scene, np.where(held[:, None], scene.positions_t0, ends))
        certificate = certify_path(scene, ends, rules, device)
    nudged = (ends != nearest).any(axis=1) & ~held
    return RoundedEnd(ends, certificate, np.flatnonzero(nudged), np.flatnonzero(held))


def _nudged(
    scene: Scene, ends: Positions, push: Positions, nodes: Nodes, count: int, precision: Precision
) -> Positions:
    """Move the unpinned vertices of pairs by some floats along the push."""
    moves = np.zeros(len(ends), bool)
    moves[nodes] = True
    moves &= ~scene.pinned
    # the coordinates that count: those of at least a third of the largest one
    along = np.sign(push) * (np.abs(push) >= np.abs(push).max(axis=1, keepdims=True) / 3.0)
    dtype = "float32" if callable(precision) else precision
    gap = np.spacing(np.abs(ends).astype(dtype)).astype(np.float64)
    return _of_copies(scene, rounded(ends + moves[:, None] * count * along * gap, precision))


def _in_trouble(nodes: Nodes, pinned: Flags, meeting: Nodes) -> Flags:
    """Return the unpinned vertices of the zones of some pairs in which a pair meets, (n,) b1."""
    zones, trouble = Zones(*group_by_zone(nodes, pinned)), np.zeros(len(pinned), bool)
    meets = np.zeros(len(pinned), bool)
    meets[meeting] = True
    for zone in range(len(zones)):
        vertices = zones.vertices_of(zone)
        trouble[vertices] = meets[vertices].any()
    return trouble


def _of_copies(scene: Scene, positions: Positions) -> Positions:
    return positions if scene.copies is None else positions[scene.copies]

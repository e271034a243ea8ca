"""Sort the intersections of a start: pairs to leave out, and pairs that touch on a known side.

* An edge goes through a face if the two meet in one point that is inside both. The five
  vertex-face and edge-edge pairs of the two are left out, because each of them may start on the
  wrong side. The same holds for an edge and a face that touch by a pair at which the surfaces go
  through each other.
* A pair that touches is left out if the mesh tells no side (`sides.py`).
* Every other pair that touches is kept, with the normal of its side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Codes, Faces, Flags, Ints, Normals, Positions, Weights
from izo_ref.base.records import ExcludedPairs, Exclusion, Pairs, TouchingPairs
from izo_ref.detection.intersections import Intersections, pairs_of_crossings, unique_pairs
from izo_ref.detection.sides import Side, Sides


class SortedStart(NamedTuple):
    """What becomes of the pairs that intersect at the start of a step.

    Attributes:
        excluded: Pairs to leave out, sorted by kind and nodes; None if there are none.
        touching: Pairs that touch, where the mesh tells a side; None if there are none.
    """

    excluded: ExcludedPairs | None
    touching: TouchingPairs | None


class Told(NamedTuple):
    """What the mesh tells about each pair that touches.

    Attributes:
        sides: (n,) i1, values of `Side`.
        weights: (n, 4) f8, of the point of contact.
        normals: (n, 3) f8, zero where no side is told.
    """

    sides: Codes
    weights: Weights
    normals: Normals


def sort_start(
    positions: Positions, faces: Faces, found: Intersections, prescribed: Flags | None = None
) -> SortedStart:
    """Sort the intersections of a start by what becomes of them.

    Args:
        positions: (n_vertices, 3) f8 [m].
        faces: (n_faces, 3) i4.
        found: The intersections of the mesh at these positions.
        prescribed: (n_vertices,) b1, vertices whose pairs with each other are left out in any case;
            None if there are none.
    """
    told = tell_sides(positions, faces, found.touching)
    fives = pairs_of_crossings(found.crossing_edges, found.crossed_faces)
    touching, through, lost = contacts_through(found, told)
    kept = ~lost & (told.sides == Side.TOLD)
    if prescribed is not None:
        kept &= ~prescribed[found.touching.nodes].all(axis=1)
    crossings = unique_pairs([_rows(fives, np.tile(through, 5)), _rows(found.touching, lost)])
    untold = _rows(found.touching, ~lost & ~kept)
    excluded = _excluded(crossings, untold)
    if excluded is not None and prescribed is not None:
        excluded.reasons[prescribed[excluded.nodes].all(axis=1)] = Exclusion.PRESCRIBED
    return SortedStart(
        excluded,
        _kept(found, told, kept, touching) if kept.any() else None,
    )


def contacts_through(found: Intersections, told: Told) -> tuple[Ints, Flags, Flags]:
    """Return which contacts of edges and faces go through, and which touching pairs belong to them.

    Args:
        found: The intersections of a mesh.
        told: What the mesh tells about the pairs of them that touch.

    Returns:
        (n, 5) i4, which pairs of each edge and the face that it meets touch, as
        `touching_pairs_of_contacts` returns them; (n,) b1, whether the two go through each other;
        and (m,) b1, whether each pair that touches is one of theirs, or goes through itself.
    """
    touching = found.touching_pairs_of_contacts()
    crossing = np.append(told.sides == Side.CROSSING, False)  # the last for an index of -1
    through = (touching < 0).all(axis=1) | crossing[touching].any(axis=1)
    lost = np.zeros(len(crossing), bool)
    lost[touching[through]] = True
    return touching, np.asarray(through), lost[:-1] | crossing[:-1]


def tell_sides(positions: Positions, faces: Faces, touching: Pairs) -> Told:
    """Return what the mesh tells about each pair that touches.

    Args:
        positions: (n_vertices, 3) f8 [m].
        faces: (n_faces, 3) i4.
        touching: Pairs that touch.
    """
    n = len(touching.nodes)
    told = Told(np.full(n, Side.UNTOLD, np.int8), np.zeros((n, 4)), np.zeros((n, 3)))
    sides = Sides(positions, faces, touching.nodes)
    for i, is_edge_edge in enumerate(touching.is_edge_edge.tolist()):
        contact = sides.contact(is_edge_edge, touching.nodes[i].tolist())
        if contact is None:
            continue
        side, normal = sides.side(contact)
        told.sides[i], told.normals[i] = side, normal
        told.weights[i] = [float(weight) for weight in contact.weights]
    return told


def _kept(found: Intersections, told: Told, kept: Flags, touching: Ints) -> TouchingPairs:
    """Return the touching pairs that are kept, and the edges and faces that touch by them alone.

    An edge and a face that also touch by a pair that is left out may go through each other there.
    """
    number = np.where(kept, np.cumsum(kept) - 1, -1)  # of each touching pair among the kept ones
    own = np.append(number, -1)[touching]
    rows = np.flatnonzero((own >= 0).any(axis=1) & ((own >= 0) == (touching >= 0)).all(axis=1))
    contact, column = np.nonzero(own[rows] >= 0)
    edge_faces = np.hstack((found.crossing_edges, found.crossed_faces))
    return TouchingPairs(
        *_rows(found.touching, kept),
        told.weights[kept],
        told.normals[kept],
        edge_faces[rows],
        contact.astype(np.int32),
        own[rows][contact, column].astype(np.int32),
    )


def _excluded(crossing: Pairs, untold: Pairs) -> ExcludedPairs | None:
    """Return the pairs to leave out, sorted by kind and nodes."""
    counts = len(crossing.nodes), len(untold.nodes)
    if sum(counts) == 0:
        return None
    reasons = np.repeat([Exclusion.CROSSING, Exclusion.TOUCHING], counts).astype(np.int8)
    nodes = np.concatenate((crossing.nodes, untold.nodes))
    kinds = np.concatenate((crossing.is_edge_edge, untold.is_edge_edge))
    order = np.lexsort((*nodes.T[::-1], kinds))
    return ExcludedPairs(nodes[order], kinds[order], reasons[order])


def _rows(pairs: Pairs, mask: Flags) -> Pairs:
    return Pairs(pairs.nodes[mask], pairs.is_edge_edge[mask])

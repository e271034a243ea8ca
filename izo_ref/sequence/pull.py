"""Pull what is tangled apart: displace the proposed positions of a frame, so that contours shrink.

**The displacement.** Each crossing has a direction, in which its edge should move relative to its
face (`contours.py`). The two share it by their inverse masses, as two bodies that push each other
do; pinned vertices take no part. A vertex moves by the mean over its crossings, weighted by how
close they are, times the bound. So it never moves farther than the bound. `RINGS` rings of vertices
around the contour follow, each ring less, so that edges are not stretched from one vertex to the
next one.

**What was reached stays.** A frame is proposed without knowing what was pulled before. So a vertex
at a contour keeps the offset from its proposed position that it had at the end of the last frame,
and the displacement is added to that. Farther out, less of the offset is kept; away from contours,
nothing: there, contacts alone keep the vertex from its proposed position.

**No crossing is added.** All pairs that do not cross at the start of a step are protected in it.
So a crossing that is new at its end shares a vertex-face or edge-edge pair with a crossing at its
start: an edge that leaves a face enters the next one through their common side. A contour can move,
then, but none arises where there was none. A contour that moves has now more crossings, now fewer,
because edges and faces are of finite size. So crossings are counted exactly, and a frame may end
only where there are no more of them than at its start, and no more pairs in them:

1. The frame is resolved with the whole displacement. If crossings were added, this is discarded.
2. The frame is resolved again while contours stay: they move with the mean motion of the animation
   around them, as a whole. From there, the displacement is gone in `PARTS` parts, each with the
   directions of the contours as they are then. The frame ends behind the part with the fewest
   crossings, the last one if there are several.
3. If crossings were added although contours stay, and no pinned vertex moves, everything stays
   where the frame started. So only the motion of pinned vertices can add a crossing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Edges, Flags, Floats, Indices, Positions
from izo_ref.base.sizes import path_in_range
from izo_ref.detection.intersections import Intersections, find_intersections
from izo_ref.scene import Scene
from izo_ref.sequence.contours import ContourFinder, Contours

RINGS = 4  # of vertices around a contour that follow it
# In so many parts a displacement is gone that would add crossings as a whole. Each takes a solution
# of the step. A contour gets stuck less often in shorter parts, in which it passes few elements.
PARTS = 6


class Tangle(NamedTuple):
    """What is tangled at the end of a frame.

    Attributes:
        found: The intersections that have a vertex which is not pinned.
        crossings: Number of edges that meet a face.
        pairs: Number of pairs that cross or touch, which are left out in the next step.
    """

    found: Intersections
    crossings: int
    pairs: int

    def adds_to(self, other: Tangle) -> bool:
        """Return whether there are more crossings than in another tangle, or more pairs."""
        return self.crossings > other.crossings or self.pairs > other.pairs


class Pull:
    """How what is tangled in a mesh is pulled apart from frame to frame.

    Args:
        scene: A step of the mesh.
        bound: Largest displacement of a vertex in a frame [m].
        before: (n, 3) f8 [m], proposed positions of the frame at which the sequence starts.

    Attributes:
        bound: As passed in.
        before: (n, 3) f8 [m], proposed positions of the last frame.
        tangle: What is tangled at its end.
    """

    def __init__(self, scene: Scene, bound: float, before: Positions) -> None:
        """Find what is tangled at the start of a step."""
        self._scene, self.bound, self.before = scene, bound, before
        self._finder = ContourFinder(scene.edges, scene.faces, len(scene.pinned))
        self.tangle: Tangle = self.tangle_at(scene.positions_t0)

    def tangle_at(self, positions: Positions) -> Tangle:
        """Return what is tangled at rest at some positions, (n, 3) f8 [m], exactly."""
        scene = self._scene
        ends = path_in_range(scene, positions)[1]
        found = find_intersections(ends, scene.edges, scene.faces, scene.tree_orders)
        found = found.unprescribed(scene.pinned)
        return Tangle(found, len(found.crossing_edges), len(found.pairs().nodes))

    def finish(self, before: Positions, tangle: Tangle) -> None:
        """Go on to the next frame.

        Args:
            before: (n, 3) f8 [m], the proposed positions of this one, without a displacement; or
                where it ended, if that is not near them, because it is blocked.
            tangle: What is tangled at its end.
        """
        self.before, self.tangle = before, tangle

    def displaced(
        self, start: Positions, tangle: Tangle, before: Positions, target: Positions, share: float
    ) -> Positions:
        """Return displaced proposed positions, (n, 3) f8 [m].

        Args:
            start: (n, 3) f8 [m], where the step starts.
            tangle: What is tangled there.
            before: (n, 3) f8 [m], what was proposed for these positions.
            target: (n, 3) f8 [m], what is proposed for the end of the step.
            share: Share of the bound by which vertices are displaced.
        """
        rings = self._around(start, tangle)
        kept = rings.share[:, None] * (start - before)
        return self._as_scene(target, target + kept + share * self.bound * rings.moves)

    def staying(self, start: Positions, target: Positions) -> Positions:
        """Return proposed positions at which contours stay, (n, 3) f8 [m].

        Args:
            start: (n, 3) f8 [m], where the step starts.
            target: (n, 3) f8 [m], what is proposed for its end.
        """
        owner, pinned = self._around(start, self.tangle).owner, self._scene.pinned
        near, n = owner >= 0, int(owner.max(initial=-1)) + 1
        motion = (target - self.before)[near]
        heavy = np.where(pinned, float(len(pinned)) ** 2, 1.0)[near]  # pinned ones lead
        sums = [np.bincount(owner[near], heavy * motion[:, k], n) for k in range(3)]
        mean = np.column_stack(sums) / np.maximum(np.bincount(owner[near], heavy, n), 1.0)[:, None]
        return self._as_scene(target, np.where(near[:, None], start + mean[owner], target))

    def pinned_move(self, start: Positions, target: Positions) -> bool:
        """Return whether a pinned vertex moves between two positions, (n, 3) f8 [m] each."""
        return bool((start != target)[self._scene.pinned].any())

    def _around(self, start: Positions, tangle: Tangle) -> _Rings:
        """Return the displacements around the contours at some positions."""
        scene, found = self._scene, tangle.found
        ends = path_in_range(scene, start)[1]
        contours = self._finder.find(ends, found.crossing_edges, found.crossed_faces)
        moves, at = _displacements(contours, scene.masses, scene.pinned)
        return _Rings(scene.edges, moves, at, _owners(contours, len(at)))

    def _as_scene(self, target: Positions, positions: Positions) -> Positions:
        """Return positions in which pinned vertices follow their path, and copies their vertex."""
        scene = self._scene
        positions = np.where(scene.pinned[:, None], target, positions)
        return positions if scene.copies is None else positions[scene.copies]


class _Rings:
    """A field around contours, which fades from ring to ring.

    Attributes:
        moves: (n, 3) f8, displacements over the bound; each no longer than 1.
        share: (n,) f8, 1 at a contour, 0 outside of the rings.
        owner: (n,) i8, the contour that the vertex follows; -1 outside of the rings.
    """

    def __init__(self, edges: Edges, moves: Floats, at: Flags, owner: Indices) -> None:
        """Let the vertices of each ring follow their neighbours in the ring before.

        Args:
            edges: (k, 2) i4.
            moves: (n, 3) f8, displacements of the vertices at contours.
            at: (n,) b1, which vertices these are.
            owner: (n,) i8, their contours; -1 for all other vertices.
        """
        self.moves, self.share, self.owner = moves.copy(), at.astype(np.float64), owner.copy()
        inside, n = at.copy(), len(at)
        ends = np.concatenate((edges, edges[:, ::-1]))
        for ring in range(1, RINGS + 1):
            out = inside[ends[:, 0]] & ~inside[ends[:, 1]]
            source, to = ends[out].T
            count = np.bincount(to, minlength=n)
            fresh = count > 0
            sums = [np.bincount(to, self.moves[source, k], n) for k in range(3)]
            # the mean of the ring before has faded already, by a share that is divided out
            faded = 1.0 - ring / (RINGS + 1.0)
            by = faded / (1.0 - (ring - 1.0) / (RINGS + 1.0))
            self.moves[fresh] = by * np.column_stack(sums)[fresh] / count[fresh, None]
            self.share[fresh] = faded
            nearest = np.full(n, len(self.owner))
            np.minimum.at(nearest, to, self.owner[source])
            self.owner[fresh] = nearest[fresh]
            inside |= fresh


def _displacements(contours: Contours, masses: Floats, pinned: Flags) -> tuple[Floats, Flags]:
    """Return the displacement of each vertex over the bound, and which vertices are at contours."""
    n = len(masses)
    light = np.divide(1.0, masses, out=np.zeros(n), where=~pinned & (masses > 0.0))
    light /= max(light.max(initial=0.0), np.finfo(float).tiny)
    corners = np.hstack((contours.edges, contours.faces))
    weights = np.hstack((contours.edge_weights, contours.face_weights))
    give = weights**2 * light[corners]
    sides = np.column_stack((give[:, :2].sum(axis=1), give[:, 2:].sum(axis=1)))
    whole = sides.sum(axis=1, keepdims=True)
    share = np.divide(sides, whole, out=np.zeros_like(sides), where=whole > 0.0)
    signed = np.repeat(share * (1.0, -1.0), (2, 3), axis=1)
    rows, close = corners.ravel(), weights.ravel()
    total = np.bincount(rows, close, n)
    at = np.bincount(rows, minlength=n) > 0
    sums = [
        np.bincount(rows, close * (signed * contours.directions[:, k : k + 1]).ravel(), n)
        for k in range(3)
    ]
    moves = np.column_stack(sums)
    moves = np.divide(moves, total[:, None], out=np.zeros((n, 3)), where=total[:, None] > 0.0)
    moves[pinned] = 0.0
    return moves, at


def _owners(contours: Contours, n: int) -> Indices:
    """Return the lowest number of the contours at each vertex, (n,) i8; -1 where there is none."""
    owner = np.full(n, np.iinfo(np.int64).max)
    corners = np.hstack((contours.edges, contours.faces))
    np.minimum.at(owner, corners.ravel(), np.repeat(contours.contour, 5))
    return np.where(owner == np.iinfo(np.int64).max, -1, owner)

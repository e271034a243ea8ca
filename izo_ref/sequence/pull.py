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

**No crossing is added.** All pairs that do not cross at the start of a frame are protected in it.
So a crossing that is new at its end shares a vertex-face or edge-edge pair with a crossing at its
start: an edge that leaves a face enters the next one through their common side. A contour can move,
then, but none arises where there was none. Crossings are counted exactly at the end of a frame. If
there are more than at its start, or if more pairs are in them, the frame is resolved again: first
those contours stay that gained the most, then all of them. Contours that stay move with the mean
motion of the animation around them. If that does not help and no pinned vertex moves, everything
stays where the frame started, where the count is the same. So only the motion of pinned vertices
can add a crossing.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices, Positions
from izo_ref.base.sizes import path_in_range
from izo_ref.detection.intersections import Intersections, find_intersections
from izo_ref.scene import Scene
from izo_ref.sequence.contours import ContourFinder, Contours

RINGS = 4  # of vertices around a contour that follow it
# How often contours that gain crossings are pulled by another share of the bound, before they stay.
# Each takes a solution of the step.
DRAWS = 3


class Pull:
    """What is tangled in a mesh, and how it is pulled apart from frame to frame.

    Args:
        scene: A step of the mesh.
        bound: Largest displacement of a vertex in a frame [m].
        before: (n, 3) f8 [m], proposed positions of the frame at which the sequence starts.
    """

    def __init__(self, scene: Scene, bound: float, before: Positions) -> None:
        """Find what is tangled at the start of a step."""
        self.scene, self.bound, self.before = scene, bound, before
        self.finder = ContourFinder(scene.edges, scene.faces, scene.pinned)
        self.tangle = self.tangle_at(scene.positions_t0)

    def tangle_at(self, positions: Positions) -> Intersections:
        """Return the intersections at rest that have a vertex which is not pinned, exactly."""
        scene = self.scene
        ends = path_in_range(scene, positions)[1]
        found = find_intersections(ends, scene.edges, scene.faces, scene.tree_orders)
        return found.unprescribed(scene.pinned)

    def plan(self, number: int, start: Positions, target: Positions) -> Plan:
        """Return how a frame goes from its start to displaced proposed positions."""
        return Plan(self, number, start, target)

    def finish(self, target: Positions, tangle: Intersections, reached: float = 1.0) -> None:
        """Go on to the next frame.

        Args:
            target: (n, 3) f8 [m], the proposed positions of this one, without a displacement.
            tangle: What is tangled at its end.
            reached: Fraction of the way to its end that was gone; less than 1 if it is blocked.
        """
        gone = self.before + reached * (target - self.before)
        self.before, self.tangle = target if reached == 1.0 else gone, tangle


class Plan:
    """The displaced proposed positions of one frame, and what stays if they add a crossing.

    Attributes:
        proposed: (n, 3) f8 [m], where the frame is to end, at this try.
        stays: (n,) b1, vertices that are not pulled, because that would add a crossing.
        tangle: What is tangled at the end of the last try.
    """

    def __init__(self, pull: Pull, number: int, start: Positions, target: Positions) -> None:
        """Displace the proposed positions of the frame of a number."""
        scene, found = pull.scene, pull.tangle
        self._pull, self._start, self._target, self._number = pull, start, target, number
        self.tangle = found
        contours = pull.finder.find(start, found.crossing_edges, found.crossed_faces)
        fields = []
        for directions in (contours.directions, contours.means):
            moves, at = _displacements(contours, directions, scene.masses, scene.pinned)
            fields.append(_Rings(scene.edges, moves, at, _owners(contours, len(at))))
        self._near, self._fields = fields[0], [field.moves for field in fields]
        self._kept = self._near.share[:, None] * (start - pull.before)
        self._tries = 0
        self._factors = np.ones(int(self._near.owner.max(initial=-1)) + 1)
        self.stays = np.zeros(len(start), bool)
        self.proposed = self._displaced()

    def accepts(self, positions: Positions) -> bool:
        """Return whether the end of a try adds no crossing, or is the last one.

        If it does, `proposed` are the positions of the next try.

        Args:
            positions: (n, 3) f8 [m], where the frame ends.
        """
        before, after = self._pull.tangle, self._pull.tangle_at(positions)
        self.tangle = after
        if _count(after) <= _count(before) and _count_pairs(after) <= _count_pairs(before):
            return True
        self._tries += 1
        if self._tries <= DRAWS:
            rng = np.random.default_rng((self._number, self._tries))
            gained = self._gained(before, after)
            self._factors[gained] = rng.uniform(0.0, 1.0, len(gained))
        elif self._tries == DRAWS + 1:
            self._factors[self._gained(before, after)] = 0.0
        elif self._tries == DRAWS + 2:
            self._factors[:] = 0.0
        else:
            pinned = self._pull.scene.pinned
            if self.stays.all() or (self._target != self._start)[pinned].any():
                return True
            self.stays[:] = True
            self.proposed = self._start
            return False
        self.proposed = self._displaced()
        return False

    def _gained(self, before: Intersections, after: Intersections) -> Indices:
        """Return the contours that gained most, without which the others gain nothing together."""
        old, new = _keys(before), _keys(after)
        changed = sorted(new ^ old)
        if not changed:
            return np.unique(self._near.owner[self._near.owner >= 0])
        owner = self._near.owner[np.array(changed)].max(axis=1)
        signs = np.array([1 if key in new else -1 for key in changed])
        known = owner >= 0
        gains = np.bincount(owner[known], signs[known], len(self._factors))
        order = np.argsort(-gains, kind="stable")
        most = max(_count(after) - _count(before), 1)
        enough = int(np.searchsorted(np.cumsum(gains[order]), most)) + 1
        return order[:enough][gains[order[:enough]] > 0]

    def _displaced(self) -> Positions:
        """Return the displaced proposed positions; contours whose factor is 0 stay."""
        owner, field = self._near.owner, self._fields[self._tries % 2]
        factor = np.where(owner >= 0, self._factors[owner], 0.0)
        moves = self._pull.bound * factor[:, None] * field
        self.stays = (owner >= 0) & (factor == 0.0)
        own = self._target + self._kept + moves
        return self._as_scene(np.where(self.stays[:, None], self._stay(), own))

    def _stay(self) -> Positions:
        """Return where the vertices around contours are if they move with the animation alone."""
        owner, pinned = self._near.owner, self._pull.scene.pinned
        near, n = owner >= 0, len(self._factors)
        motion = (self._target - self._pull.before)[near]
        heavy = np.where(pinned, float(len(pinned)) ** 2, 1.0)[near]  # pinned ones lead
        sums = [np.bincount(owner[near], heavy * motion[:, k], n) for k in range(3)]
        whole = np.maximum(np.bincount(owner[near], heavy, n), 1.0)
        return self._start + (np.column_stack(sums) / whole[:, None])[owner]

    def _as_scene(self, positions: Positions) -> Positions:
        """Return positions in which pinned vertices follow their path, and copies their vertex."""
        scene = self._pull.scene
        positions = np.where(scene.pinned[:, None], self._target, positions)
        return positions if scene.copies is None else positions[scene.copies]


class _Rings:
    """A field around contours, which fades from ring to ring.

    Attributes:
        moves: (n, 3) f8, displacements over the bound; each no longer than 1.
        share: (n,) f8, 1 at a contour, 0 outside of the rings.
        owner: (n,) i8, the contour that the vertex follows; -1 outside of the rings.
    """

    def __init__(self, edges: Indices, moves: Floats, at: Flags, owner: Indices) -> None:
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


def _displacements(
    contours: Contours, directions: Floats, masses: Floats, pinned: Flags
) -> tuple[Floats, Flags]:
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
        np.bincount(rows, close * (signed * directions[:, k : k + 1]).ravel(), n) for k in range(3)
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


def _keys(found: Intersections) -> set[tuple[int, ...]]:
    """Return a key for each crossing: the ends of the edge, and the corners of the face."""
    rows = np.hstack((found.crossing_edges, np.sort(found.crossed_faces, axis=1)))
    return set(map(tuple, rows.tolist()))


def _count(found: Intersections) -> int:
    return len(found.crossing_edges)


def _count_pairs(found: Intersections) -> int:
    return len(found.pairs().nodes)

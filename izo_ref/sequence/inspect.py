"""Inspect a sequence of frames: what crosses in each of them, since when, and how deep."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Flags, Floats, Indices, Nodes, Positions
from izo_ref.base.devices import copy_to_cpu, detach
from izo_ref.base.errors import IzoError, ShapeError
from izo_ref.base.records import ExcludedPairs, Exclusion
from izo_ref.base.serial.components import impact_components
from izo_ref.base.sizes import near_mesh, scene_in_range
from izo_ref.base.units import times_power
from izo_ref.detection import weld as welding
from izo_ref.detection.detector import Detector
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.trees import tree_orders
from izo_ref.scene import KEPT_STEPS
from izo_ref.sequence.crossings import CrossingMesh, Crossings, depths_of, widths_of
from izo_ref.sequence.inspection import ORDER, Inspection, Verdict
from izo_ref.sequence.part_pairs import PartPairs, Rows


def inspect_sequence(
    frames: Iterable[Any],
    faces: Any,
    pinned: Any = None,
    parts: Any = None,
    *,
    first: int = 0,
    weld: float | None = None,
) -> Iterator[Inspection]:
    """Say of each frame what crosses and what touches in it, and what meets on the way to it.

    Crossings are exact, as those at the start of a `Scene`. The way between two frames is straight;
    all pairs that meet on it are found, as by `find_impacts`. Memory does not grow with the number
    of frames, since each is taken when it is asked for.

    Args:
        frames: The frames, (n, 3) [m] each.
        faces: (m, 3), as for `Scene`.
        pinned: (n,) bool, True for vertices that move as they are; none if None.
        parts: (n,) integers, the part that each vertex is in, from 0 on; one part if None.
        first: Number of the first frame.
        weld: How far apart vertices may be in the first frame that are one vertex [m]; None if
            there are none; as for `Scene`. Later they may be as far apart.

    Yields:
        An `Inspection` for each frame.

    Raises:
        ShapeError: There is no frame, or an array has another shape; the message names the frame.
        IzoError: As `Scene` does; the message names the frame.
    """
    run, empty = _Run(faces, pinned, parts, checks.weld(weld)), True
    for number, frame in enumerate(frames, first):
        try:
            yield run.inspect(number, frame)
        except IzoError as error:
            error.args = (f"frame {number}: {error.args[0]}", *error.args[1:])
            raise
        empty = False
    if empty:
        raise ShapeError("frames: expected at least one frame, found none")


class _Way:
    """The straight way between two frames, with the arrays that `scene_in_range` reads."""

    def __init__(self, start: Positions, end: Positions, mesh: CrossingMesh) -> None:
        self.positions_t0, self.positions_t1 = start, end
        self.edges, self.faces = mesh.edges, mesh.faces
        self.pinned, self.masses = np.zeros(len(start), bool), np.ones(len(start))


class _Found(NamedTuple):
    """What was found in a frame, and on the way to it.

    Attributes:
        crossings: What crosses in the frame.
        depths: (n,) f8, depth of each crossing [m].
        reaches: (n,) f8, how far what is behind each crossing has gone through [m].
        width: Diagonal of the box about the widest contour [m].
        move: Largest distance of a vertex from where it was [m].
        met: (k, 4) i4, the pairs that meet on the way.
        passing: (k,) b1, those of them that belong to no crossing.
    """

    crossings: Crossings
    depths: Floats
    reaches: Floats
    width: float
    move: float
    met: Nodes
    passing: Flags


class _Run:
    """A run through the frames of a sequence."""

    def __init__(self, faces: Any, pinned: Any, parts: Any, weld: float | None) -> None:
        self._passed, self._weld = (faces, pinned, parts), weld
        self._last: tuple[Positions, Crossings] | None = None
        self._kept: Indices = np.empty(0, np.int64)  # keys of what never came apart
        self._steps = 0  # since the elements were sorted for the trees

    def inspect(self, number: int, frame: Any) -> Inspection:
        """Inspect the next frame."""
        positions = self._take(frame)
        start, before = self._last or (positions, None)
        found = self._find(start, positions, before)
        crossings, keys = found.crossings, found.crossings.keys
        old = np.empty(0, np.int64) if before is None else before.keys
        self._kept = keys if before is None else np.intersect1d(self._kept, keys)
        self._last = positions, crossings
        kept = np.isin(keys, self._kept)
        rows = Rows(crossings, found.depths, found.reaches, kept, found.met[found.passing])
        pairs = self._pairs.of_frame(number, rows)
        return Inspection(
            number=number,
            verdict=max((pair.verdict for pair in pairs), key=ORDER.index, default=Verdict.CLEAN),
            crossings=len(keys),
            new=int(np.count_nonzero(~np.isin(keys, old))),
            gone=int(np.count_nonzero(~np.isin(old, keys))),
            kept=int(np.count_nonzero(kept)),
            touching=len(crossings.touching.nodes),
            met=len(found.met),
            passing=int(np.count_nonzero(found.passing)),
            contours=int(crossings.contours.max(initial=-1)) + 1,
            depth=float(found.depths.max(initial=0.0)),
            reach=float(found.reaches.max(initial=0.0)),
            width=found.width,
            move=found.move,
            pairs=pairs,
            edges=crossings.edges,
            faces=crossings.faces,
            contour_of=crossings.contours,
        )

    def _take(self, frame: Any) -> Positions:
        """Check the positions of a frame, and let welded vertices be at one place."""
        shape = (None if self._last is None else len(self._pinned), 3)
        positions = checks.floats("positions", copy_to_cpu("positions", detach(frame)), shape)
        if self._last is None:
            self._begin(positions)
        if self._copies is None:
            return positions
        leaders = welding.leaders_of(self._copies, self._pinned)
        welding.require_together("positions", positions, leaders, self._weld or 0.0)
        return positions[leaders]

    def _begin(self, positions: Positions) -> None:
        """Check the mesh, and weld its vertices."""
        n, (faces, pinned, parts) = len(positions), self._passed
        faces = checks.faces(copy_to_cpu("faces", faces), n)
        self._pinned: Flags = np.zeros(n, bool)
        if pinned is not None:
            self._pinned = checks.flags("pinned", copy_to_cpu("pinned", pinned), n)
        self._copies: Indices | None = None
        all_pinned = self._pinned
        if self._weld is not None:
            about = positions, positions, self._pinned
            self._copies = welding.find_copies(*about, self._weld)
        if self._copies is not None:
            faces = welding.welded_faces(faces, self._copies)
            all_pinned = welding.pinned_groups(self._pinned, self._copies)
        self._mesh = CrossingMesh(edges_of(faces), faces)
        self._pairs = PartPairs(_checked_parts(parts, n), all_pinned)

    def _find(self, start: Positions, end: Positions, before: Crossings | None) -> _Found:
        """Find what crosses at the end of a way, and what meets on it."""
        as_scene: Any = _Way(start, end, self._mesh)
        way, units = scene_in_range(as_scene)
        if self._steps % KEPT_STEPS == 0:
            orders = tree_orders(near_mesh(way), self._mesh.edges, self._mesh.faces)
            self._orders = welding.without_copies(orders, self._copies)
        self._steps += 1
        here = way.positions_t1
        crossings = self._mesh.crossings(here, self._orders)
        met, passing = np.empty((0, 4), np.int32), np.empty(0, bool)
        if before is not None:
            met = self._meeting(way, before)
            ends = [part.found.pairs().nodes for part in (before, crossings)]
            passing = _apart_from(met, np.concatenate(ends), len(end))
        numbers = [
            depths_of(here, crossings.edges, crossings.faces),
            self._mesh.reaches(here, crossings),
            widths_of(here, crossings.edges, crossings.faces, crossings.contours),
            np.linalg.norm(here - way.positions_t0, axis=1),
        ]
        depths, reaches, widths, moves = (times_power(part, -units.length) for part in numbers)
        width, move = (float(part.max(initial=0.0)) for part in (widths, moves))
        return _Found(crossings, depths, reaches, width, move, met, passing)

    def _meeting(self, way: Any, before: Crossings) -> Nodes:
        """Return the pairs that meet on a way, but for those that intersect at its start."""
        excluded = None
        if before.found.n_found:
            nodes, kinds = before.found.pairs()
            excluded = ExcludedPairs(nodes, kinds, np.full(len(nodes), Exclusion.CROSSING, np.int8))
        mesh = way.positions_t0, self._mesh.edges, self._mesh.faces
        return Detector(*mesh, excluded, orders=self._orders).find(way.positions_t1).nodes


def _checked_parts(parts: Any, n: int) -> Indices:
    """Return the part of each vertex, (n,) i8."""
    if parts is None:
        return np.zeros(n, np.int64)
    found = checks.indices("parts", np.reshape(parts, (-1, 1)), 1, 2**31 - 1)[:, 0]
    if len(found) != n:
        raise ShapeError(f"parts: expected a part of each of {n} vertices, found {len(found)}")
    return found.astype(np.int64)


def _apart_from(pairs: Nodes, others: Nodes, n_vertices: int) -> Flags:
    """Return which pairs are in no group with a vertex of others, (n,) b1.

    Pairs that share a vertex are in one group.
    """
    group = np.empty(len(pairs), np.int64)
    free, work = np.zeros(n_vertices, bool), np.empty(n_vertices, np.int64)
    impact_components(pairs, free, work, group)
    marked = np.zeros(n_vertices, bool)
    marked[others] = True
    near = np.isin(group, group[marked[pairs].any(axis=1)])
    return ~near

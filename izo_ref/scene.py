"""The scene: checks the arrays of a time step once, where they come in.

Everything below this module takes a scene as valid and does not check it again.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Edges, Faces, Flags, Indices, Masses, Positions
from izo_ref.base.devices import copy_to_cpu, detach, is_on_gpu
from izo_ref.base.errors import (
    DegenerateFaceError,
    InitialIntersectionError,
    MassError,
    OptionError,
    UncertifiedStartError,
)
from izo_ref.base.records import Components, Pairs, TreeOrders
from izo_ref.detection.components import MeshComponents
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.trees import tree_orders

SHOWN = 5  # intersections that the message of an error names
# Steps after which the elements are sorted anew for the trees. Sorting takes half as long as the
# queries of one detection. A sequence of 100 frames of cloth does not need it. Where 512 balls
# change their places, queries of trees in the old order take three times as long.
KEPT_STEPS = 32


class Scene:
    """One time step of a triangle mesh: where it starts and where it is proposed to end.

    Every array may be on a GPU (`__cuda_array_interface__` or DLPack). The CPU checks a copy. A
    step on a GPU reads the positions from the array that was passed in, so that array must not
    change before the step is resolved.

    The message of each error says what was expected and what was found, and names the first
    offenders.

    Args:
        positions_t0: (n, 3) [m], positions at the start of the step (Q0), free of intersections.
        positions_t1: (n, 3) [m], proposed positions at its end (Q1).
        faces: (m, 3), indices of vertices. A vertex in no face takes part as a point.
        masses: (n,) [kg], positive, or one number for all vertices; 1 for every vertex if None.
            The masses of pinned vertices are not used and may be anything.
        pinned: (n,) bool, True for vertices that follow their path exactly; if None, no vertex is
            pinned.
        initial_intersections: What to do if the mesh intersects itself at the start: `raise` an
            error, or `exclude` the pairs that intersect. Detection then ignores these pairs, and
            `excluded` lists them.

    Attributes:
        positions_t0: (n, 3) f8 [m], start of the step.
        positions_t1: (n, 3) f8 [m], proposed end of the step.
        faces: (m, 3) i4.
        edges: (k, 2) i4, each edge once, the lower vertex first, sorted.
        masses: (n,) f8 [kg]; 1 for pinned vertices whose mass was not positive and finite.
        pinned: (n,) b1.
        excluded: `Pairs` that detection ignores, or None.
        on_gpu: `{name: (array, order)}` for positions that came from a GPU. `order` is (n,) i8 and
            maps vertices to rows of the array; None means that vertex i is row i.
        tree_orders: Orders in which vertices, edges and faces enter trees, each (n,) i4.
        components: The connected components of the mesh.

    Raises:
        ShapeError: An array has the wrong shape or type.
        NonFiniteError: A position or a mass is NaN or infinite.
        IndexRangeError: A face has an index of no vertex.
        DegenerateFaceError: A face has the same vertex twice.
        MassError: A mass is zero or negative.
        OptionError: `initial_intersections` has another value.
        InitialIntersectionError: The mesh intersects itself at the start. The error holds the
            pairs.
        DeviceUnavailableError: An array is on a GPU that cannot be used.
    """

    def __init__(
        self,
        positions_t0: Any,
        positions_t1: Any,
        faces: Any,
        masses: Any = None,
        pinned: Any = None,
        *,
        initial_intersections: str = "raise",
    ) -> None:
        """Check and copy the arrays of a step; the class says what they are."""
        if initial_intersections not in ("raise", "exclude"):
            raise OptionError(
                "initial_intersections: expected 'raise' or 'exclude', "
                f"got {initial_intersections!r}"
            )
        self.on_gpu: dict[str, tuple[Any, Indices | None]] = {}
        self.positions_t0: Positions = self._take_positions("positions_t0", positions_t0)
        n = len(self.positions_t0)
        self.positions_t1: Positions = self._take_positions("positions_t1", positions_t1, n)
        self.faces: Faces = checks.indices("faces", copy_to_cpu("faces", faces), 3, n)
        _require_distinct_corners(self.faces)
        self.pinned: Flags = np.zeros(n, bool) if pinned is None else _take_pinned(pinned, n)
        self.masses: Masses = np.ones(n)
        self._has_no_mass: Flags = np.zeros(n, bool)
        if masses is not None:
            self._take_masses(masses)
        self.edges: Edges = edges_of(self.faces)
        self.components: Components = MeshComponents(n, self.faces)
        self._steps_kept = 0  # since the elements were sorted for the trees
        self.tree_orders: TreeOrders = tree_orders(self.positions_t0, self.edges, self.faces)
        self.excluded: Pairs | None = self._initial_intersections(
            initial_intersections == "exclude"
        )

    def after(
        self, result: Any, positions_t1: Any, masses: Any = None, pinned: Any = None
    ) -> Scene:
        """Return the next step of a simulation, which starts where the result of this one ends.

        The certificate of the result proves that its path is free up to its end, and the path
        began at a start without intersections. So no edge goes through a face at the end, and
        nothing touches: the next start needs no check. The mesh is the same, so its edges, its
        components and the orders of the trees are kept. `resolve` finds the same positions, bit for
        bit, as for a new `Scene` of the same arrays.

        The certificate says nothing about excluded pairs. So if this scene has any, the next start
        is checked in full, and the pairs that intersect there are excluded.

        Args:
            result: What `resolve` returned for this scene, with a path that is certified free.
            positions_t1: (n, 3) [m], proposed positions at the end of the next step.
            masses: (n,) [kg], as for a new scene; those of this scene if None. Pass them if a
                vertex is set free that was pinned and had no mass.
            pinned: (n,) bool, True for vertices that follow their path exactly; those of this
                scene if None.

        Returns:
            The next step.

        Raises:
            UncertifiedStartError: The path of the result is not certified free, or it is the result
                of another scene, or its positions have changed since.
            ShapeError: An array has the wrong shape or type.
            NonFiniteError: A position or a mass is NaN or infinite.
            MassError: A mass is zero or negative, or a vertex is set free that has none.
            DeviceUnavailableError: An array is on a GPU that cannot be used.
        """
        start = _certified_end(self, result).copy()  # numba compiles anew for read-only arrays
        masses = self.masses if masses is None else masses
        pinned = self.pinned if pinned is None else pinned
        if self.excluded is not None:
            return Scene(
                start, positions_t1, self.faces, masses, pinned, initial_intersections="exclude"
            )
        scene, n = copy.copy(self), len(start)
        scene.on_gpu = {}
        scene.positions_t0 = start
        scene.positions_t1 = scene._take_positions("positions_t1", positions_t1, n)
        scene.pinned = pinned if pinned is self.pinned else _take_pinned(pinned, n)
        if masses is not self.masses:
            scene._take_masses(masses)
        scene._require_masses()
        scene._steps_kept += 1
        if scene._steps_kept % KEPT_STEPS == 0:
            scene.tree_orders = tree_orders(start, self.edges, self.faces)
        return scene

    def _take_masses(self, masses: Any) -> None:
        """Check and copy masses; those of pinned vertices become 1 kg if they are no masses."""
        n = len(self.pinned)
        self.masses = checks.masses(copy_to_cpu("masses", detach(masses)), n, self.pinned)
        self._has_no_mass = np.isnan(self.masses)
        self.masses[self._has_no_mass] = 1.0

    def _require_masses(self) -> None:
        """Raise an error if a vertex that is not pinned has no mass from an earlier step."""
        free = np.flatnonzero(self._has_no_mass & ~self.pinned)
        if len(free):
            raise MassError(
                f"masses: expected masses > 0 [kg] for the vertices that are set free, found "
                f"{len(free)} without one, the first is vertex {free[0]}; pass masses with `pinned`"
            )

    def _take_positions(self, name: str, positions: Any, n: int | None = None) -> Positions:
        """Check and copy positions; if they are on a GPU, remember where."""
        positions = detach(positions)
        if is_on_gpu(positions):
            self.on_gpu[name] = (positions, None)
        return checks.floats(name, copy_to_cpu(name, positions), (n, 3))

    def _initial_intersections(self, exclude: bool) -> Pairs | None:
        """Return the pairs that intersect at the start, None if there are none, or raise."""
        mesh = self.edges, self.faces
        found = find_intersections(self.positions_t0, *mesh, self.tree_orders)
        if found.n_found == 0:
            return None
        if exclude:
            return found.pairs()
        shown = "; ".join(f"{a} and {b}" for a, b in found.describe(SHOWN))
        raise InitialIntersectionError(
            "positions_t0: expected a mesh without intersections, found "
            f"{found.n_found}, the first: {shown}. Pass initial_intersections='exclude' to "
            "leave these pairs out.",
            found.pairs(),
        )


def _take_pinned(pinned: Any, n: int) -> Flags:
    return checks.flags("pinned", copy_to_cpu("pinned", pinned), n)


def _certified_end(scene: Scene, result: Any) -> Positions:
    """Return the end of a path of a scene that is certified free, or raise."""
    certificate = getattr(result, "certificate", None)
    if certificate is None:
        raise UncertifiedStartError(
            f"result: expected what `resolve` returned, got {type(result).__name__}, which has no "
            "certificate. Pass its positions to a new Scene, which checks its start in full."
        )
    if certificate.scene is not scene:
        other = certificate.scene
        raise UncertifiedStartError(
            "result: expected the result of this scene, got that of another one, with "
            f"{len(other.positions_t0)} vertices and {len(other.faces)} faces; this scene has "
            f"{len(scene.positions_t0)} and {len(scene.faces)}. Call `after` of the scene that was "
            "resolved, or make a new Scene, which checks its start in full."
        )
    if not certificate.free:
        raise UncertifiedStartError(
            f"result: expected a path that is certified free, got one on which "
            f"{len(certificate.meeting_toi)} pairs meet, the first at t = {certificate.time_free}. "
            "Resolve a smaller step, or change the motion of the pinned vertices, and go on from "
            "there."
        )
    if not np.array_equal(result.positions, certificate.positions):
        raise UncertifiedStartError(
            "result.positions: expected the positions that were certified, found others. Copy them "
            "before you change them, or pass them to a new Scene, which checks its start in full."
        )
    return certificate.positions


def _require_distinct_corners(faces: Faces) -> None:
    a, b, c = faces.T
    repeated = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(repeated):
        first = repeated[0]
        raise DegenerateFaceError(
            f"faces: expected three different vertices each, found {len(repeated)} with a "
            f"repeated one, the first face {first}: {faces[first].tolist()}"
        )

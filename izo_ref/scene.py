"""The scene: checks the arrays of a time step once, where they come in.

Everything below this module takes a scene as valid and does not check it again.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import AnyArray, Edges, Faces, Flags, Indices, Masses, Positions
from izo_ref.base.certified import certified_end
from izo_ref.base.devices import copy_to_cpu, detach, is_on_gpu
from izo_ref.base.errors import (
    InitialIntersectionError,
    MassError,
)
from izo_ref.base.records import Components, ExcludedPairs, Exclusion, TouchingPairs, TreeOrders
from izo_ref.base.sizes import near_mesh, scene_in_range
from izo_ref.detection import weld as welding
from izo_ref.detection.coincident import find_coincident
from izo_ref.detection.components import MeshComponents
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.detection.touching import sort_start
from izo_ref.detection.trees import tree_orders

INITIAL_INTERSECTIONS = ("raise", "ratchet", "exclude")
PRESCRIBED = ("exclude", "block")

SHOWN = 5  # intersections of each kind that the message of an error names
RATCHET = (
    "Pass initial_intersections='ratchet' to go on: pairs that touch then keep to the side that "
    "the mesh tells; the other pairs are left out, until they are apart at the end of a step."
)
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
        initial_intersections: What to do if the mesh intersects itself at the start. `raise`: raise
            an error. `ratchet` and `exclude`: pairs that touch keep to the side that the mesh
            tells, from the start on (`touching`); pairs that cross, and pairs that touch where the
            mesh tells no side, are left out of this step (`excluded`). In the next step, `after`
            leaves out only those of them that are not apart yet (`ratchet`), or all pairs that
            intersect then (`exclude`).
        prescribed: What to do with pairs between pinned points that meet, which no positions of
            other vertices can prevent. `exclude`: leave them out, and resolve everything else.
            `block`: the step is then blocked.
        weld: Whether vertices that coincide are one vertex, as exporters write them along seams of
            a texture: None if they are not, or how far apart they may be [m], at the start and at
            the end; 0 if they coincide exactly. A chain of such vertices is one vertex too. The
            lowest vertex represents the others, which are its copies. It has the sum of their
            masses, and is pinned if one of them is. With `weld` > 0, all start and end where the
            lowest pinned vertex does, or else the lowest one; a chain must not lead farther than
            `weld` from it.

    Attributes:
        positions_t0: (n, 3) f8 [m], start of the step.
        positions_t1: (n, 3) f8 [m], proposed end of the step.
        faces: (m, 3) i4. If vertices are welded, faces name no copies; faces that became edges of
            other faces, or equal to a face before them, are left out.
        edges: (k, 2) i4, each edge once, the lower vertex first, sorted.
        masses: (n,) f8 [kg]; 1 for pinned vertices whose mass was not positive and finite; 0 for
            copies.
        pinned: (n,) b1, also True for the copies of a pinned vertex.
        weld: As passed in [m].
        copies: (n,) i8, the vertex that each vertex is a copy of, which is the vertex itself for
            those that are no copies; None if no vertices are welded.
        unwelded: `{name: array}` of the arguments that welding changed, as they were before.
        excluded: `ExcludedPairs` that are left out because of where they are at the start, or
            None.
        touching: `TouchingPairs` that touch at the start and keep to their side, or None.
        initial_intersections: As passed in.
        prescribed: As passed in.
        on_gpu: `{name: (array, order)}` for positions that came from a GPU. `order` is (n,) i8 and
            maps vertices to rows of the array; None means that vertex i is row i.
        tree_orders: Orders in which vertices, edges and faces enter trees, each (n,) i4.
        components: The connected components of the mesh.

    Raises:
        ShapeError: An array has the wrong shape or type.
        NonFiniteError: A position or a mass is NaN or infinite.
        IndexRangeError: A face has an index of no vertex.
        DegenerateFaceError: A face has the same vertex twice, or welding turns it into an edge
            that no other face has.
        SizeError: A coordinate is too large or too small to compute with (docs/limits).
        MassError: A mass is zero or negative, or too small beside the largest one.
        WeldError: `weld` joins vertices by a chain that is longer than `weld`, or joins many more
            vertices than copies.
        OptionError: `initial_intersections`, `prescribed` or `weld` has another value.
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
        prescribed: str = "exclude",
        weld: float | None = None,
    ) -> None:
        """Check and copy the arrays of a step; the class says what they are."""
        checks.choice("initial_intersections", initial_intersections, INITIAL_INTERSECTIONS)
        checks.choice("prescribed", prescribed, PRESCRIBED)
        self.initial_intersections, self.prescribed = initial_intersections, prescribed
        self.on_gpu: dict[str, tuple[Any, Indices | None]] = {}
        self.positions_t0: Positions = self._take_positions("positions_t0", positions_t0)
        n = len(self.positions_t0)
        self.positions_t1: Positions = self._take_positions("positions_t1", positions_t1, n)
        self.faces: Faces = checks.faces(copy_to_cpu("faces", faces), n)
        self.pinned: Flags = np.zeros(n, bool) if pinned is None else _take_pinned(pinned, n)
        self.weld: float | None = checks.weld(weld)
        self.copies: Indices | None = None
        self.unwelded: dict[str, AnyArray] = {}
        if self.weld is not None:
            self._weld(self.weld)
        self.masses: Masses = np.ones(n)
        self._has_no_mass: Flags = np.zeros(n, bool)
        if masses is not None or self.copies is not None:
            self._take_masses(1.0 if masses is None else masses)
        self.edges: Edges = edges_of(self.faces)
        self.components: Components = MeshComponents(
            n, welding.joined_faces(self.faces, self.copies)
        )
        self._steps_kept = 0  # since the elements were sorted for the trees
        self.tree_orders: TreeOrders = self._sort_elements()
        self.excluded: ExcludedPairs | None = None
        self.touching: TouchingPairs | None = None
        self._check_start()

    def after(
        self, result: Any, positions_t1: Any, masses: Any = None, pinned: Any = None
    ) -> Scene:
        """Return the next step of a simulation, which starts where the result of this one ends.

        The certificate of the result proves that its path is free up to its end, and the path
        began at a start without intersections. So no edge goes through a face at the end, and
        nothing touches: the next start needs no check. The mesh is the same, so its edges, its
        components and the orders of the trees are kept. `resolve` finds the same positions, bit for
        bit, as for a new `Scene` of the same arrays.

        The certificate says nothing about excluded pairs. So if there are any, the next start is
        checked in full, and the pairs that intersect there are excluded. With `ratchet`, these are
        only pairs that were excluded before, or are between pinned vertices. All others were
        certified apart at the end, so the set of excluded pairs never grows.

        The vertices that are welded stay so. The proposed positions of copies may be as far from
        those of their vertex as `weld` says.

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
            SizeError: A coordinate is too large or too small to compute with.
            MassError: A mass is zero or negative, or too small beside the largest one, or a vertex
                is set free that has none.
            InitialIntersectionError: Pairs were left out, and the next start intersects itself,
                with `initial_intersections="raise"`.
            WeldError: A copy is proposed to end elsewhere than its vertex.
            DeviceUnavailableError: An array is on a GPU that cannot be used.
        """
        start = certified_end(self, result).copy()  # numba compiles anew for read-only arrays
        masses = self.masses if masses is None else masses
        scene, n = copy.copy(self), len(start)
        scene.on_gpu, scene.unwelded = {}, self.unwelded.copy()
        scene.excluded = scene.touching = None
        scene.positions_t0 = start
        scene.positions_t1 = scene._take_positions("positions_t1", positions_t1, n)
        kept = self.unwelded.get("pinned", self.pinned)
        scene.pinned = kept if pinned is None else _take_pinned(pinned, n)
        if scene.copies is not None:
            scene._weld_paths(scene.copies, scene.weld or 0.0)
        if masses is not self.masses:
            scene._take_masses(masses)
        scene._require_masses()
        scene._steps_kept += 1
        if scene._steps_kept % KEPT_STEPS == 0:
            scene.tree_orders = scene._sort_elements()
        else:
            scene_in_range(scene)  # raises an error if its size cannot be computed with
        if result.certificate.excluded is not None:
            scene._check_start()
            if self.initial_intersections == "ratchet":
                scene._keep_excluded(result.certificate.excluded)
        return scene

    def _weld(self, tolerance: float) -> None:
        """Find the vertices that are one vertex, and make the others its copies."""
        copies = welding.find_copies(self.positions_t0, self.positions_t1, self.pinned, tolerance)
        if copies is None:
            return
        self.copies, self.unwelded["faces"] = copies, self.faces
        self.positions_t0 = self.positions_t0[welding.leaders_of(copies, self.pinned)]
        self.faces = welding.welded_faces(self.faces, copies)
        self._weld_paths(copies, tolerance)

    def _weld_paths(self, copies: Indices, tolerance: float) -> None:
        """Let the vertices of each group end at one place, and be pinned if one of them is."""
        leaders = welding.leaders_of(copies, self.pinned)
        welding.require_together("positions_t1", self.positions_t1, leaders, tolerance)
        self.positions_t1 = self.positions_t1[leaders]
        if tolerance > 0.0:
            self.on_gpu = {}  # the vertices of a group are at different places there
        self.unwelded["pinned"] = self.pinned
        self.pinned = welding.pinned_groups(self.pinned, copies)

    def _sort_elements(self) -> TreeOrders:
        """Sort the elements for the trees, without copies; raise an error at an unusable size."""
        orders = tree_orders(near_mesh(scene_in_range(self)[0]), self.edges, self.faces)
        return welding.without_copies(orders, self.copies)

    def _take_masses(self, masses: Any) -> None:
        """Check and copy masses; those of pinned vertices become 1 kg if they are no masses."""
        n = len(self.pinned)
        self.masses = checks.masses(copy_to_cpu("masses", detach(masses)), n, self.pinned)
        if self.copies is not None:
            self.unwelded["masses"] = np.where(np.isnan(self.masses), 1.0, self.masses)
            self.masses = welding.summed_masses(self.masses, self.copies)
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

    def _keep_excluded(self, before: ExcludedPairs | None) -> None:
        """Leave out only pairs that were left out before, or are between pinned vertices."""
        found = self.excluded
        if found is not None:
            keys = set() if before is None else set(pair_keys(before))
            kept = found.reasons == Exclusion.PRESCRIBED
            kept |= [key in keys for key in pair_keys(found)]
            self.excluded = found.take(kept) if kept.any() else None

    def _check_start(self) -> None:
        """Find the pairs that intersect at the start, and sort them, or raise an error."""
        mesh = self.edges, self.faces
        start = scene_in_range(self)[0].positions_t0
        found = find_intersections(start, *mesh, self.tree_orders)
        if found.n_found == 0:
            return
        prescribed = self.pinned if self.prescribed == "exclude" else None
        if self.initial_intersections == "raise":
            rest = found if prescribed is None else found.unprescribed(prescribed)
            if rest.n_found:
                pairs = rest.pairs()
                mesh = self.positions_t0, self.positions_t1, self.faces
                coincident = find_coincident(*mesh, pairs)
                lead = f"{coincident}Expected" if coincident.groups else "expected"
                raise InitialIntersectionError(
                    f"positions_t0: {lead} a mesh without intersections, found "
                    f"{rest.describe(SHOWN)}. {RATCHET}",
                    pairs,
                )
        self.excluded, self.touching = sort_start(start, self.faces, found, prescribed)


def _take_pinned(pinned: Any, n: int) -> Flags:
    return checks.flags("pinned", copy_to_cpu("pinned", pinned), n)

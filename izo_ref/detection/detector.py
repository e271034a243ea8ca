"""Detection on the CPU: find every vertex-face and edge-edge pair that meets on a path."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from izo_ref.base.arrays import Edges, Faces, Flags, Floats, Positions
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.options import RULES
from izo_ref.base.records import (
    Components,
    ExcludedPairs,
    Impacts,
    PairCounts,
    SceneArrays,
    TouchingPairs,
    TreeOrders,
    join_impacts,
)
from izo_ref.detection.components import MeshComponents
from izo_ref.detection.known_impacts import KnownImpacts
from izo_ref.detection.mesh import median_length
from izo_ref.detection.near_pairs import NearPairs
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.detection.serial.reach import largest_moves, renew_reach
from izo_ref.detection.touching_path import TouchingPath
from izo_ref.detection.trees import Elements, VertexBoxes, tree_orders

# A vertex that left its reach gets a new one: this many times its move since the last detection,
# because the loop converges, but at most this fraction of an edge, because too many pairs would be
# near it otherwise. All detections of armadillo-rollers take 4.2 CPU s with (2, 0.1), 4.3 with
# (2, 0.03) and 5.1 with (2, 0.3); those of stack-6k take 0.21, 0.21 and 0.29.
REACH_PER_MOVE = 2.0
FAR_REACH = 0.1


class Detector:
    """Finds the impacts of paths that have the same start.

    The detector keeps the pairs that are near. Each vertex has a reach about the end of its path.
    A pair that is not near stays apart as long as its vertices end within their reach. So a later
    detection looks for new pairs only where a vertex left its reach. It rechecks only the near
    pairs of which a vertex has moved farther than their last proof allows.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start of every path.
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.
        excluded: Pairs to ignore, or None.
        rules: Names of the rules of `options.RULES` to apply. Rules that do not concern detection
            have no effect here.
        touching: Pairs that touch at the start and are not ignored, or None.
        start_is_free: Whether the start is known to be free, from an exact check. Pairs at rest are
            then apart.
        orders: Orders in which vertices, edges and faces enter the trees; from the start if None.
        components: The components of the mesh, if they are known.
        deadline: When each detection has to end. After one that was ended, the next one begins
            anew.

    Attributes:
        counts: `PairCounts` of the last detection.
        elements: The trees of the vertices, of the edges and of the faces, from the first detection
            on.
    """

    def __init__(
        self,
        positions_t0: Positions,
        edges: Edges,
        faces: Faces,
        excluded: ExcludedPairs | None = None,
        rules: Set[str] = frozenset(RULES),
        *,
        touching: TouchingPairs | None = None,
        start_is_free: bool = True,
        orders: TreeOrders | None = None,
        components: Components | None = None,
        deadline: Deadline = UNLIMITED,
    ) -> None:
        """Keep the start and the mesh; the first `find` makes the trees."""
        vertices = np.arange(len(positions_t0), dtype=np.int32)[:, None]
        self.counts = PairCounts()
        self._nodes = vertices, edges, faces
        self._positions_t0 = positions_t0
        self._orders = orders or tree_orders(positions_t0, edges, faces)
        self._excluded = None if excluded is None else set(pair_keys(excluded))
        self._touching: TouchingPath | None = None
        if touching is not None:
            self._touching = TouchingPath(positions_t0, touching, deadline)
            self._excluded = (self._excluded or set()) | set(pair_keys(touching))
        self._rules, self._deadline = rules, deadline
        self._dtype = np.float32 if "float32-boxes" in rules else np.float64
        self._start_is_free = start_is_free
        self._previous_t1: Positions | None = None  # ends of the last detection
        self._components = components or MeshComponents(len(positions_t0), faces)
        self._left_out: Flags | None = None  # (n_components,) b1, components that are in no tree
        self._far_reach: float | None = None  # [m]
        self.elements: tuple[Elements, ...] = ()
        self._near: tuple[NearPairs, ...] = ()  # vertex-face pairs, edge-edge pairs

    @classmethod
    def of_scene(
        cls,
        scene: SceneArrays,
        rules: Set[str] = frozenset(RULES),
        deadline: Deadline = UNLIMITED,
    ) -> Detector:
        """Return a detector for the paths of a scene."""
        return cls(
            scene.positions_t0,
            scene.edges,
            scene.faces,
            scene.excluded,
            rules,
            touching=scene.touching,
            orders=scene.tree_orders,
            components=scene.components,
            deadline=deadline,
        )

    def find(self, positions_t1: Positions) -> Impacts:
        """Find the impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m].

        Returns:
            `Impacts`: first the vertex-face pairs, sorted by vertex and face, then the edge-edge
            pairs, sorted by their edges, and last those that touch at the start and do not come
            apart, or meet again.
        """
        previous_t1, self._previous_t1 = self._previous_t1, None  # until this one is finished
        if previous_t1 is None:
            moves, n_moved = np.empty(0), len(positions_t1)
        else:
            moves, n_moved = largest_moves(positions_t1, previous_t1)
        self.counts = PairCounts(n_moved)
        is_first = previous_t1 is None or "incremental" not in self._rules
        if is_first or self._reaches_left_out(positions_t1):
            self._begin(positions_t1)
        else:
            self._renew_reach(positions_t1, moves)
            self._known.forget(moves)
            contacts = [near.recheck(positions_t1, moves, self.counts) for near in self._near]
            self._known.add(contacts, positions_t1)
        found = self._known.impacts
        if self._touching is not None:
            found = join_impacts((found, self._touching.find(positions_t1)))
        self._previous_t1 = positions_t1.copy()
        return found

    def _reaches_left_out(self, positions_t1: Positions) -> bool:
        """Return whether a component in no tree moves now, or is reached by one that moves."""
        if self._left_out is None:
            return False
        far = self._components.out_of_reach(self._positions_t0, positions_t1)
        return bool((self._left_out & ~far).any())

    def _begin(self, positions_t1: Positions) -> None:
        """Look at all pairs, except those that a rule leaves out."""
        moving = largest_moves(positions_t1, self._positions_t0)[0] > 0.0
        self._make_trees(positions_t1, bool(moving.all()))
        self._centres, self._reach = positions_t1.copy(), np.zeros(len(positions_t1))
        if not ("still" in self._rules and self._start_is_free):
            moving[:] = True
        about = self._positions_t0, self._centres, self._reach
        self._boxes = VertexBoxes(*about, self._dtype, self._nodes[1])
        for elements in self.elements:
            elements.refit(self._boxes.boxes, moving, everything=True)
        kept = self._start_is_free, self._excluded, self._deadline
        self._known = KnownImpacts(self._positions_t0, *kept)
        contacts = [near.find_contacts(positions_t1, self.counts) for near in self._near]
        self._known.add(contacts, positions_t1)

    def _make_trees(self, positions_t1: Positions, all_move: bool) -> None:
        """Make the trees, without the components at rest that nothing reaches."""
        orders, self._left_out = self._orders, None
        may_leave_out = "one-box" in self._rules and self._start_is_free
        if may_leave_out and not all_move:
            far = self._components.out_of_reach(self._positions_t0, positions_t1)
            if far.any():
                self._left_out, kept = far, ~far[self._components.component]
                orders = [
                    order[kept[nodes[order, 0]]]
                    for nodes, order in zip(self._nodes, orders, strict=True)
                ]
        vertices, edges, faces = (
            Elements(nodes, order, self._dtype)
            for nodes, order in zip(self._nodes, orders, strict=True)
        )
        self.elements = vertices, edges, faces
        self._near = (
            NearPairs("vertex_face", vertices, faces, self._positions_t0, self._deadline),
            NearPairs("edge_edge", edges, edges, self._positions_t0, self._deadline),
        )

    def _renew_reach(self, positions_t1: Positions, moves: Floats) -> None:
        """Give a new reach to the vertices that left theirs, and find what is near them now."""
        if self._far_reach is None:
            self._far_reach = FAR_REACH * median_length(self._positions_t0, self._nodes[1])
        kept, left = (self._centres, self._reach), np.empty(len(moves), bool)
        if renew_reach(positions_t1, moves, REACH_PER_MOVE, self._far_reach, *kept, left) == 0:
            return
        self._boxes.refit(left)
        for elements in self.elements:
            elements.refit(self._boxes.boxes, left, everything=False)
        for near in self._near:
            near.update_near()

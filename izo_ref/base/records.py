"""Records that pass between the stages."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from izo_ref.base.arrays import (
    AnyArray,
    Codes,
    Edges,
    Faces,
    Flags,
    Indices,
    Ints,
    Masses,
    Nodes,
    Normals,
    Positions,
    Times,
    Weights,
)

# Orders in which the vertices, edges and faces of a mesh enter trees of boxes, each (n,) i4.
# Elements that follow one another are close in space. Any order gives the same answers.
TreeOrders: TypeAlias = tuple[Ints, Ints, Ints]


class Status(enum.Enum):
    """How a step ended. The value is a sentence for the user."""

    FREE = "The path is certified free and every zone is solved to tolerance."
    FREE_BY_FALLBACK = (
        "The path is certified free, but not every zone is optimal: some zones were scaled back "
        "toward the start of the step, or were not solved to tolerance, or the time limit ended "
        "the run. The result may be farther from the proposed positions than necessary."
    )
    FREE_EXCEPT_EXCLUDED = (
        "Some pairs were left out, and nothing is promised about them: they touch or cross at the "
        "start, or are between pinned parts. The path of all other pairs is certified free. The "
        "list of excluded pairs says why each was left out, and whether it is apart, touches or "
        "crosses at the end."
    )
    BLOCKED = (
        "No free path was found: the named pairs meet, or something is pinched between "
        "pinned parts of the mesh. The path is free up to the given time. Take a smaller step, "
        "or change the motion of the pinned vertices."
    )


class Components(Protocol):
    """Connected components of a mesh, which are found when they are first needed."""

    @property
    def component(self) -> Indices:
        """(n_vertices,) i8, the component that each vertex is in."""
        ...

    @property
    def count(self) -> int:
        """Number of components."""
        ...

    def out_of_reach(self, positions_t0: Positions, positions_t1: Positions) -> Flags:
        """Return which components are at rest and meet the box of no moving one, (count,) b1."""
        ...

    def renumbered(self, order: Indices) -> Components:
        """Return the same components of a mesh with vertex `order[i]` as number i."""
        ...


class SceneArrays(Protocol):
    """What the stages below `scene.py` read of a `Scene`.

    Attributes:
        positions_t0: (n, 3) f8 [m], start of the step.
        positions_t1: (n, 3) f8 [m], proposed end of the step.
        faces: (m, 3) i4.
        edges: (k, 2) i4, each edge once, the lower vertex first, sorted.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
        excluded: Pairs that are left out, or None.
        touching: Pairs that touch at the start and are not left out, or None.
        prescribed: What to do with impacts between pinned points: `exclude` or `block`.
        on_gpu: `{name: (array, order)}` for positions that came from a GPU; `order` maps vertices
            to rows of the array, or is None.
        tree_orders: Orders in which vertices, edges and faces enter trees.
        components: The connected components of the mesh (`detection/components.py`).
        copies: (n,) i8, the vertex that each vertex is a copy of, itself for most; None if no
            vertex is a copy. Copies are in no face, edge or tree order, and have no mass.
    """

    positions_t0: Positions
    positions_t1: Positions
    faces: Faces
    edges: Edges
    masses: Masses
    pinned: Flags
    excluded: ExcludedPairs | None
    touching: TouchingPairs | None
    prescribed: str
    on_gpu: dict[str, tuple[Any, Indices | None]]
    tree_orders: TreeOrders
    components: Components
    copies: Indices | None


class Pairs(NamedTuple):
    """Vertex-face and edge-edge pairs.

    Attributes:
        nodes: (n, 4) i4, the vertex and the face's corners, or the ends of one edge and of the
            other.
        is_edge_edge: (n,) b1.
    """

    nodes: Nodes
    is_edge_edge: Flags


class Exclusion(enum.IntEnum):
    """Why a pair is left out."""

    CROSSING = 0  # an edge of the pair goes through a face at the start
    TOUCHING = 1  # the pair touches at the start, and the mesh tells no side
    PRESCRIBED = 2  # the pair meets between pinned points, which no positions can prevent


class PairState(enum.IntEnum):
    """Where the sides of a pair are at rest."""

    APART = 0
    TOUCHING = 1
    CROSSING = 2  # an edge of the pair goes through a face, which is or belongs to the other side
    UNKNOWN = 3  # the time limit ended the run before that was decided


class ExcludedPairs(NamedTuple):
    """Vertex-face and edge-edge pairs that are left out, and why.

    Attributes:
        nodes: (n, 4) i4, as for `Pairs`.
        is_edge_edge: (n,) b1.
        reasons: (n,) i1, values of `Exclusion`.
    """

    nodes: Nodes
    is_edge_edge: Flags
    reasons: Codes

    def take(self, index: Any) -> ExcludedPairs:
        """Return the pairs of an index array or a mask."""
        return ExcludedPairs._make(take_rows(self, index))


class TouchingPairs(NamedTuple):
    """Pairs that touch at the start of a step, where the mesh tells on which side they are.

    Attributes:
        nodes: (n, 4) i4, as for `Pairs`.
        is_edge_edge: (n,) b1.
        weights: (n, 4) f8, of the point of contact; positive on the first side, negative on the
            second.
        normals: (n, 3) f8, unit vectors from the second side to the first one.
        edge_faces: (m, 5) i4, the ends of an edge and the corners of a face: each edge and face
            that touch at the start by some of the pairs, and by no other pair.
        contact: (k,) i4, a row of `edge_faces`, and
        pair: (k,) i4, a pair by which the two touch.
    """

    nodes: Nodes
    is_edge_edge: Flags
    weights: Weights
    normals: Normals
    edge_faces: Ints
    contact: Ints
    pair: Ints


class Impacts(NamedTuple):
    """Pairs that meet on a path, each with its contact frozen at its time of impact.

    The frozen gap of impact j at positions x is normals_j . sum_k weights_jk x[nodes_jk].

    Attributes:
        nodes: (n, 4) i4, the vertex and the face's corners, or the ends of one edge and of the
            other.
        is_edge_edge: (n,) b1.
        toi: (n,) f8, time of impact, from 0 to 1.
        weights: (n, 4) f8, positive on the first side, negative on the second; their sum is zero.
        normals: (n, 3) f8, unit vectors; the gap is positive at t = 0.
    """

    nodes: Nodes  # (n, 4) i4
    is_edge_edge: Flags  # (n,) b1
    toi: Times  # (n,) f8
    weights: Weights  # (n, 4) f8
    normals: Normals  # (n, 3) f8

    def take(self, index: Any) -> Impacts:
        """Return the impacts of an index array or a mask."""
        return Impacts._make(take_rows(self, index))


def take_rows(columns: Iterable[AnyArray], index: Any) -> list[AnyArray]:
    """Return the rows of an index array or a mask, of each of several arrays."""
    places = index.nonzero()[0] if index.dtype == bool else index
    # in brackets, a short index takes numpy four times as long
    return [column.take(places, axis=0) for column in columns]


def empty_impacts(n: int, empty: Callable[[tuple[int, ...], Any], Any] = np.empty) -> Impacts:
    """Return room for n impacts, not written to.

    Args:
        n: Number of impacts.
        empty: Makes an array of a shape and a dtype, on the CPU or on a GPU.
    """
    return Impacts(
        empty((n, 4), np.int32),
        empty((n,), np.bool_),
        empty((n,), np.float64),
        empty((n, 4), np.float64),
        empty((n, 3), np.float64),
    )


def no_impacts() -> Impacts:
    """Return a record of no impacts."""
    return empty_impacts(0)


def join_impacts(parts: Iterable[Impacts]) -> Impacts:
    """Return the impacts of several records, one record after the other."""
    records = list(parts) or [no_impacts()]
    return Impacts._make([np.concatenate(columns) for columns in zip(*records, strict=True)])


class DetectionCounts(NamedTuple):
    """What one detection of the loop found.

    Attributes:
        found: Impacts of the path, without those that have pinned vertices only.
        blocked: Impacts that have pinned vertices only.
        moved: Vertices that moved since the last detection.
        candidates: Candidate pairs.
    """

    found: int
    blocked: int
    moved: int
    candidates: int


class PairCounts:
    """Counts of the pairs that one detection looked at, and of their proofs.

    Attributes:
        moved: Vertices that ended elsewhere than in the detection before.
        pairs: Candidate pairs, by kind.
        settled: Candidate pairs that a GPU proved apart in float32; they take no step.
        steps: Steps of all proofs in float64.
        most_steps: Steps of the longest of these proofs.
    """

    def __init__(self, moved: int = 0) -> None:
        """Start all counts of pairs and steps at zero."""
        self.moved = moved
        self.pairs = {"vertex_face": 0, "edge_edge": 0}
        self.settled = 0
        self.steps = 0
        self.most_steps = 0

    def add(self, kind: str, pairs: int, steps: int, most_steps: int, settled: int = 0) -> None:
        """Add the counts of some pairs.

        Args:
            kind: `vertex_face` or `edge_edge`.
            pairs: Candidate pairs.
            steps: Steps of their proofs in float64.
            most_steps: Steps of the longest of these proofs.
            settled: How many of the pairs a GPU proved apart in float32.
        """
        self.pairs[kind] += int(pairs)
        self.settled += int(settled)
        self.steps += int(steps)
        self.most_steps = max(self.most_steps, int(most_steps))

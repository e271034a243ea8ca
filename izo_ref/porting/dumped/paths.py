"""A path of a dump, what the reference finds on it, and the frames at the times of the dump."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices, Nodes, Positions
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.detection.cpu.frames import compute_impact_frames
from izo_ref.detection.serial.prescribed import NO_WEIGHT
from izo_ref.porting.dumped.arrays import Rows

Key: TypeAlias = "tuple[int, ...]"

ROOM = 64.0  # roundings of a coordinate that the numbers of a stage may have


class Path(NamedTuple):
    """A path, and what the reference finds on it.

    Attributes:
        scene: The scene; its proposed positions are the end of the path.
        impacts: Impacts of the path, without those between pinned points.
        ignored: Keys of pairs that a port may list or leave out.
        eps: Machine epsilon of the dump.
    """

    scene: SceneArrays
    impacts: Impacts
    ignored: frozenset[Key]
    eps: float


def keys_of(nodes: Nodes, kinds: Flags) -> list[Key]:
    """Return a key for each pair that does not depend on the order of corners, ends and edges."""
    keys = []
    for row, is_edge_edge in zip(nodes.tolist(), kinds.tolist(), strict=True):
        if is_edge_edge:
            first, second = sorted((sorted(row[:2]), sorted(row[2:])))
            keys.append((1, *first, *second))
        else:
            keys.append((0, row[0], *sorted(row[1:])))
    return keys


def name_of(nodes: Nodes, is_edge_edge: bool) -> str:
    """Return a pair as a person reads it."""
    a, b, c, d = nodes.tolist()
    return f"edges {a}-{b} and {c}-{d}" if is_edge_edge else f"vertex {a} and face {b} {c} {d}"


def prescribed(rows: Rows, pinned: Flags) -> Flags:
    """Return which impacts are between pinned points, (m,) b1."""
    held = pinned[rows.nodes]
    if rows.weights is None:
        return np.asarray(held.all(axis=1))
    return np.where(held, 0.0, np.abs(rows.weights)).sum(axis=1) < NO_WEIGHT


def matches(path: Path, rows: Rows) -> tuple[Indices, Indices]:
    """Return the rows of a dump that the reference has too, and where it has them."""
    place = {
        key: i
        for i, key in enumerate(keys_of(path.impacts.nodes, path.impacts.is_edge_edge))
        if key not in path.ignored
    }
    both = [
        (i, place[key])
        for i, key in enumerate(keys_of(rows.nodes, rows.is_edge_edge))
        if key in place
    ]
    own, places = np.array(both, np.int64).reshape(-1, 2).T
    return own, places


def ends(path: Path, nodes: Nodes) -> tuple[Positions, Positions]:
    """Return the nodes of pairs at both ends of a path, each (..., 4, 3) f8 [m]."""
    return path.scene.positions_t0[nodes], path.scene.positions_t1[nodes]


def extent(path: Path, nodes: Nodes) -> Floats:
    """Return the largest coordinate of each pair, (m,) f8 [m]."""
    start, end = ends(path, nodes)
    return np.maximum(np.abs(start), np.abs(end)).max(axis=(1, 2), initial=0.0)


def length(vectors: Floats) -> Floats:
    """Return the length of each vector, (m,) f8."""
    return np.sqrt(np.einsum("jx,jx->j", vectors, vectors))


def drift(path: Path, places: Indices, toi: Floats) -> Floats:
    """Return how far nodes move between a time of a dump and the contact, (m,) f8 [m].

    A port takes its frames at the contact or at the time that it says; both are right.
    """
    start, end = ends(path, path.impacts.nodes[places])
    moved = end - start
    most = np.abs(moved - moved[:, :1]).max(axis=(1, 2), initial=0.0)
    return np.abs(path.impacts.toi[places] - toi) * most


class Frame:
    """The frames that the reference has at the times of a dump.

    Attributes:
        toi: (m,) f8, the times of the dump, within [0, 1].
        weights: (m, 4) f8.
        normals: (m, 3) f8.
        error: (m,) f8 [m], rounding of a coordinate.
        height: (m,) f8 [m], size of the features that fix the normal, seen across.
        uncertain: (m,) b1, pairs whose features do not fix the normal.
    """

    def __init__(self, path: Path, rows: Rows, own: Indices) -> None:
        """Compute the frames of some rows of a dump that has times."""
        assert rows.toi is not None
        start, end = path.scene.positions_t0, path.scene.positions_t1
        nodes, kinds = rows.nodes[own], rows.is_edge_edge[own]
        times = np.nan_to_num(rows.toi[own], nan=0.0)
        self.toi = np.clip(times, 0.0, 1.0)
        self.weights, self.normals = np.empty((len(own), 4)), np.empty((len(own), 3))
        none = np.zeros((len(own), 3))
        compute_impact_frames(start, end, nodes, kinds, self.toi, none, self.weights, self.normals)
        self._start = start[nodes]
        at = self.toi[:, None, None]
        self._then = (1.0 - at) * start[nodes] + at * end[nodes]
        self.error = ROOM * path.eps * extent(path, nodes)
        edges = kinds[:, None]
        u = np.where(
            edges, self._then[:, 1] - self._then[:, 0], self._then[:, 2] - self._then[:, 1]
        )
        v = np.where(
            edges, self._then[:, 3] - self._then[:, 2], self._then[:, 3] - self._then[:, 1]
        )
        across = length(np.cross(u, v))
        with np.errstate(all="ignore"):
            self.height = np.nan_to_num(across / np.maximum(length(u), length(v)))
            gap = np.einsum("jx,jx->j", self.normals, self.between(self.weights, at_start=True))
            plane = np.nan_to_num(np.cross(u, v) / across[:, None])
        along = np.abs(np.einsum("jx,jx->j", plane, self.normals))
        self.uncertain = ~(self.height > 0.0) | (np.abs(gap) <= self.error) | (along < 0.5)
        self.height = np.where(self.height > 0.0, self.height, 1.0)

    def between(self, weights: Floats, at_start: bool = False) -> Floats:
        """Return the vectors between the points of some weights, (m, 3) f8 [m]."""
        nodes = self._start if at_start else self._then
        return np.einsum("jk,jkx->jx", np.nan_to_num(weights), nodes - nodes[:, :1])

"""Detection on a GPU: finds the same impacts as `detection/detector.py`, in the same order.

Nothing is kept from one path to the next. For each path, the pairs whose moving boxes meet are
counted and then written, so that there is no limit to their number. Among them the contacts are
found, and among these the impacts, which are sorted.
"""

from collections.abc import Iterator
from itertools import zip_longest

import numpy as np

from izo_ref.base.arrays import GpuArray, Indices, Ints, Offsets, Positions
from izo_ref.base.cuda.arrays import LARGEST, LEAST, SUM
from izo_ref.base.gpu_arrays import (
    arange,
    as_column,
    concatenate,
    empty,
    flatnonzero,
    full,
    last_of,
    offsets_of,
    positions_of,
    reduce,
    stable_argsort,
    take,
    to_cpu,
    to_gpu,
)
from izo_ref.base.gpu_impacts import (
    concatenate_impacts,
    empty_impacts,
    impacts_to_cpu,
    impacts_to_gpu,
)
from izo_ref.base.records import Impacts, PairCounts, SceneArrays, no_impacts
from izo_ref.base.sizes import near_mesh
from izo_ref.detection.cpu import frames as cpu_frames
from izo_ref.detection.cuda import contacts, frames, paths
from izo_ref.detection.cuda import tree as trees
from izo_ref.detection.doubts import settle_doubts
from izo_ref.detection.serial.contacts import VERTEX_FACE_OFFSET
from izo_ref.detection.serial.tree import Tree
from izo_ref.detection.touching_path import TouchingPath
from izo_ref.detection.trees import bare_tree, box_frame, morton_grid

# Pairs that one launch looks at. Each takes 72 bytes until the contacts are known.
BATCH = 1 << 22


class Elements:
    """Elements of one kind (vertices, edges or faces), sorted in space, in a tree of boxes.

    Args:
        numbers: (n,) i4, numbers of the elements, on the CPU.
        nodes: (n, k) i4, vertices of the elements, on the CPU.
        positions_t0: (n_vertices, 3) f8 [m], start positions, on the GPU.
        grid: Origin (3,) [m], on the GPU, and cells per metre of the grid of the Morton curve along
            which the elements are sorted.

    Attributes:
        tree: `Tree`, on the GPU.
        levels: (n_levels + 1,) i8, `tree.levels` on the CPU.
        numbers: (n,) i8, 0 to n - 1, on the GPU.
        no_room: (n + 1,) i8, zeros, on the GPU: starts with which nothing is written.
    """

    def __init__(
        self, numbers: Ints, nodes: Ints, positions_t0: GpuArray, grid: tuple[GpuArray, float]
    ) -> None:
        """Sort the elements, and make the tree with empty boxes."""
        n = len(nodes)
        nodes, codes = to_gpu(nodes), empty(n, np.int64)
        trees.compute_morton_codes[n](positions_t0, nodes, *grid, codes)
        index = stable_argsort(codes)
        order = take(to_gpu(numbers), index)
        blocks, lanes, self.levels = bare_tree(n, np.float32)
        levels = to_gpu(self.levels)
        self.tree = Tree(order, take(nodes, index), to_gpu(blocks), to_gpu(lanes), levels)
        self.numbers, self.no_room = arange(n), full(n + 1, 0, np.int64)


class Detector:
    """Finds the impacts of paths that start at the same positions, which are free.

    Args:
        scene: The scene, which gives the start, the mesh and the pairs to ignore.
        counts_proofs: Whether to count the steps of the proofs; otherwise these counts stay 0.

    Attributes:
        counts: `PairCounts` of the last detection.
    """

    def __init__(self, scene: SceneArrays, counts_proofs: bool = False) -> None:
        """Copy the mesh to the GPU and make the trees."""
        start = scene.positions_t0
        self.counts, self._counts_proofs = PairCounts(), counts_proofs
        self._n = len(start)
        self._has_faces = len(scene.faces) > 0
        if not self._has_faces:
            return
        self._start = positions_of(scene, "positions_t0")
        origin, scale = box_frame(start, scene.edges)
        self._frame = to_gpu(origin), scale
        grid_origin, cells_per_m = morton_grid(near_mesh(scene))
        grid = to_gpu(grid_origin), cells_per_m
        vertices = np.sort(scene.tree_orders[0])  # without copies
        self._elements = [
            Elements(vertices, vertices.reshape(-1, 1), self._start, grid),
            *(
                Elements(np.arange(len(nodes), dtype=np.int32), nodes, self._start, grid)
                for nodes in (scene.edges, scene.faces)
            ),
        ]
        self._excluded = to_gpu(_keys_to_ignore(scene))
        self._touching: TouchingPath | None = None
        if scene.touching is not None:
            self._touching = TouchingPath(start, scene.touching)

    def find(self, positions_t1: GpuArray) -> Impacts:
        """Find the impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], on the GPU.

        Returns:
            `Impacts` on the GPU: first the vertex-face pairs, sorted by vertex and face, then the
            edge-edge pairs, sorted by their edges, and last the pairs that touch at the start.
        """
        self.counts = PairCounts()
        if not self._has_faces:
            return impacts_to_gpu(no_impacts())
        moved = self._refit(positions_t1)
        vertices, edges, faces = self._elements
        found = [
            *self._contacts("vertex_face", vertices, faces, positions_t1),
            *self._contacts("edge_edge", edges, edges, positions_t1),
        ]
        columns = zip(*found, strict=True)
        keys, *contacts = found[0] if len(found) == 1 else [concatenate(parts) for parts in columns]
        n = keys.shape[0]
        kept = empty(n, np.bool_)
        paths.flag_kept_contacts[n](keys, contacts[0], moved, self._excluded, kept)
        index = flatnonzero(kept)
        index = take(index, stable_argsort(take(keys, index)))
        found = empty_impacts(index.shape[0])
        frames.gather_impacts[index.shape[0]](self._start, positions_t1, index, *contacts, *found)
        if index.shape[0] and reduce(as_column(found.toi.view(np.int64)), LEAST) == 0:
            found = self._settled(found, positions_t1)
        if self._touching is None:
            return found
        touching = self._touching.find(to_cpu(positions_t1))  # exact arithmetic runs on the CPU
        return concatenate_impacts(found, impacts_to_gpu(touching))

    def _settled(self, found: Impacts, positions_t1: GpuArray) -> Impacts:
        """Return impacts of which some begin at t = 0, decided exactly on the CPU."""
        start, end = to_cpu(self._start), to_cpu(positions_t1)
        own = Impacts._make(column.copy() for column in impacts_to_cpu(found))
        began = own.toi == 0.0
        meets = settle_doubts(start, end, *own[:3], own.normals)
        places = np.flatnonzero(began & meets)
        part = own.take(places)
        frame = np.empty((len(places), 4)), np.empty((len(places), 3))
        pairs = part.nodes, part.is_edge_edge, part.toi, part.normals
        cpu_frames.compute_impact_frames(start, end, *pairs, *frame)
        own.weights[places], own.normals[places] = frame
        return impacts_to_gpu(own.take(meets))

    def _refit(self, positions_t1: GpuArray) -> GpuArray:
        """Fit all boxes, and return which vertices move, (n_vertices,) b1.

        Only elements with such a vertex are marked. Elements at rest are not compared with each
        other, but can be hit.
        """
        boxes, moved = empty((self._n, 9), np.float32), empty(self._n, np.bool_)
        trees.compute_path_boxes[self._n](self._start, positions_t1, *self._frame, boxes, moved)
        own = [elements.tree for elements in self._elements]
        for level, n_blocks in enumerate(_sizes([e.levels for e in self._elements])):
            if level == 0:
                trees.fit_element_boxes[n_blocks](boxes, moved, *own)
            else:
                trees.fit_parent_boxes[n_blocks](level, *own)
        return moved

    def _contacts(
        self, kind: str, queries: Elements, leaves: Elements, positions_t1: GpuArray
    ) -> Iterator[tuple[GpuArray, ...]]:
        """Yield the contacts of each batch of pairs.

        Contacts are the pairs that are not proved apart: their keys, nodes, kinds, times and last
        directions.
        """
        pairs = _meeting_pairs(queries, leaves)
        first, second = queries.tree, leaves.tree
        for begin in range(0, max(pairs.shape[0], 1), BATCH):
            batch = pairs[begin : begin + BATCH]
            n = batch.shape[0]
            tallies, index = empty((n, 3), np.int64), empty(n, np.int64)
            toi, directions = empty(n, np.float64), empty((n, 3), np.float64)
            margins = empty(n, np.float64)
            contacts.find_contacts[n](
                arange(n),
                batch,
                first.order,
                first.nodes,
                second.order,
                second.nodes,
                self._start,
                positions_t1,
                tallies,
                index,
                toi,
                directions,
                margins,
            )
            is_contact = empty(n, np.bool_)
            paths.flag_contacts[n](tallies, is_contact)
            own = flatnonzero(is_contact)
            m = own.shape[0]
            found = (
                empty(m, np.int64),
                empty((m, 4), np.int32),
                empty(m, np.bool_),
                empty(m, np.float64),
                empty((m, 3), np.float64),
            )
            contacts.gather_contacts[m](own, batch, toi, directions, first, second, *found)
            self._count(kind, n, tallies)
            yield found

    def _count(self, kind: str, n: int, tallies: GpuArray) -> None:
        proofs, most = 0, 0
        if self._counts_proofs and n:
            proofs, most = reduce(tallies, SUM, 1), reduce(tallies, LARGEST, 2)
        self.counts.add(kind, n, proofs, most)


class HostDetector:
    """A detector on the GPU with the interface of the one on the CPU (`detection/detector.py`).

    Args:
        detector: The detector on the GPU.
        previous_t1: (n_vertices, 3) f8 [m], on the CPU, ends of the path of the last detection;
            None if there was none.

    Attributes:
        counts: `PairCounts` of the last detection.
    """

    def __init__(self, detector: Detector, previous_t1: Positions | None = None) -> None:
        """Wrap a detector."""
        self.counts = detector.counts
        self._detector, self._previous_t1 = detector, previous_t1

    def find(self, positions_t1: Positions) -> Impacts:
        """Find the impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], on the CPU.

        Returns:
            `Impacts` on the CPU, sorted as those of the detector.
        """
        moved = len(positions_t1)
        if self._previous_t1 is not None:
            moved = np.count_nonzero((positions_t1 != self._previous_t1).any(axis=1))
        self._previous_t1 = positions_t1.copy()
        found = self._detector.find(to_gpu(positions_t1))
        self.counts = self._detector.counts
        self.counts.moved = int(moved)
        return impacts_to_cpu(found)


def find_impacts(scene: SceneArrays) -> Impacts:
    """Find the impacts of a scene on the GPU, and return them on the CPU."""
    return impacts_to_cpu(Detector(scene).find(positions_of(scene, "positions_t1")))


def _sizes(levels_of_trees: list[Offsets]) -> list[int]:
    """Return the number of blocks in each level of several trees together, elements first."""
    sizes = [np.diff(levels) for levels in levels_of_trees]
    return [sum(map(int, level)) for level in zip_longest(*sizes, fillvalue=0)]


def _meeting_pairs(queries: Elements, leaves: Elements) -> GpuArray:
    """Return the places of each query and leaf whose moving boxes meet, (n, 2) i4.

    A first launch counts the pairs, a second one writes them.
    """
    n = queries.tree.nodes.shape[0]
    counts, same = empty(n, np.int64), queries is leaves
    trees, nothing = (queries.tree, leaves.tree), empty((0, 2), np.int32)
    contacts.find_pairs[n](queries.numbers, queries.no_room, *trees, same, counts, nothing)
    starts = offsets_of(counts)
    pairs = empty((last_of(starts), 2), np.int32)
    contacts.find_pairs[n](queries.numbers, starts, *trees, same, counts, pairs)
    return pairs


def _keys_to_ignore(scene: SceneArrays) -> Indices:
    """Return the keys of pairs that are excluded or touch at the start, as contacts have them."""
    parts = [part for part in (scene.excluded, scene.touching) if part is not None]
    if not parts:
        return np.empty(0, np.int64)
    nodes = np.concatenate([part.nodes for part in parts]).astype(np.int64)
    ee = np.concatenate([part.is_edge_edge for part in parts])
    twins = _rows_of(scene.faces)  # faces with the same corners have the same pairs
    vertex_face = [
        vertex << 32 | face
        for vertex, *corners in nodes[~ee].tolist()
        for face in twins[tuple(sorted(corners))]
    ]
    edges = _rows_of(scene.edges)
    edge_edge = []
    for a, b, c, d in nodes[ee].tolist():
        low, high = sorted((*edges[min(a, b), max(a, b)], *edges[min(c, d), max(c, d)]))
        edge_edge.append(low << 32 | high)
    keys = np.array(vertex_face, np.int64) + VERTEX_FACE_OFFSET, np.array(edge_edge, np.int64)
    return np.unique(np.concatenate(keys))


def _rows_of(rows: Ints) -> dict[tuple[int, ...], list[int]]:
    """Return the numbers of the rows that have some nodes, by these nodes in ascending order."""
    numbers: dict[tuple[int, ...], list[int]] = {}
    for i, row in enumerate(rows.tolist()):
        numbers.setdefault(tuple(sorted(row)), []).append(i)
    return numbers

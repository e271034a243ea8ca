"""Study of the float32 filter of a GPU: how many pairs it settles, and what it would cost a CPU.

All of it runs on the CPU: the filter is the same function on both.
"""

import os
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from izo_ref import resolve
from izo_ref.base.arrays import (
    AnyFloats,
    Flags,
    Floats,
    Indices,
    Ints,
    Positions,
    Times,
)
from izo_ref.base.compile import cpu_kernel, light_kernel
from izo_ref.base.errors import InitialIntersectionError
from izo_ref.detection.cpu.contacts import CHUNK
from izo_ref.detection.detector import Detector
from izo_ref.detection.serial.contacts import contacts_of_pairs, pair_nodes
from izo_ref.detection.serial.filter import is_settled
from izo_ref.detection.trees import Elements, VertexBoxes, meeting_pairs
from izo_ref.scene import Scene
from validation import ptx
from validation.rows import Rows
from validation.study import steps
from validation.study.gpu_parts import Clock
from validation.study.parts import Say

PAIRS = 5  # times with and without the filter, which are taken in turn; the medians count
GROUP = 32  # threads of a GPU that run together
KERNELS = ("detection.contacts.list_open_pairs", "detection.contacts.list_contacts")


class Candidates(NamedTuple):
    """The candidate pairs of one kind on a path."""

    kind: str
    settled: Flags  # (n,) b1, the filter proves the pair apart
    contact: Flags  # (n,) b1, the pair counts as a contact


@light_kernel
def flag_settled(
    # In:
    pairs: Ints,  # (n_pairs, 2) i4, places
    first_order: Ints,  # (m,) i4
    first_nodes: Ints,  # (m, k) i4
    second_order: Ints,  # (m,) i4
    second_nodes: Ints,  # (m, k) i4
    vertex_boxes: AnyFloats,  # (n_vertices, 9) f4
    # Out:
    settled_out: Flags,  # (n_pairs,) b1
) -> None:
    """Flag the pairs that the filter settles."""
    for i in range(pairs.shape[0]):
        nodes = pair_nodes(
            pairs[i, 0], pairs[i, 1], first_order, first_nodes, second_order, second_nodes
        )
        settled_out[i] = is_settled(first_nodes.shape[1] == 2, nodes, vertex_boxes)


@cpu_kernel
def find_contacts_after_filter(
    # Share:
    begin: int,  # i8
    end: int,  # i8
    # In:
    vertex_boxes: AnyFloats,  # (n_vertices, 9) f4
    chunks: Indices,  # (n,) i8
    pairs: Ints,  # (n_pairs, 2) i4, places
    first_order: Ints,  # (m,) i4
    first_nodes: Ints,  # (m, k) i4
    second_order: Ints,  # (m,) i4
    second_nodes: Ints,  # (m, k) i4
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    # Out:
    tallies_out: Indices,  # (n, 3) i8
    index_out: Indices,  # (n_pairs,) i8
    toi_out: Times,  # (n_pairs,) f8
    directions_out: Floats,  # (n_pairs, 3) f8
    margins_out: Floats,  # (n_pairs,) f8  [m]
) -> None:
    """Do what `find_contacts` of the CPU does, with the filter before it."""
    for k in range(begin, end):
        c = chunks[k]
        at, proofs, most = CHUNK * c, 0, 0
        for i in range(CHUNK * c, min(CHUNK * (c + 1), pairs.shape[0])):
            margins_out[i] = 0.0
            nodes = pair_nodes(
                pairs[i, 0], pairs[i, 1], first_order, first_nodes, second_order, second_nodes
            )
            if is_settled(first_nodes.shape[1] == 2, nodes, vertex_boxes):
                continue
            count, own, longest = contacts_of_pairs(
                i,
                i + 1,
                pairs,
                first_order,
                first_nodes,
                second_order,
                second_nodes,
                positions_t0,
                positions_t1,
                index_out,
                toi_out,
                directions_out,
                margins_out,
            )
            proofs, most = proofs + own, max(most, longest)
            if count:
                index_out[at], toi_out[at] = i, toi_out[i]
                for axis in range(3):
                    directions_out[at, axis] = directions_out[i, axis]
                at += 1
        tallies_out[c, 0], tallies_out[c, 1], tallies_out[c, 2] = at - CHUNK * c, proofs, most


class Filtered:
    """Takes the place of `find_contacts` in `detection/near_pairs.py`.

    Args:
        vertex_boxes: (n_vertices, 9) f4, of the path.
    """

    def __init__(self, vertex_boxes: AnyFloats) -> None:
        """Keep the boxes."""
        self._boxes = vertex_boxes

    def where_it_pays(self, least: int, items: range, *arguments: Any) -> None:
        """Run the kernel with the filter."""
        find_contacts_after_filter.where_it_pays(least, items, self._boxes, *arguments)


def path_boxes(scene: Scene, end: Positions) -> AnyFloats:
    """Return the float32 positions of the vertices of a path, as a GPU has them."""
    still = np.zeros(len(end))
    return VertexBoxes(scene.positions_t0, end, still, np.float32, scene.edges).boxes


def candidates(scene: Scene, end: Positions) -> Iterator[Candidates]:
    """Yield the vertex-face pairs and the edge-edge pairs of a path whose boxes meet."""
    detector = Detector.of_scene(scene)
    detector.find(end)
    boxes = path_boxes(scene, end)
    vertices, edges, faces = detector.elements
    yield _candidates("vertex_face", vertices, faces, scene, end, boxes)
    yield _candidates("edge_edge", edges, edges, scene, end, boxes)


def _candidates(
    kind: str, first: Elements, second: Elements, scene: Scene, end: Positions, boxes: AnyFloats
) -> Candidates:
    pairs = meeting_pairs(first, second)
    n = len(pairs)
    trees = first.tree.order, first.tree.nodes, second.tree.order, second.tree.nodes
    settled, contact = np.empty(n, bool), np.zeros(n, bool)
    flag_settled(pairs, *trees, boxes, settled)
    index, toi, directions, margins = np.empty(n, int), np.empty(n), np.empty((n, 3)), np.empty(n)
    count, _, _ = contacts_of_pairs(
        0, n, pairs, *trees, scene.positions_t0, end, index, toi, directions, margins
    )
    contact[index[:count]] = True
    return Candidates(kind, settled, contact)


def study_filter(folder: Path, say: Say, _clock: Clock) -> None:
    """Count the pairs that the filter settles, and the instructions of its kernel."""
    _instructions(folder, say)
    rows = Rows(folder, "filter", ("step", "path"))
    for name in steps.step_names():
        if rows.has(step=name, path="answer"):
            continue
        try:
            scene = steps.load_step(name)
        except InitialIntersectionError as error:
            say(f"filter: {name}: {error}")
            continue
        answer = np.ascontiguousarray(resolve(scene).positions)
        for path, end in (("proposed", scene.positions_t1), ("answer", answer)):
            if not rows.has(step=name, path=path):
                rows.add(step=name, path=path, **_counts(scene, end), **_times(scene, end))
                say(f"filter: {name}, {path}: {rows.all()[-1]['settled_of_apart']:.4f}")


def _counts(scene: Scene, end: Positions) -> dict[str, float]:
    """Count pairs, and the groups of threads that have a pair which is left open."""
    kinds = list(candidates(scene, end))
    settled = sum(int(own.settled.sum()) for own in kinds)
    contacts = sum(int(own.contact.sum()) for own in kinds)
    missed = sum(int((own.settled & own.contact).sum()) for own in kinds)
    n = sum(len(own.settled) for own in kinds)
    slow = groups = 0
    for own in kinds:
        starts = np.arange(0, len(own.settled), GROUP)
        groups += len(starts)
        if len(starts):
            slow += int(np.logical_or.reduceat(~own.settled, starts).sum())
    return {
        "pairs": n,
        "contacts": contacts,
        "settled": settled,
        "missed": missed,
        "settled_of_apart": settled / max(n - contacts, 1),
        "groups_left_open": slow / max(groups, 1),
    }


def _times(scene: Scene, end: Positions) -> dict[str, float]:
    """Measure detection on the CPU with and without the filter, in turn [CPU ms, all threads]."""
    filtered = Filtered(path_boxes(scene, end))
    without_ms: list[float] = []
    with_ms: list[float] = []
    for _ in range(PAIRS + 1):
        without_ms.append(_find_ms(scene, end))
        with patch("izo_ref.detection.near_pairs.find_contacts", filtered):
            with_ms.append(_find_ms(scene, end))
    return {
        "cpu_ms": statistics.median(without_ms[1:]),
        "cpu_filtered_ms": statistics.median(with_ms[1:]),
        "load": os.getloadavg()[0],
    }


def _find_ms(scene: Scene, end: Positions) -> float:
    detector = Detector.of_scene(scene)
    begun = time.process_time()
    detector.find(end)
    return 1e3 * (time.process_time() - begun)


def _instructions(folder: Path, say: Say) -> None:
    """Count the instructions of the filter and of the proofs in float64, and their registers."""
    rows = Rows(folder, "filter_kernels", ("kernel", "capability"))
    if ptx.ptxas() is None:
        say("filter: ptxas is not installed (package nvidia-cuda-nvcc)")
        return
    for name, kernel in ptx.kernels():
        if name not in KERNELS:
            continue
        (signature,) = ptx.signatures(kernel).values()
        for capability in ptx.CAPABILITIES:
            key = {"kernel": name, "capability": f"{capability[0]}.{capability[1]}"}
            if not rows.has(**key):
                counts = ptx.instructions(kernel, signature, capability)
                registers = ptx.build(kernel, signature, capability).registers
                rows.add(**key, **counts, registers=registers)
        say(f"filter: {name}")

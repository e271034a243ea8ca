"""Vectors of stage S1: the pairs that a broad phase must list.

The pairs that meet are found by trying all pairs in exact arithmetic. A broad phase compares boxes,
so it lists more; that is right.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

from izo_ref.base.exact_path import first_meeting
from izo_ref.porting.cases import VALID, Case
from izo_ref.porting.generate import s01_meshes
from izo_ref.porting.generate.meshes import Face, Mesh
from izo_ref.porting.reference.contact import Point


class Meeting(NamedTuple):
    """All pairs of a mesh that meet: four vertices each."""

    vertex_face: list[list[int]]
    edge_edge: list[list[int]]


def cases() -> list[Case]:
    """Return all cases of the stage."""
    numbers: Counter[str] = Counter()
    result = []
    for row in s01_meshes.rows():
        numbers[row.word] += 1
        meeting = meeting_pairs(row.mesh)
        expected: dict[str, dict[str, Any]] = {
            "vertex_face": {"judge": "superset", "kind": "vertex-face"},
            "edge_edge": {"judge": "superset", "kind": "edge-edge"},
        }
        expected["vertex_face"]["pairs"] = [i for pair in meeting.vertex_face for i in pair]
        expected["edge_edge"]["pairs"] = [i for pair in meeting.edge_edge for i in pair]
        inputs: dict[str, Any] = {
            "positions_t0": [float(x) for point in row.mesh.start for x in point],
            "positions_t1": [float(x) for point in row.mesh.end for x in point],
            "faces": [i for face in row.mesh.faces for i in face],
        }
        name = f"S1-{row.word}-{numbers[row.word]:02d}"
        head = (name, "S1", row.flags, VALID, row.grade, row.dtypes)
        result.append(Case(*head, row.what, inputs, expected))
    return result


def edges_of(faces: Sequence[Face]) -> list[tuple[int, int]]:
    """Return the edges of faces, each once, the lower vertex first, sorted."""
    sides = {tuple(sorted((f[i], f[i - 1]))) for f in faces for i in range(3)}
    return sorted((a, b) for a, b in sides)


def meeting_pairs(mesh: Mesh) -> Meeting:
    """Return all pairs without a common vertex that meet, decided exactly."""
    edges = edges_of(mesh.faces)
    vertices = [(v,) for v in range(len(mesh.start))]
    edge_pairs = [(a, b) for i, a in enumerate(edges) for b in edges[i + 1 :]]
    face_pairs = [(v, face) for v in vertices for face in mesh.faces]
    return Meeting(_meeting(mesh, False, face_pairs), _meeting(mesh, True, edge_pairs))


def _meeting(
    mesh: Mesh, is_edge_edge: bool, pairs: Sequence[tuple[tuple[int, ...], tuple[int, ...]]]
) -> list[list[int]]:
    result = []
    for first, second in pairs:
        nodes = [*first, *second]
        if len(set(nodes)) < 4 or _are_apart(mesh, first, second):
            continue
        start, end = [mesh.start[i] for i in nodes], [mesh.end[i] for i in nodes]
        if first_meeting(is_edge_edge, start, end) is not None:
            result.append(nodes)
    return result


def _are_apart(mesh: Mesh, first: tuple[int, ...], second: tuple[int, ...]) -> bool:
    """Return whether an axis separates two elements at the start and at the end, strictly.

    Then it does so in between, too, because vertices move on straight lines. Floats are compared as
    they are, so nothing is rounded.
    """
    return any(
        _below(mesh, axis, a, b) for axis in range(3) for a, b in ((first, second), (second, first))
    )


def _below(mesh: Mesh, axis: int, low: tuple[int, ...], high: tuple[int, ...]) -> bool:
    def extreme(points: Sequence[Point], nodes: tuple[int, ...], pick: Any) -> float:
        return pick(points[i][axis] for i in nodes)

    return all(extreme(x, low, max) < extreme(x, high, min) for x in (mesh.start, mesh.end))

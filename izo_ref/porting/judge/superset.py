"""Judge `superset`: every expected pair must be listed, and what is listed must be a pair."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any, TypeAlias

from izo_ref.porting.judge.outcome import Difference, Question

VERTEX_FACE, EDGE_EDGE = "vertex-face", "edge-edge"

Row: TypeAlias = "tuple[int, ...]"
Key: TypeAlias = "tuple[int, frozenset[int]] | frozenset[frozenset[int]]"


def judge_superset(question: Question) -> list[Difference]:
    """Compare lists of pairs, whatever the order of pairs, corners and ends."""
    kind = question.expected["kind"]
    inputs: Any = question.case.inputs
    mesh, n_vertices = _simplices(kind, inputs["faces"]), len(inputs["positions_t0"]) // 3
    found, listed = [], set()
    for i, row in enumerate(rows_of(question.got)):
        problem = _problem(kind, row, mesh, n_vertices)
        if problem:
            text = f"{_shown(row)} {problem}"
            found.append(question.difference(text, None, got=_shown(row))._replace(element=(i,)))
        else:
            listed.add(pair_key(kind, row))
    for i, row in enumerate(rows_of(question.expected["pairs"])):
        if pair_key(kind, row) not in listed:
            text = f"the {kind} pair {_shown(row)} meets on the path and is missing"
            found.append(question.difference(text, None, _shown(row))._replace(element=(i,)))
    return found


def rows_of(numbers: Sequence[int]) -> list[Row]:
    """Return the rows of four of a flat list."""
    return [tuple(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]


def pair_key(kind: str, row: Row) -> Key:
    """Return what two ways to write the same pair have in common."""
    if kind == VERTEX_FACE:
        return row[0], frozenset(row[1:])
    return frozenset((frozenset(row[:2]), frozenset(row[2:])))


def _simplices(kind: str, faces: Sequence[int]) -> set[frozenset[int]]:
    """Return the faces of the mesh, or its edges."""
    corners = [faces[i : i + 3] for i in range(0, len(faces), 3)]
    if kind == VERTEX_FACE:
        return {frozenset(face) for face in corners}
    return {frozenset(ends) for face in corners for ends in combinations(face, 2)}


def _problem(kind: str, row: Row, mesh: set[frozenset[int]], n_vertices: int) -> str:
    """Return why a row is no pair of the mesh, or an empty text."""
    if not all(0 <= vertex < n_vertices for vertex in row):
        return f"has an index that is no vertex; vertices are 0 to {n_vertices - 1}"
    sides = (row[:1], row[1:]) if kind == VERTEX_FACE else (row[:2], row[2:])
    if set(sides[0]) & set(sides[1]):
        return "has a common vertex of both sides"
    named = "face" if kind == VERTEX_FACE else "edge"
    for side in sides[1:] if kind == VERTEX_FACE else sides:
        if frozenset(side) not in mesh:
            return f"names {_shown(side)}, which is no {named} of the mesh"
    return ""


def _shown(row: Sequence[int]) -> str:
    return "(" + ", ".join(str(vertex) for vertex in row) + ")"

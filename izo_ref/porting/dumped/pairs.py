"""Judge which pairs a dump lists, and their times of impact.

Each coordinate of a pair may be wrong by `ROOM * eps` times the largest coordinate of the pair.
Divided by the speed at which the sides approach each other, that is the tolerance of a time.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices, Nodes
from izo_ref.base.exact_path import first_meeting
from izo_ref.base.records import Impacts
from izo_ref.porting.dumped.arrays import Rows
from izo_ref.porting.dumped.paths import (
    ROOM,
    Frame,
    Key,
    Path,
    ends,
    extent,
    keys_of,
    length,
    matches,
    name_of,
    prescribed,
)
from izo_ref.porting.dumped.report import Problem

# A time may be early by this fraction: conservative methods stop short of the contact, mostly by 10
# or 20 %. It may never be late.
EARLY = 0.25
# A pair that is listed although it does not meet may come this near, over its size: methods that
# decide conservatively stop there.
NEAR = 1e-5


def judge_candidates(path: Path, nodes: Nodes, is_edge_edge: bool) -> Problem | None:
    """Judge a list of candidate pairs: each pair that meets has to be in it."""
    kinds = np.full(len(nodes), is_edge_edge)
    for row, sentence in enumerate(_wrong_pairs(path, nodes, kinds)):
        if sentence:
            return Problem(sentence, row, tuple(nodes[row].tolist()))
    listed = set(keys_of(nodes, kinds))
    impacts = path.impacts.take(path.impacts.is_edge_edge == is_edge_edge)
    return _missed(path, impacts, listed, None)


def judge_pairs(path: Path, rows: Rows) -> Problem | None:
    """Judge which pairs are listed as impacts: all that meet, and no other."""
    keys = keys_of(rows.nodes, rows.is_edge_edge)
    twice = _first_twice(keys)
    if twice is not None:
        sentence = f"{name_of(rows.nodes[twice], rows.is_edge_edge[twice])} come twice"
        return Problem(sentence, twice, tuple(rows.nodes[twice].tolist()))
    expected = {*keys_of(path.impacts.nodes, path.impacts.is_edge_edge), *path.ignored}
    extra = [i for i, key in enumerate(keys) if key not in expected]
    skipped = prescribed(rows, path.scene.pinned)
    wrong = _wrong_pairs(path, rows.nodes, rows.is_edge_edge)
    for row in extra:
        pair, vertices = name_of(rows.nodes[row], rows.is_edge_edge[row]), rows.nodes[row].tolist()
        if wrong[row]:
            return Problem(wrong[row], row, tuple(vertices))
        if not skipped[row] and not _comes_near(path, rows, row):
            sentence = f"{pair} are listed as an impact, but do not meet on the path"
            return Problem(sentence, row, tuple(vertices), "no impact", "an impact", len(extra))
    return _missed(path, path.impacts, set(keys), rows)


def judge_times(path: Path, rows: Rows) -> Problem | None:
    """Judge times of impact: they may be a little early, and never late."""
    assert rows.toi is not None
    own, places = matches(path, rows)
    got, expected = rows.toi[own], path.impacts.toi[places]
    tolerance = _time_tolerance(path, places)
    wrong = ~((got <= expected + tolerance) & (got >= expected * (1.0 - EARLY) - tolerance))
    for i in np.flatnonzero(wrong).tolist():
        nodes, kind = rows.nodes[own[i]], bool(rows.is_edge_edge[own[i]])
        exact = first_meeting(kind, *ends(path, nodes))
        time = expected[i] if exact is None else exact
        early = got[i] < time * (1.0 - EARLY) - tolerance[i]
        if not (early or got[i] > time + tolerance[i] or np.isnan(got[i])):
            continue
        late = "is no number" if np.isnan(got[i]) else "is late: the sides have met before"
        word = f"is early by more than {EARLY:.0%}" if early else late
        sentence = f"the time of {name_of(nodes, kind)} {word}"
        texts = f"{float(time)!r} +- {tolerance[i]:.1e}", repr(float(got[i]))
        return Problem(sentence, int(own[i]), tuple(nodes.tolist()), *texts, int(wrong.sum()))
    return None


def _first_twice(keys: list[Key]) -> int | None:
    seen: set[Key] = set()
    for i, key in enumerate(keys):
        if key in seen:
            return i
        seen.add(key)
    return None


def _wrong_pairs(path: Path, nodes: Nodes, kinds: Flags) -> list[str]:
    """Return for each pair what makes it no pair of the mesh; empty for a right one."""
    faces = set(map(tuple, np.sort(path.scene.faces, axis=1).tolist()))
    edges = set(map(tuple, path.scene.edges.tolist()))
    sentences = []
    for row, kind in zip(nodes.tolist(), kinds.tolist(), strict=True):
        sentence = ""
        if len(set(row)) < 4:
            sentence = f"the two sides of {row} share a vertex"
        elif kind:
            off = [pair for pair in (row[:2], row[2:]) if tuple(sorted(pair)) not in edges]
            sentence = f"{off[0]} is no edge of the mesh" if off else ""
        elif tuple(sorted(row[1:])) not in faces:
            sentence = f"{row[1:]} is no face of the mesh"
        sentences.append(sentence)
    return sentences


def _speed(path: Path, places: Indices) -> Floats:
    """Return how fast the sides approach each other when they meet, (m,) f8 [m per step]."""
    found = path.impacts.take(places)
    start, end = ends(path, found.nodes)
    moved = np.einsum("jk,jkx->jx", found.weights, end - start)
    return np.abs(np.einsum("jx,jx->j", found.normals, moved))


def _time_tolerance(path: Path, places: Indices) -> Floats:
    """Return the tolerance of times, (m,) f8; infinite for sides that only slide along."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = extent(path, path.impacts.nodes[places]) / _speed(path, places)
    return ROOM * path.eps * (1.0 + np.where(np.isnan(ratio), 0.0, ratio))


def _comes_near(path: Path, rows: Rows, row: int) -> bool:
    """Return whether a pair that the reference does not list meets, or nearly does."""
    start, end = ends(path, rows.nodes[row])
    if first_meeting(bool(rows.is_edge_edge[row]), start, end) is not None:
        return True
    if rows.toi is None:
        return False
    frame = Frame(path, rows, np.array([row]))
    size = float(np.abs(start - start[:1]).max())
    apart = float(length(frame.between(frame.weights))[0])
    return apart <= NEAR * size + float(frame.error[0])


def _missed(path: Path, impacts: Impacts, listed: set[Key], rows: Rows | None) -> Problem | None:
    """Return the first pair that meets and is not listed, unless rounding excuses it.

    Two things excuse a pair in a list of impacts: its sides go into each other by less than the
    rounding of a coordinate; or they meet within that distance of a border of the face or of the
    edges, and the dump lists another pair there.
    """
    keys = keys_of(impacts.nodes, impacts.is_edge_edge)
    missed = [i for i, key in enumerate(keys) if key not in listed and key not in path.ignored]
    for i in missed:
        nodes, kind = impacts.nodes[i], bool(impacts.is_edge_edge[i])
        start, end = ends(path, nodes)
        exact = first_meeting(kind, start, end)
        if exact is None or (rows is not None and _is_excused(path, impacts, i, rows)):
            continue
        sentence = f"{name_of(nodes, kind)} meet at t = {exact!r} and are not listed"
        vertices = tuple(nodes.tolist())
        return Problem(sentence, None, vertices, "listed", "not listed", len(missed))
    return None


def _is_excused(path: Path, impacts: Impacts, i: int, rows: Rows) -> bool:
    """Return whether rounding excuses that a dump does not list an impact."""
    nodes = impacts.nodes[i]
    start, end = ends(path, nodes)
    error = ROOM * path.eps * float(extent(path, nodes[None])[0])
    depth = -float(impacts.normals[i] @ (impacts.weights[i] @ (end - end[:1])))
    if depth <= error:
        return True
    size = float(np.abs(start - start[:1]).max())
    border = float(np.abs(impacts.weights[i]).min()) * size
    shared = np.isin(rows.nodes, nodes).sum(axis=1)
    return border <= error and bool((shared >= 2).any())

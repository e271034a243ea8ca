"""Vectors of stage S1: every pair that meets must be listed."""

from collections import defaultdict

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.generate.meshes import Mesh
from izo_ref.porting.generate.s01 import edges_of, meeting_pairs
from izo_ref.porting.generate.s01_meshes import rows
from tests.naive.groups import moving_box_pairs
from tests.ports.own.s01 import answer
from validation.oracles.path import meets

CASES = load_cases(stages=["S1"])
OWNED = ("missed-pairs", "touching-boxes", "still-nodes", "shared-vertices", "queue-overflow")
KINDS = ("vertex_face", "edge_edge")


def pairs_in(kind, flat):
    """Return a set of pairs from four vertices each, in any order that means the same."""
    quads = np.array(flat, int).reshape(-1, 4).tolist()
    if kind == "vertex_face":
        return {(v, frozenset(face)) for v, *face in quads}
    return {frozenset((frozenset(q[:2]), frozenset(q[2:]))) for q in quads}


def mesh_of(inputs):
    start, end = (np.reshape(inputs[f"positions_t{t}"], (-1, 3)) for t in (0, 1))
    return start, end, np.reshape(inputs["faces"], (-1, 3))


def is_right(case, reply):
    """Return whether all pairs are listed that meet, and none that is not a pair of the mesh."""
    start, _, faces = mesh_of(case.inputs)
    edges = edges_of(faces.tolist())
    real = [[v, *f] for v in range(len(start)) for f in faces.tolist() if v not in f]
    two = [[*a, *b] for i, a in enumerate(edges) for b in edges[i + 1 :] if not set(a) & set(b)]
    for kind, every in zip(KINDS, (real, two), strict=True):
        listed = pairs_in(kind, reply[kind])
        needed = pairs_in(kind, case.expected[kind]["pairs"])
        if not needed <= listed <= pairs_in(kind, every):
            return False
    return True


def box_pairs(inputs, keep=lambda *_: True, shared=False):
    """Return the pairs of boxes over both ends, by brute force, of which `keep` keeps some."""
    start, end, faces = mesh_of(inputs)
    edges, vertices = edges_of(faces.tolist()), [(v,) for v in range(len(start))]
    reply = {}
    for kind, first in zip(KINDS, (vertices, edges), strict=True):
        found = []
        for i, a in enumerate(first):
            for b in edges[i + 1 :] if kind == "edge_edge" else map(tuple, faces.tolist()):
                if (set(a) & set(b) and not shared) or not keep(start, end, list(a), list(b)):
                    continue
                low = [np.minimum(start[list(n)], end[list(n)]).min(axis=0) for n in (a, b)]
                high = [np.maximum(start[list(n)], end[list(n)]).max(axis=0) for n in (a, b)]
                if (np.maximum(*low) <= np.minimum(*high)).all():
                    found += [*a, *b]
        reply[kind] = found
    return reply


def boxes_meet(points, a, b):
    low, high = np.maximum(points[a].min(0), points[b].min(0)), points[a].max(0)
    return (low <= np.minimum(high, points[b].max(0))).all()


def ends_alone(start, end, a, b):
    return boxes_meet(start, a, b) or boxes_meet(end, a, b)


def overlap_strictly(start, end, a, b):
    both = np.stack((start, end))
    low = np.maximum(both[:, a].min((0, 1)), both[:, b].min((0, 1)))
    return (low < np.minimum(both[:, a].max((0, 1)), both[:, b].max((0, 1)))).all()


def middles_overlap(start, end, a, b):
    (c, x), (d, y) = (middle_of(np.concatenate((start[n], end[n]))) for n in (a, b))
    return (abs(c - d) <= x + y).all()


def middle_of(points):
    low, high = points.min(0), points.max(0)
    return (low + high) / 2, (high - low) / 2


def velocities_overlap(start, end, a, b):
    there = start + (end - start)
    return boxes_meet(
        np.concatenate((start, there)),
        [*a, *(v + len(start) for v in a)],
        [*b, *(v + len(start) for v in b)],
    )


def both_move(start, end, a, b):
    return all((start[n] != end[n]).any() for n in (a, b))


def neighbours_left_out(inputs):
    """Leave out the pairs of faces with a common vertex, as if they could not meet."""
    faces = mesh_of(inputs)[2].tolist()
    of = defaultdict(set)
    for f in faces:
        for v in f:
            of[v] |= set(f)
    return box_pairs(inputs, lambda _, __, a, b: not set().union(*(of[v] for v in a)) & set(b))


def short_lists(inputs, room):
    """Drop the pairs of each vertex, or of each first edge, beyond the room of a list."""
    reply = answer(inputs, "f8")
    for kind, n in zip(KINDS, (1, 2), strict=True):
        count, kept = defaultdict(int), []
        for quad in np.reshape(reply[kind], (-1, 4)).tolist():
            count[tuple(quad[:n])] += 1
            kept += quad if count[tuple(quad[:n])] <= room else []
        reply[kind] = kept
    return reply


# A broad phase with each mistake.
WRONG = [
    ("missed-pairs", lambda inputs: box_pairs(inputs, ends_alone)),
    ("touching-boxes", lambda inputs: box_pairs(inputs, overlap_strictly)),
    ("touching-boxes", lambda inputs: box_pairs(inputs, middles_overlap)),
    ("touching-boxes", lambda inputs: box_pairs(inputs, velocities_overlap)),
    ("still-nodes", lambda inputs: box_pairs(inputs, both_move)),
    ("shared-vertices", neighbours_left_out),
    ("shared-vertices", lambda inputs: box_pairs(inputs, shared=True)),
    ("queue-overflow", lambda inputs: short_lists(inputs, 16)),
    ("queue-overflow", lambda inputs: short_lists(inputs, 128)),
]


def test_ids_are_unique_and_each_flag_has_three_cases_an_easy_and_a_hard_one():
    assert len({case.id for case in CASES}) == len(CASES) >= 24
    for flag in OWNED:
        grades = [case.grade for case in CASES if flag in case.flags]
        assert len(grades) >= 3, flag
        assert {"easy", "hard"} <= set(grades), flag


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_answers_pass(case):
    for dtype in case.dtypes:
        assert is_right(case, answer(case.inputs, dtype))


def test_boxes_over_both_ends_pass():
    for case in CASES:
        if len(case.inputs["faces"]) < 40:
            assert is_right(case, box_pairs(case.inputs)), case.id


@pytest.mark.parametrize(("flag", "wrong"), WRONG)
def test_a_wrong_broad_phase_fails_a_case_of_its_flag(flag, wrong):
    failed = []
    for case in CASES:
        small = len(case.inputs["faces"]) < 40 or flag == "queue-overflow"
        if flag in case.flags and small and not is_right(case, wrong(case.inputs)):
            failed.append(case.id)
    assert failed


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.word)
def test_meshes_are_free_of_intersections_at_the_start(row):
    """An edge meets a face if a vertex that moves along the edge does."""
    start, faces = row.mesh.start, row.mesh.faces
    assert meeting_pairs(Mesh(start, start, faces)) == ([], [])
    points = np.array(start, float)
    for a, b in edges_of(faces):
        for face in faces:
            if {a, b} & set(face) or not boxes_meet(points, [a, b], list(face)):
                continue
            corners = [start[v] for v in face]
            assert not meets(False, [start[a], *corners], [start[b], *corners])


def test_the_pairs_that_meet_are_those_of_an_independent_oracle():
    """The first cases have few enough pairs for the oracle to look at all of them."""
    for case in CASES:
        start, end, faces = mesh_of(case.inputs)
        if len(faces) > 8:
            continue
        edges, vertices = np.array(edges_of(faces.tolist())), np.arange(len(start))[:, None]
        for kind, a, b in zip(KINDS, (vertices, edges), (faces, edges), strict=True):
            is_edge_edge = kind == "edge_edge"
            expected = set()
            for i, j in moving_box_pairs(a, b, start, end, is_edge_edge):
                nodes = [*a[i].tolist(), *b[j].tolist()]
                if meets(is_edge_edge, start[nodes], end[nodes]):
                    expected |= pairs_in(kind, nodes)
            assert pairs_in(kind, case.expected[kind]["pairs"]) == expected, case.id

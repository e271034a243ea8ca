"""The oracle that searches all pairs of a mesh, compared with a search without its filter."""

from itertools import combinations

import numpy as np
import pytest

from tests.helpers.own_scenes import pair_times
from validation.oracles.pairs import meeting_pairs, mesh_edges
from validation.oracles.path import first_meeting

N_VERTICES, N_FACES = 9, 8


def all_meetings(start, end, faces):
    """Return {pair: first time}, with every pair decided in exact arithmetic."""
    vf = [(v, *face) for v in range(len(start)) for face in faces.tolist() if v not in face]
    edges = {tuple(sorted(pair)) for face in faces.tolist() for pair in combinations(face, 2)}
    ee = [a + b for a, b in combinations(sorted(edges), 2) if not set(a) & set(b)]
    pairs = {}
    for nodes, is_edge_edge in ((vf, False), (ee, True)):
        brackets = [first_meeting(is_edge_edge, start[list(n)], end[list(n)]) for n in nodes]
        met = [i for i, bracket in enumerate(brackets) if bracket is not None]
        times = [float(brackets[i][0]) for i in met]
        pairs |= pair_times([nodes[i] for i in met], is_edge_edge, times)
    return pairs


@pytest.mark.parametrize("kind", ["small integers", "far from the origin", "any"])
def test_the_filter_by_separating_directions_loses_no_pair(rng, kind):
    met = left_out = 0
    for _ in range(8):
        triples = np.array(list(combinations(range(N_VERTICES), 3)))
        faces = triples[rng.choice(len(triples), N_FACES, replace=False)]
        if kind == "small integers":
            start, end = rng.integers(-2, 3, (2, N_VERTICES, 3)).astype(float)
        else:
            start, end = rng.normal(size=(2, N_VERTICES, 3))
            end = start + 0.4 * end
            if kind == "far from the origin":
                start, end = start + 1e9, end + 1e9
        found = meeting_pairs(start, end, faces)
        expected = all_meetings(start, end, faces)
        pairs = pair_times(found.vertex_face, False, found.vertex_face_time)
        pairs |= pair_times(found.edge_edge, True, found.edge_edge_time)
        assert pairs == expected
        assert (found.edge_edge[:, [0, 2]] < found.edge_edge[:, [1, 3]]).all()
        n_edges = len(mesh_edges(faces))
        met += len(pairs)
        left_out += N_VERTICES * N_FACES + n_edges * (n_edges - 1) // 2 - found.decided
    assert met > 20
    assert left_out > 100


def test_a_mesh_at_rest_has_no_meeting():
    start = np.eye(4, 3)
    found = meeting_pairs(start, start, np.array([[0, 1, 2]]))
    assert found.vertex_face.shape == found.edge_edge.shape == (0, 4)

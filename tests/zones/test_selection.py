"""Which impacts are taken into account next."""

import numpy as np
import pytest

from izo_ref.base.records import Impacts, join_impacts
from izo_ref.zones.selection import find_deep_impacts, select_impacts
from izo_ref.zones.serial.deep_selection import (
    DEEP,
    DEEP_EDGES,
    SHALLOW,
    SOON,
    UNDECIDED,
    relative_depths,
)
from izo_ref.zones.serial.selection import hopeful_impacts
from tests.naive import groups


def random_impacts(rng, n, k):
    """Draw n impacts of k vertices, many of them at equal times."""
    nodes = np.array([rng.choice(k, 4, replace=False) for _ in range(n)], np.int32).reshape(-1, 4)
    toi = rng.integers(0, 6, n) / 6.0
    return Impacts(nodes, np.zeros(n, bool), toi, np.zeros((n, 4)), np.zeros((n, 3)))


@pytest.mark.parametrize("n", [0, 1, 5, 40])
def test_selections_are_those_of_the_literal_definitions(rng, n):
    for _ in range(20):
        impacts = random_impacts(rng, n, 12)
        pinned = rng.random(12) < 0.3
        usable = impacts.take(~pinned[impacts.nodes].all(axis=1))
        for name, naive in (
            ("independent", groups.independent),
            ("first-of-any", groups.first_of_any),
        ):
            chosen = select_impacts(usable, pinned, name)
            assert np.flatnonzero(chosen).tolist() == naive(usable.toi, usable.nodes, pinned)
        assert select_impacts(usable, pinned, "all").all()


def weighted_impacts(rng, n, k):
    """Draw n impacts of k vertices with weights of vertex-face and edge-edge pairs.

    Half of the weights are quarters, so that many are equal and some are zero.
    """
    drawn = random_impacts(rng, n, k)
    kinds, inside = rng.random(n) < 0.5, rng.dirichlet([1.0, 1.0, 1.0], n)
    inside[::2] = rng.multinomial(4, [1 / 3, 1 / 3, 1 / 3], n)[::2] / 4.0
    faces = np.column_stack((np.ones(n), -inside))
    edges = np.column_stack((inside[:, 0], 1.0 - inside[:, 0], -inside[:, 1], inside[:, 1] - 1.0))
    weights = np.where(kinds[:, None], edges, faces)
    return drawn._replace(is_edge_edge=kinds, toi=(1.0 + drawn.toi) / 2.0, weights=weights)


@pytest.mark.parametrize("n", [0, 1, 5, 40])
def test_the_selection_in_deep_zones_is_that_of_the_literal_definition(rng, n):
    for _ in range(20):
        impacts, pinned = weighted_impacts(rng, n, 16), rng.random(16) < 0.3
        unpinned = (np.abs(impacts.weights) * ~pinned[impacts.nodes]).sum(axis=1)
        usable = impacts.take(unpinned > 0.0)  # the others are between pinned points
        deep = np.ones(len(usable.toi), bool)
        chosen = select_impacts(usable, pinned, "independent", deep)
        own = usable.toi, usable.nodes, usable.weights, usable.is_edge_edge, pinned
        assert np.flatnonzero(chosen).tolist() == groups.first_of_main_vertices(*own, SOON)
        assert chosen.any() == (len(usable.toi) > 0)
        for name in ("first-of-any", "all"):  # what is asked for by name is taken
            same = select_impacts(usable, pinned, name)
            assert np.array_equal(select_impacts(usable, pinned, name, deep), same)


def test_deep_zones_and_others_are_selected_apart(rng):
    """The impacts of the vertices 0..11 are deep, those of the vertices 12..23 are not."""
    for _ in range(20):
        lower, upper = weighted_impacts(rng, 25, 12), weighted_impacts(rng, 30, 12)
        upper = upper._replace(nodes=upper.nodes + np.int32(12))
        both = join_impacts((lower, upper))
        order, pinned = rng.permutation(55), np.zeros(24, bool)
        mixed = Impacts._make(column[order] for column in both)
        deep = mixed.nodes.max(axis=1) < 12
        chosen = select_impacts(mixed, pinned, "independent", deep)
        alone = select_impacts(mixed.take(deep), pinned, "independent", deep[deep])
        assert np.array_equal(chosen[deep], alone)
        alone = select_impacts(mixed.take(~deep), pinned, "independent")
        assert np.array_equal(chosen[~deep], alone)


class Scene:
    """The part of a scene that the selection reads."""

    def __init__(self, positions_t0, pinned=None):
        self.positions_t0 = positions_t0
        self.pinned = np.zeros(len(positions_t0), bool) if pinned is None else pinned


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_a_zone_is_deep_if_its_impacts_are_deeper_than_edges_on_average(is_edge_edge):
    """The longest edge has a length of 2 m: a side of the face, or the second edge."""
    start = np.array([[0.0, 0, 1], [0, 0, 0], [2, 0, 0], [0, 1, 0]])
    weights = np.array([1.0, -0.5, -0.25, -0.25])
    if is_edge_edge:
        start = np.array([[0.0, 0, 1], [1, 0, 1], [0, 0, 0], [0, 2, 0]])
        weights = np.array([0.5, 0.5, -0.5, -0.5])
    impacts = Impacts(
        np.tile(np.arange(4, dtype=np.int32), (2, 1)),
        np.full(2, is_edge_edge),
        np.full(2, 0.5),
        np.tile(weights, (2, 1)),
        np.array([[0.0, 0, 1], [0, 0, 1]]),
    )
    longest = 2.0 if is_edge_edge else np.sqrt(5.0)
    upper = 2 if is_edge_edge else 1
    for depth, deep in ((0.99 * DEEP_EDGES * longest, False), (1.01 * DEEP_EDGES * longest, True)):
        end, known = start.copy(), np.zeros(4, np.int32)
        end[:upper, 2] = -depth
        assert (find_deep_impacts(Scene(start), impacts, end, known) == deep).all()
        assert (known == (DEEP if deep else SHALLOW)).all()
        mixed = impacts._replace(normals=np.array([[0.0, 0, 1], [0, 0, 0]]))
        known[:] = UNDECIDED
        assert not find_deep_impacts(Scene(start), mixed, end, known).any()
    none = impacts.take(np.zeros(2, bool))
    assert len(find_deep_impacts(Scene(start), none, start, known)) == 0


def columns_of_vertices(depths):
    """Return impacts of vertices that fall through faces of their own, and their two positions."""
    n = len(depths)
    start = np.tile([[0.0, 0, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0]], (n, 1))
    end = start.copy()
    end[::4, 2] = -np.array(depths)
    impacts = Impacts(
        np.arange(4 * n, dtype=np.int32).reshape(n, 4),
        np.zeros(n, bool),
        np.full(n, 0.5),
        np.tile([1.0, -0.5, -0.25, -0.25], (n, 1)),
        np.tile([0.0, 0, 1], (n, 1)),
    )
    return impacts, start, end


def test_whether_a_zone_is_deep_depends_on_its_own_impacts():
    impacts, start, end = columns_of_vertices([100.0, 0.1, 0.1, 100.0])
    known = np.zeros(16, np.int32)
    deep = find_deep_impacts(Scene(start), impacts, end, known)
    assert deep.tolist() == [True, False, False, True]
    assert known.tolist() == np.repeat([DEEP, SHALLOW, SHALLOW, DEEP], 4).tolist()


def test_what_was_decided_of_a_vertex_holds_and_a_deep_zone_makes_others_deep():
    impacts, start, end = columns_of_vertices([100.0, 0.1, 0.1])
    known = np.zeros(12, np.int32)
    find_deep_impacts(Scene(start), impacts, end, known)
    shallow = end.copy()
    shallow[::4, 2] = [-0.1, -100.0, -0.1]  # the first two change places
    assert find_deep_impacts(Scene(start), impacts, shallow, known).tolist() == [True, False, False]
    impacts.nodes[2] = [0, 5, 6, 7]  # joins the first two zones
    assert find_deep_impacts(Scene(start), impacts, end, known).all()
    assert (known[:8] == DEEP).all()


def test_a_pinned_vertex_joins_no_zones_and_keeps_nothing():
    impacts, start, end = columns_of_vertices([100.0, 0.1])
    impacts.nodes[1, 3] = impacts.nodes[0, 3]
    pinned = np.arange(8) == 3
    known = np.zeros(8, np.int32)
    deep = find_deep_impacts(Scene(start, pinned), impacts, end, known)
    assert deep.tolist() == [True, False]
    assert known[3] == UNDECIDED


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_the_depth_is_the_frozen_gap_over_the_longest_edge(rng, is_edge_edge):
    impacts = weighted_impacts(rng, 30, 12)
    start, end, normals = rng.normal(size=(12, 3)), rng.normal(size=(12, 3)), np.empty((30, 3))
    normals[:] = rng.normal(size=(30, 3))
    own = impacts._replace(is_edge_edge=np.full(30, is_edge_edge), normals=normals)
    depths = []
    for nodes, weights, normal in zip(own.nodes, own.weights, normals, strict=True):
        gap = normal @ (weights @ end[nodes])
        corners = start[nodes]
        face = [corners[1] - corners[2], corners[2] - corners[3], corners[3] - corners[1]]
        edges = [corners[0] - corners[1], corners[2] - corners[3]] if is_edge_edge else face
        depths.append(-gap / max(np.linalg.norm(edge) for edge in edges))
    columns = own.nodes, own.is_edge_edge, own.weights, own.normals
    found = np.empty(30)
    relative_depths(start, end, *columns, found)
    np.testing.assert_allclose(found, depths, rtol=0.0, atol=1e-12)


def test_an_impact_is_hopeful_if_its_gap_is_too_small_and_no_vertex_is_stuck(rng):
    """A zone that was solved leaves 1e-9 of the thickness, which no solver can mend."""
    impacts = weighted_impacts(rng, 300, 12)
    normals, positions = rng.normal(size=(300, 3)), rng.normal(size=(12, 3))
    stuck = rng.random(12) < 0.05
    gaps = np.einsum("jx,jk,jkx->j", normals, impacts.weights, positions[impacts.nodes])
    found = np.empty(300, bool)
    own = impacts.nodes, impacts.weights, normals
    hopeful_impacts(positions, *own, stuck, 0.5, found)
    np.testing.assert_array_equal(found, (gaps < 0.5) & ~stuck[impacts.nodes].any(axis=1))
    assert 50 < found.sum() < 250
    over = np.array([[0.0, 0, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0]])
    rows = np.arange(4, dtype=np.int32)[None], np.array([[1.0, -0.5, -0.25, -0.25]])
    for missing, expected in ((1e-5, True), (1e-8, False), (-1e-5, False)):
        up = np.array([[0.0, 0.0, 1.0]])
        hopeful_impacts(over, *rows, up, np.zeros(4, bool), 1.0 + missing, found[:1])
        assert found[0] == expected

"""The order of constraints along a zone, and the envelope of the active ones, by slow rules."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.envelope import SIDE
from izo_ref.solvers.serial.group_memory import index_size, memory_of, vector_size
from izo_ref.solvers.serial.group_order import PLACES, number_active, order_constraints
from izo_ref.solvers.serial.group_zone import Zone, link_entries

FIRST = 3  # unknown of the zone


def random_case(rng, n, n_vertices, sizes):
    """Return a zone of neighbouring vertices in a box, some of them pinned, and its work space."""
    positions = rng.uniform(-1.0, 1.0, (n_vertices, 3)) * sizes
    begins = rng.integers(0, n_vertices - 3, n)
    nodes = np.array([rng.permutation(4) + begin for begin in begins]) + FIRST
    nodes = np.where(rng.random((n, 4)) < 0.4, -1, nodes).astype(np.int32)
    heads, chain = np.full(n_vertices, -7, np.int32), np.full(4 * n, -7, np.int32)
    zone = Zone(ALONE, FIRST, nodes, np.zeros((n, 4)), np.zeros((n, 3)), np.zeros(n), heads, chain)
    link_entries(zone)
    numbers = np.full(vector_size(n, n_vertices), np.nan)
    indices = np.full(index_size(n, n_vertices), -7, np.int32)
    order_constraints(zone, positions, memory := memory_of(n, n_vertices, numbers, indices))
    return zone, positions, memory


def neighbours(zone, j):
    """Return the constraints that share a vertex with one, and itself."""
    own = set(zone.nodes[j]) - {-1}
    return [i for i in range(len(zone.nodes)) if i == j or own & set(zone.nodes[i])]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_constraints_are_ordered_along_the_longest_axis(rng, axis):
    for n in (5, 8, 9, 40, 100):
        zone, positions, memory = random_case(rng, n, n + 3, np.roll([9.0, 0.3, 1.0], axis))
        assert np.ptp(positions, axis=0).argmax() == axis
        along = positions[:, axis] - positions[:, axis].min()
        places = np.zeros(n)  # of constraints without an unpinned vertex
        for j, nodes in enumerate(zone.nodes):
            if (nodes >= 0).any():
                places[j] = along[nodes[nodes >= 0] - FIRST].mean() * PLACES / along.max()
        assert sorted(memory.order) == list(range(n))
        assert (np.diff(places[memory.order]) > -1.1).all(), "one place, and its rounding"
        ranks = np.argsort(memory.order)
        for j in range(n):
            assert memory.lowest[j] == min(neighbours(zone, j), key=lambda i: ranks[i])


def test_constraints_at_one_place_keep_their_order(rng):
    _, _, memory = random_case(rng, 50, 30, 0.0)
    assert memory.order.tolist() == list(range(50))


@pytest.mark.parametrize("share", [0.0, 0.2, 0.4, 0.6, 1.0])
def test_active_constraints_are_numbered_in_the_order(rng, share):
    n = 6 * SIDE + 3
    for _ in range(4):
        zone, _, memory = random_case(rng, n, 2 * n, [1.0, 1.0, 9.0])
        memory.is_active[:] = rng.random(n) < share
        envelope = number_active(zone, memory)
        active = [j for j in memory.order if memory.is_active[j]]
        assert memory.active[: len(active)].tolist() == active
        counts = np.cumsum(memory.is_active[memory.order]) - memory.is_active[memory.order]
        before = dict(zip(memory.order, counts, strict=True))
        assert (envelope.n_rows, envelope.n) == (len(active), -(-len(active) // SIDE))
        for j in range(n):
            assert memory.places[j] == (before[j] if memory.is_active[j] else -1 - before[j])
        needed = [min(before[i] for i in neighbours(zone, j)) // SIDE for j in active]
        for i in range(envelope.n):
            assert envelope.firsts[i] == min([*needed[SIDE * i :], i])

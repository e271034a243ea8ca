"""Exchanges by a thread group, compared with a slow rule, on one thread."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.exchange_rules import RHO
from izo_ref.solvers.serial.group_exchange import exchange, flag_wrong
from izo_ref.solvers.serial.group_memory import index_size, memory_of, vector_size
from izo_ref.solvers.serial.group_zone import Zone, link_entries

SLOP = 0.25


def random_case(rng, n, n_vertices):
    """Return a zone of random vertices, some of them pinned, and its work space.

    Multipliers and violations are small integers, so that many are equal.
    """
    first = int(rng.choice([0, 3]))
    nodes = np.array([rng.choice(n_vertices, 4, replace=False) for _ in range(n)]) + first
    nodes = np.where(rng.random((n, 4)) < 0.4, -1, nodes).astype(np.int32)
    heads, chain = np.full(n_vertices, -7, np.int32), np.full(4 * n, -7, np.int32)
    numbers = np.full(vector_size(n, n_vertices), np.nan)
    indices = np.full(index_size(n, n_vertices), -7, np.int32)
    rhs, memory = rng.integers(-2, 3, n).astype(float), memory_of(n, n_vertices, numbers, indices)
    zone = Zone(ALONE, first, nodes, np.zeros((n, 4)), np.zeros((n, 3)), rhs, heads, chain)
    link_entries(zone)
    memory.u[:], memory.products[:] = rng.integers(-2, 3, (2, n))
    memory.earlier[:] = rng.integers(0, 2, n) / RHO
    memory.is_active[:] = rng.integers(0, 2, n)
    return zone, memory


def test_constraints_on_the_wrong_side_are_flagged(rng):
    for _ in range(20):
        zone, memory = random_case(rng, int(rng.integers(1, 30)), 9)
        for violation in (SLOP, SLOP + 0.01):  # the first inactive one is just not violated
            memory.products[0], memory.earlier[0] = zone.rhs[0] - violation, 0.0
            is_violated = memory.products - RHO * memory.earlier < zone.rhs - SLOP
            expected = np.where(memory.is_active == 1, memory.u < 0.0, is_violated)
            assert flag_wrong(zone, memory, SLOP) == np.count_nonzero(expected)
            assert np.array_equal(memory.is_wrong, expected)


@pytest.mark.parametrize("first_only", [False, True])
@pytest.mark.parametrize("by_distance", [False, True])
def test_constraints_that_come_first_at_their_vertices_change_sides(rng, first_only, by_distance):
    n_waiting = 0
    for _ in range(20):
        n = int(rng.integers(1, 30))
        zone, memory = random_case(rng, n, int(rng.integers(4, 40)))
        flag_wrong(zone, memory, SLOP)
        is_active = memory.is_active.copy()
        off = np.where(is_active == 1, -memory.u, zone.rhs - memory.products) * by_distance
        for j in np.flatnonzero(memory.is_wrong):
            beside = [i for i in range(n) if set(zone.nodes[i]) & set(zone.nodes[j]) - {-1}]
            ranks = [(off[i], i) for i in beside if memory.is_wrong[i]]
            changes = not first_only or (off[j], j) == max(ranks, default=(off[j], j))
            is_active[j] = is_active[j] != changes
            n_waiting += not changes
        exchange(zone, memory, first_only, by_distance)
        assert np.array_equal(memory.is_active, is_active)
    assert (n_waiting > 0) == first_only

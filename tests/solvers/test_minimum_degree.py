"""The order of elimination: it is complete and causes little fill."""

import numpy as np
import pytest

from izo_ref.solvers.serial.elimination import (
    elimination_tree,
    factor_structure,
    graph_of,
    postorder,
)
from izo_ref.solvers.serial.minimum_degree import minimum_degree


def order_of(entries, n):
    """Return the order of elimination, and check that it contains each unknown once."""
    order = minimum_degree(*graph_of(entries, n))
    assert sorted(order.tolist()) == list(range(n))
    return order


def fill(entries, n, order):
    """Count the entries of the factor below its diagonal."""
    position = np.argsort(order)
    graph = graph_of(position[entries], n)
    starts, _ = factor_structure(*graph, elimination_tree(*graph))
    return starts[-1]


def fill_by_exact_degrees(entries, n):
    """Count them where the unknown of least exact degree goes first, ties by number, on sets."""
    neighbours = [set() for _ in range(n)]
    for i, j in entries[entries[:, 0] != entries[:, 1]].tolist():
        neighbours[i].add(j)
        neighbours[j].add(i)
    left, total = set(range(n)), 0
    while left:
        pivot = min(left, key=lambda i: (len(neighbours[i]), i))
        left.remove(pivot)
        around = neighbours[pivot]
        total += len(around)
        for i in around:
            neighbours[i] |= around
            neighbours[i] -= {i, pivot}
    return total


def random_entries(rng, n, n_entries):
    """Draw different pairs of unknowns, at most `n_entries` of them."""
    pairs = np.sort(rng.integers(n, size=(n_entries, 2)), axis=1)
    return np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)


def grid(k):
    """Return the entries of a k x k grid, each unknown linked to its four neighbours."""
    number = np.arange(k * k).reshape(k, k)
    right = np.column_stack((number[:, :-1].ravel(), number[:, 1:].ravel()))
    return np.concatenate((right, np.column_stack((number[:-1].ravel(), number[1:].ravel()))))


def test_trees_have_no_fill(rng):
    n = 200
    parents = [int(rng.integers(i)) for i in range(1, n)]
    entries = np.column_stack((parents, np.arange(1, n)))
    entries = rng.permutation(n)[entries]
    assert fill(entries, n, order_of(entries, n)) == n - 1


def test_a_clique_with_leaves_has_no_fill(rng):
    clique = np.column_stack(np.triu_indices(20, 1))
    leaves = np.column_stack((np.arange(20), 20 + np.arange(20)))
    entries = np.concatenate((clique, leaves))
    assert fill(entries, 40, order_of(entries, 40)) == len(entries)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_graph_without_edges_is_ordered(n):
    order_of(np.zeros((0, 2), np.int64), n)


@pytest.mark.parametrize("density", [1, 2, 4, 10])
def test_random_graphs_fill_as_little_as_by_exact_degrees(rng, density):
    """Ties and the bound of the degree change the fill in both directions.

    Over 20 graphs together, the fill is at most a twentieth larger.
    """
    found = exact = 0
    for _ in range(20):
        n = int(rng.integers(20, 120))
        entries = random_entries(rng, n, density * n)
        found += fill(entries, n, order_of(entries, n))
        exact += fill_by_exact_degrees(entries, n)
    assert found <= 1.05 * exact


def test_a_grid_fills_as_little_as_by_exact_degrees(rng):
    entries = grid(30)
    found, exact = fill(entries, 900, order_of(entries, 900)), fill_by_exact_degrees(entries, 900)
    assert found <= 1.1 * exact


def test_a_postorder_has_the_same_fill(rng):
    entries = random_entries(rng, 80, 240)
    order = order_of(entries, 80)
    position = np.argsort(order)
    after = order[postorder(elimination_tree(*graph_of(position[entries], 80)))]
    assert fill(entries, 80, after) == fill(entries, 80, order)

"""Gaps and margins of a pair, against the definition in numpy."""

import itertools

import numpy as np
import pytest

from izo_ref.detection.formulas.margin import (
    MARGIN_SHARE,
    START_SHARE,
    _gap_at,
    _slack,
    axes_margin,
    cubic_margin,
    margin_along,
)

ERROR = 1e-14


def draw(rng):
    """Draw nodes 1 to 3 relative to node 0, at the start and at the end."""
    a, b = rng.normal(size=(2, 3, 3)) + rng.normal(size=3)
    return a, b, [tuple(row) for row in (*a.tolist(), *b.tolist())]


def gap(is_edge_edge, n, nodes):
    """Return the smallest gap along n from a node of the second side to one of the first."""
    along = np.concatenate(([0.0], nodes @ n))
    first = 2 if is_edge_edge else 1
    return along[:first].min() - along[first:].max()


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_gaps_and_margins_of_a_direction_are_those_of_its_nodes(rng, is_edge_edge):
    positive = 0
    for _ in range(300):
        a, b, rows = draw(rng)
        n = rng.normal(size=3)
        begin, end = np.sort(rng.choice([0.0, 1.0, *rng.random(2)], 2, replace=False)).tolist()
        slacks = []
        for t in (begin, end):
            expected = gap(is_edge_edge, n, (1.0 - t) * a + t * b)
            assert _gap_at(is_edge_edge, tuple(n), *rows, t) == pytest.approx(expected, abs=1e-13)
            slacks.append(expected - ERROR * np.abs(n).sum())
        slacks[0] *= START_SHARE if begin == 0.0 else 1.0
        expected = max(0.0, MARGIN_SHARE * min(slacks) / np.abs(n).sum())
        found = margin_along(is_edge_edge, tuple(n), *rows, begin, end, ERROR)
        assert found == pytest.approx(expected, abs=1e-7)
        positive += expected > 0.0
    assert positive > 20


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_the_margin_of_axes_is_the_largest_of_all_directions(rng, is_edge_edge):
    """The diagonals are asked only if no axis separates the sides on the whole path."""
    diagonals = set()
    for i, j in itertools.combinations(range(3), 2):
        for sign in (1.0, -1.0):
            n = np.zeros(3)
            n[i], n[j] = 1.0, sign
            diagonals.add(tuple(n))
    kinds = [0, 0, 0]
    for _ in range(1000):
        a, b, rows = draw(rng)

        def slack(n, a=a, b=b):
            """Return the slack of a direction or of its opposite; the start counts for more."""
            return max(
                min(
                    START_SHARE * (gap(is_edge_edge, s * n, a) - ERROR * np.abs(n).sum()),
                    gap(is_edge_edge, s * n, b) - ERROR * np.abs(n).sum(),
                )
                for s in (1.0, -1.0)
            )

        expected = MARGIN_SHARE * max(slack(n) for n in np.eye(3))
        kind = 0
        if expected <= 0.0:
            expected = 0.5 * MARGIN_SHARE * max(slack(np.array(n)) for n in diagonals)
            kind = 1 if expected > 0.0 else 2
        kinds[kind] += 1
        found = axes_margin(is_edge_edge, *rows, ERROR)
        if kind == 2:
            assert found <= 0.0
        else:
            assert found == pytest.approx(expected, rel=1e-9, abs=1e-7)
        n = np.eye(3)[rng.integers(3)]
        along = (*(a @ n).tolist(), *(b @ n).tolist())
        assert _slack(is_edge_edge, *along, ERROR) == pytest.approx(slack(n), rel=1e-9, abs=1e-7)
    assert min(kinds) > 20


def test_a_cubic_keeps_its_sign_within_its_margin(rng):
    """The determinant at any time changes by less than it is, for changes of the columns."""
    positive = 0
    for _ in range(500):
        m = rng.uniform(0.05, 1.0, 3)
        low = 10.0 ** rng.uniform(-6, 0.5)
        margin = cubic_margin(low, *m.tolist())
        assert 0.0 <= margin <= 2.0**-4
        grown = m + 2.0 * margin
        # six products, of which one column after the other changes by at most twice the margin
        change = 12.0 * margin * (grown[1] * grown[2] + grown[0] * grown[2] + grown[0] * grown[1])
        assert change < low
        if margin == 2.0**-4:
            continue
        positive += 1
        grown = m + 0.125
        change = 12.0 * margin * (grown[1] * grown[2] + grown[0] * grown[2] + grown[0] * grown[1])
        assert change > (1.0 - 1e-6) * low - 1e-12
    assert positive > 100
    assert cubic_margin(1e-15, 1.0, 1.0, 1.0) == 0.0

"""The exact oracle of single pairs on a path."""

from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from flint import ctx, fmpz_poly

from tests.helpers.path_cases import CASES, MISS
from tests.helpers.queries import SOURCES, queries_of
from tests.naive.closest import distance
from tests.naive.simplices import simplices_meet
from validation.oracles.path import _real_roots, first_meeting, meets


@pytest.mark.parametrize("name", CASES)
def test_cases_worked_out_by_hand(name):
    pair, expected = CASES[name]
    assert meets(*pair) is (expected is not MISS)
    bracket = first_meeting(*pair)
    assert (bracket is None) is (expected is MISS)
    if isinstance(expected, float):
        assert float(bracket[0]) == pytest.approx(expected, rel=1e-15)
    elif expected is not MISS and expected is not True:
        assert bracket[0] <= expected <= bracket[1]
    for same in variants(*pair):
        assert meets(*same) is (expected is not MISS)


def variants(is_edge_edge, start, end):
    """Yield equivalent pairs; every change is exact for every float."""
    start, end = np.array(start, float), np.array(end, float)
    if is_edge_edge:
        orders = [[1, 0, 2, 3], [0, 1, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]]
    else:
        orders = [[0, *order] for order in permutations((1, 2, 3))]
    for order in orders:
        yield is_edge_edge, start[order], end[order]
    yield is_edge_edge, end, start
    yield is_edge_edge, start[:, [1, 2, 0]], end[:, [1, 2, 0]]
    yield is_edge_edge, start * (1, 1, -1), end * (1, 1, -1)


def small_pairs(rng, count):
    """Draw pairs with small integers; in half of them some axes are flat, so that many meet."""
    for i in range(count):
        size = int(rng.integers(1, 5))
        start, end = rng.integers(-size, size + 1, (2, 4, 3)).astype(float)
        flat = rng.integers(0, 3) if i % 2 else 0
        start[:, 3 - flat :] = end[:, 3 - flat :] = 0.0
        if i % 5 == 0:  # one node follows another one
            a, b = rng.choice(4, 2, replace=False)
            start[a], end[a] = start[b] + rng.integers(0, 2), end[b]
        yield bool(rng.integers(2)), start, end


def test_equivalent_pairs_get_the_same_answer(rng):
    answers = set()
    for is_edge_edge, start, end in small_pairs(rng, 300):
        expected = meets(is_edge_edge, start, end)
        answers.add((is_edge_edge, expected))
        for same in variants(is_edge_edge, start, end):
            assert meets(*same) is expected
        for scale in (2.0**-1074, 2.0**1000):
            assert meets(is_edge_edge, scale * start, scale * end) is expected
        shift, drift = rng.integers(-(2**40), 2**40, (2, 3)).astype(float)
        assert meets(is_edge_edge, start + shift, end + shift) is expected
        assert meets(is_edge_edge, start, end + drift) is meets(is_edge_edge, start - drift, end)
    assert len(answers) == 4


def sides(is_edge_edge, start, end, time):
    """Return both sides at a rational time, times its denominator, so that they are integers."""
    n, d = time.numerator, time.denominator
    nodes = (d - n) * np.asarray(start) + n * np.asarray(end)
    split = 2 if is_edge_edge else 1
    return nodes[:split], nodes[split:]


def test_hulls_at_rational_times_agree(rng):
    seen = {"never": 0, "exact": 0, "irrational": 0}
    for pair in small_pairs(rng, 200):
        bracket = first_meeting(*pair)
        for time in (Fraction(k, 16) for k in range(17)):
            if bracket is None or time < bracket[0]:
                assert not simplices_meet(*sides(*pair, time))
        if bracket is None:
            seen["never"] += 1
            continue
        simple = ((bracket[0] + bracket[1]) / 2).limit_denominator(10**5)
        if bracket[0] <= simple <= bracket[1]:
            assert simplices_meet(*sides(*pair, simple))
            seen["exact"] += 1
        else:
            assert distance(*pair, float(bracket[0])) < 1e-14
            seen["irrational"] += 1
    assert min(seen.values()) >= 5, seen


def test_brackets_hold_the_roots_that_another_method_finds(rng):
    found = 0
    for i in range(300):
        bits = (2, 8, 40)[i % 3]
        a, b, c, d = (int(value) for value in rng.integers(-(2**bits), 2**bits, 4))
        near_double = fmpz_poly([-a, b]) * fmpz_poly([-a, b]) * fmpz_poly([c, d]) + 1
        for polynomial in (fmpz_poly([a, b, c, d]), fmpz_poly([a, b, c]), near_double):
            for factor, _ in polynomial.factor()[1]:
                brackets = sorted(_real_roots(factor), key=lambda root: root.low)
                with ctx.workprec(256):
                    roots = [root.real for root, _ in factor.complex_roots() if root.imag == 0]
                expected = sorted(root for root in roots if 0 <= root.mid() <= 1)
                assert len(brackets) == len(expected)
                for bracket, root in zip(brackets, expected, strict=True):
                    assert not root < bracket.low  # a comparison of balls is true if certain
                    assert not root > bracket.high
                found += len(brackets)
    assert found > 200


@pytest.mark.parametrize(
    "wrong", [np.zeros((3, 3)), np.full((4, 3), np.nan), np.full((4, 3), np.inf)]
)
def test_malformed_pairs_are_refused(wrong):
    with pytest.raises(ValueError, match=r"finite and of shape \(4, 3\)"):
        meets(True, wrong, wrong)


@pytest.mark.parametrize("source", SOURCES)
def test_queries_with_a_known_answer_get_that_answer(source, rng):
    queries = queries_of(source, rng)
    pairs = zip(queries.is_edge_edge, queries.vertices, strict=True)
    answers = np.array([meets(bool(is_ee), v[:4], v[4:]) for is_ee, v in pairs])
    assert [queries.names[i] for i in np.flatnonzero(answers != queries.truth)] == []

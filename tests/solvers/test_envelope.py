"""Cholesky factors in an envelope of tiles: one thread here, several in tests/simulated."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.envelope import (
    AREA,
    MOST_TILES,
    SIDE,
    Envelope,
    complete,
    count_tiles,
    dense_tiles,
    factorize,
    fits,
    size_of,
    tile_at,
)
from izo_ref.solvers.serial.envelope_solve import solve


def envelope_of(matrix):
    """Return the envelope of a matrix, and its lower triangle in tiles."""
    n, tiles = len(matrix), count_tiles(len(matrix))
    own = (np.full(tiles + k, -7, np.int32) for k in (0, 0, 1))
    envelope = Envelope(n, tiles, *own)
    for i in range(tiles):
        rows = matrix[SIDE * i : SIDE * (i + 1)]
        envelope.firsts[i] = min(rows.any(axis=0).argmax() // SIDE, i)
    complete(envelope)
    a = np.zeros(size_of(envelope))
    for row, column in np.argwhere(np.tril(matrix)):
        a[place(envelope, row, column)] = matrix[row, column]
    return envelope, a


def place(envelope, row, column):
    """Return where an entry is."""
    at = tile_at(envelope, row // SIDE, column // SIDE)
    return at + SIDE * (column % SIDE) + row % SIDE


def banded(rng, n, width):
    """Return a positive definite matrix whose rows reach `width` entries to the left at most."""
    rows = np.tril(rng.normal(size=(n, n))) + 2.0 * min(n, width + 1) * np.eye(n)
    return np.triu(rows, -width) @ np.triu(rows, -width).T


@pytest.mark.parametrize("n", [0, 1, 2, 15, 16, 17, 40, 130])
@pytest.mark.parametrize("width", [0, 1, 20, 1000])
def test_solves_have_the_residuals_of_a_stable_method(rng, n, width):
    matrix, right = banded(rng, n, width), rng.normal(size=n)
    envelope, a = envelope_of(matrix)
    assert (len(a) == AREA * dense_tiles(n)) or width < 1000
    whole = SIDE * envelope.n
    scales, x = np.full(whole, np.nan), np.zeros(whole)
    x[:n] = right
    factorize(ALONE, envelope, a, scales)
    solve(ALONE, envelope, a, scales, x)
    # Higham, theorem 10.4: the residual is at most 4 n (3 n + 1) u |R^T| |R| |x|, to first order.
    factor = np.diag(1.0 / scales[:n])
    for row in range(n):
        for column in range(SIDE * envelope.firsts[row // SIDE], row):
            factor[row, column] = a[place(envelope, row, column)]
    bound = 4 * n * (3 * n + 1) * 2.0**-53 * np.abs(factor) @ np.abs(factor.T) @ np.abs(x[:n])
    assert (np.abs(matrix @ x[:n] - right) <= bound).all()
    assert not x[n:].any()
    # Theorem 10.3: n + 1 roundings, to first order. The product here has n more. A division by the
    # root is a product with its reciprocal, and the diagonal is a reciprocal: three more each.
    bound = (2 * n + 7) * 2.0**-53 * np.abs(factor) @ np.abs(factor.T)
    assert (np.abs(factor @ factor.T - matrix) <= bound).all()


def test_a_pivot_that_is_not_positive_leaves_its_unknown_out():
    matrix = np.array([[4.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 9.0]])
    envelope, a = envelope_of(matrix)
    scales, x = np.full(SIDE, np.nan), np.zeros(SIDE)
    x[:3] = 8.0, 4.0, 18.0
    factorize(ALONE, envelope, a, scales)
    assert scales[:3].tolist() == [0.5, 0.0, 1.0 / 3.0]
    assert not scales[3:].any()
    solve(ALONE, envelope, a, scales, x)
    assert x[:3].tolist() == [2.0, 0.0, 2.0]


def test_an_envelope_never_begins_before_the_row_above(rng):
    for _ in range(50):
        tiles = int(rng.integers(1, 12))
        needed = np.array([rng.integers(0, i + 1) for i in range(tiles)], np.int32)
        own = needed.copy(), *(np.full(tiles + k, -7, np.int32) for k in (0, 1))
        envelope = Envelope(SIDE * tiles, tiles, *own)
        complete(envelope)
        assert (envelope.firsts <= needed).all()
        assert (np.diff(envelope.firsts) >= 0).all()
        for i in range(tiles):
            assert envelope.firsts[i] == needed[i:].min()
            assert envelope.lasts[i] == np.flatnonzero(envelope.firsts <= i)[-1]
        places = [tile_at(envelope, i, j) for i in range(tiles) for j in range(own[0][i], i + 1)]
        assert places == list(range(0, size_of(envelope), AREA))


@pytest.mark.parametrize(("tiles", "is_small"), [(5792, True), (5793, False), (92_682, False)])
def test_a_dense_matrix_with_too_many_tiles_never_fits(tiles, is_small):
    """5793 tile rows have numbers beyond 32 bits, and 92682 have more tiles than an i4 counts."""
    envelope = Envelope(SIDE * tiles, tiles, *(np.zeros(tiles + k, np.int32) for k in (0, 0, 1)))
    complete(envelope)
    assert (np.diff(envelope.starts) >= 0).all()
    room = np.lib.stride_tricks.as_strided(np.zeros(1), (10**14,), (0,))  # takes no memory
    assert fits(envelope, room) == is_small
    assert (dense_tiles(SIDE * tiles) <= MOST_TILES) == is_small
    assert not fits(envelope, np.zeros(AREA))

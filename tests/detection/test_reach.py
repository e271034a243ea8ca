"""How far vertices moved, never too little; and when their reach is renewed."""

from fractions import Fraction

import numpy as np

from izo_ref.detection.serial.reach import largest_moves, renew_reach


def test_a_move_is_never_rounded_below_the_exact_one(rng):
    positions = rng.normal(size=(300, 3)) * 10.0 ** rng.integers(-3, 3, (300, 1))
    previous = positions + rng.normal(size=(300, 3)) * 10.0 ** rng.integers(-9, 3, (300, 1))
    previous[:20] = positions[:20]
    moves, n_moved = largest_moves(positions, previous)
    assert n_moved == 280
    for move, a, b in zip(moves.tolist(), positions.tolist(), previous.tolist(), strict=True):
        exact = max(abs(Fraction(x) - Fraction(y)) for x, y in zip(a, b, strict=True))
        assert exact <= Fraction(move) <= exact * (1 + Fraction(1, 2**49))


def test_a_vertex_gets_a_new_centre_and_reach_where_it_leaves_the_old_one(rng):
    centres = rng.normal(size=(50, 3))
    reach = np.where(np.arange(50) % 2 == 0, 0.25, 0.0)
    positions = centres.copy()
    axis, far = rng.integers(0, 3, 50), np.arange(50) % 5 < 2
    positions[np.arange(50), axis] += np.where(far, 0.5, 0.125) * rng.choice([-1.0, 1.0], 50)
    moves, before, left = rng.uniform(0.0, 1.0, 50), centres.copy(), np.empty(50, bool)
    old_reach = reach.copy()
    count = renew_reach(positions, moves, 2.0, 0.8, centres, reach, left)
    expected = far | (old_reach == 0.0)
    np.testing.assert_array_equal(left, expected)
    assert count == expected.sum()
    np.testing.assert_array_equal(centres, np.where(expected[:, None], positions, before))
    renewed = np.minimum(2.0 * moves, 0.8)
    np.testing.assert_array_equal(reach, np.where(expected, renewed, old_reach))

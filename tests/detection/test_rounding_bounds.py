"""The bounds of rounding cover what the formulas can lose at most, derived step by step.

The bounds were derived by hand, in the tables of the modules. Here the formulas themselves run on
numbers that carry a bound of their rounding (`tests/helpers/rounding.py`), for nodes of the largest
size, whose coordinates are differences of floats.
"""

import itertools

import numpy as np
import pytest

from izo_ref.certificate.formulas.meeting import _meets_between
from izo_ref.detection.formulas import advance, touching
from izo_ref.detection.formulas.advance import GAP_ERROR, separated_until
from izo_ref.detection.formulas.coplanar import COEFFICIENT_ERROR, bernstein_coefficients, split
from izo_ref.detection.formulas.crossing import certain_sign
from tests.helpers.rounding import Bounded, U, pure

TIMES = (0.0, 2.0**-30, 0.1, 0.25, 1 / 3, 0.5, 0.7, 1.0 - 2.0**-30, 1.0)


def nodes(notes, n=6, size=1.0):
    """Return vectors whose coordinates have a size, and the error of a difference of floats."""
    return [tuple(Bounded(size, U * size, notes) for _ in range(3)) for _ in range(n)]


def exact(value, notes):
    """Return a number without error."""
    return Bounded(abs(value), 0.0, notes, value)


def report(notes):
    """Check that each bound covers the error that was beside it; print the nearest ones."""
    assert notes
    for error, bound in notes:
        assert error <= bound, f"{error / U:.1f} u is not below {bound / U:.1f} u"
    error, bound = max(notes, key=lambda note: note[0] / note[1])
    print(f"{error / U:.1f} u of {bound / U:.1f} u")


def test_the_bound_of_the_cubic_covers_its_coefficients_after_two_subdivisions():
    cubic = pure(bernstein_coefficients)(*nodes([]))
    notes = []
    for low, window in itertools.product(TIMES, TIMES):
        _, rest = pure(split)(cubic, exact(low, []))
        head, _ = pure(split)(rest, exact(window, []))
        notes += [((c - 0.0).error, COEFFICIENT_ERROR) for c in head]
    report(notes)


def test_the_bound_of_a_gap_covers_projections_and_the_time_at_which_it_ends():
    """The time has a relative error of 5 u, and the gap changes by at most 4 sizes: 20 u."""
    for n in ((1.0, 0.0, 0.0), (0.25, 0.25, 0.5), (0.3, 0.3, 0.4), (0.0, 0.7, 0.3)):
        for is_edge_edge, t in itertools.product((False, True), TIMES):
            notes = []
            direction = tuple(exact(x, notes) for x in n)
            time = exact(t, notes)
            assert pure(separated_until)(is_edge_edge, direction, *nodes(notes), time, GAP_ERROR)
            report([(error + 20 * U, bound) for error, bound in notes])


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_every_direction_that_is_tried_has_to_leave_a_gap_above_the_bound(rng, is_edge_edge):
    """The bound is relative to the direction and to the size of the pair, which is near 1."""
    tried = []

    def separates(kind, n, *rest):
        tried.append((n, rest[-1]))
        return pure(advance.separated_until)(kind, n, *rest)

    first_contact = pure(advance._first_contact, {"separated_until": separates})
    for _ in range(100):
        flat = rng.normal(size=(6, 3)) * (1.0, 1.0, 0.1)
        nodes = [tuple(row) for row in (flat / np.abs(flat).max()).tolist()]
        size = max(abs(x) for node in nodes for x in node)
        first_contact(is_edge_edge, *nodes, GAP_ERROR * size, (1.0, -1.0, 1.0, 1.0), 0.0)
    assert len(tried) > 150
    for n, threshold in tried:
        assert threshold >= GAP_ERROR * sum(abs(x) for x in n) * (1.0 - 4 * U)


@pytest.mark.parametrize("is_edge_edge", [False, True])
@pytest.mark.parametrize("sizes", [(1, 1, 1, 1, 1, 1), (8, 1, 0.5, 1, 8, 16), (1, 8, 1, 8, 1, 0.5)])
def test_the_bounds_of_a_certain_meeting_cover_volumes_and_areas(is_edge_edge, sizes):
    """A node may be far out at the start alone, or at the end alone."""
    for t0, t1 in itertools.combinations(TIMES, 2):
        notes = []
        direction = tuple(exact(x, notes) for x in (1.0, 1.0, 1.0))
        times = exact(t0, notes), exact(t1, notes)
        own = [nodes(notes, 1, size)[0] for size in sizes]
        pure(_meets_between)(is_edge_edge, direction, *own, *times)
        assert len(notes) == (6 if is_edge_edge else 5)
        report(notes)


@pytest.mark.parametrize("size", [0.5, 1.0, 2.0])
def test_the_bound_of_a_side_covers_its_determinant(size):
    notes = []
    assert pure(certain_sign)(*nodes(notes, 3, size)) == 1
    report(notes)


def test_the_bounds_right_after_the_start_cover_the_cubic():
    for size in (0.75, 100.0):
        notes = []
        assert pure(touching.is_apart_after_start)(*nodes(notes, 6, size))
        assert pure(touching.volume_sign_after_start)(0, *nodes(notes, 6, size)) == 1
        assert len(notes) >= 2
        report(notes)

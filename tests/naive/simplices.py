"""Whether two hulls of few points meet, by trying every subset of the points in fractions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import combinations


def _solve(columns: Sequence[Sequence[Fraction]], rhs: Sequence[Fraction]) -> list[Fraction] | None:
    """Return the unique solution of an overdetermined system, or None if there is none.

    Args:
        columns: The columns of the matrix; there are at most as many as rows.
        rhs: The right-hand side.
    """
    rows = [[column[i] for column in columns] + [rhs[i]] for i in range(len(rhs))]
    n = len(columns)
    for k in range(n):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k] != 0), None)
        if pivot is None:
            return None  # the columns are dependent
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for i in range(len(rows)):
            if i != k and rows[i][k] != 0:
                factor = rows[i][k]
                rows[i] = [v - factor * w for v, w in zip(rows[i], rows[k], strict=True)]
    if any(row[n] != 0 for row in rows[n:]):
        return None  # no solution
    return [rows[k][n] for k in range(n)]


def simplices_meet(
    points_a: Iterable[Iterable[float]], points_b: Iterable[Iterable[float]]
) -> bool:
    """Return whether the convex hulls of two small sets of points have a point in common, exactly.

    The hulls meet if sum_i l_i a_i - sum_j m_j b_j = 0, sum l = 1, sum m = 1 has a solution with
    l, m >= 0. If it has a solution, it has one whose columns are linearly independent (a basic
    solution). So it is enough to try each subset of the columns.

    Args:
        points_a: Points of three coordinates each.
        points_b: Points of three coordinates each.
    """
    columns = [[*map(Fraction, p), Fraction(1), Fraction(0)] for p in points_a]
    columns += [[*(-Fraction(v) for v in p), Fraction(0), Fraction(1)] for p in points_b]
    rhs = [Fraction(0)] * 3 + [Fraction(1)] * 2
    for size in range(2, len(columns) + 1):
        for subset in combinations(columns, size):
            solution = _solve(subset, rhs)
            if solution is not None and min(solution) >= 0:
                return True
    return False

"""The optimum of a zone in rational arithmetic: no rounding, at any mass ratio.

The data are floats, so they are rationals. With A the rows of the constraints, M the
masses and y the proposed positions, the optimum is x = y + M^-1 A^T l, and l solves

    l >= 0,  w = K l - r >= 0,  l . w = 0,   K = A M^-1 A^T,  r = d - A y.

Given a set of active rows with independent gradients, l on it solves K_aa l_a = r_a, and
the signs of l_a and of w on all rows are an exact yes or no to optimality. If it is no, a
dual active-set method goes on from there until it is yes: in exact arithmetic it ends,
since its objective rises with each set, and ties need no tolerance.

Source: SPEC section 5; D. Goldfarb, A. Idnani, Mathematical Programming 27 (1983).
"""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import fmpq, fmpq_mat

ZERO = fmpq(0)


class ExactPoint(NamedTuple):
    """A point with its multipliers, and whether it is the optimum."""

    moves: list  # [fmpq; 3] a vertex, x - y
    multipliers: list  # fmpq a row
    optimal: bool


def rational(number) -> fmpq:
    numerator, denominator = float(number).as_integer_ratio()
    return fmpq(numerator, denominator)


class ExactZone:
    """A zone problem in rationals.

    Args:
        problem: has nodes, weights, normals, proposed, masses, thickness, as ZoneProblem.
    """

    def __init__(self, problem):
        self.masses = [None if math.isinf(m) else rational(m) for m in problem.masses]
        self.proposed = proposed = [[rational(c) for c in point] for point in problem.proposed]
        self.still = [[ZERO] * 3 for _ in proposed]
        thickness = rational(problem.thickness)
        self.rows, self.rhs = [], []  # a row: {vertex: gradient}
        for nodes, weights, normal in zip(
            problem.nodes.tolist(), problem.weights, problem.normals, strict=True
        ):
            normal = [rational(c) for c in normal]
            row, gap = {}, ZERO
            for vertex, weight in zip(nodes, map(rational, weights), strict=True):
                for axis in range(3):
                    gap += weight * normal[axis] * proposed[vertex][axis]
                    if self.masses[vertex] is not None:
                        row.setdefault(vertex, [ZERO] * 3)
                        row[vertex][axis] += weight * normal[axis]
            self.rows.append(row)
            self.rhs.append(thickness - gap)
        self.gram = fmpq_mat(len(self.rows), len(self.rows))
        for i, row in enumerate(self.rows):
            for j in range(i + 1):
                self.gram[i, j] = self.gram[j, i] = self._product(row, self.rows[j])

    def _product(self, a, b):
        return sum(
            (
                sum((p * q for p, q in zip(a[v], b[v], strict=True)), ZERO) / self.masses[v]
                for v in a.keys() & b.keys()
            ),
            ZERO,
        )

    def _block(self, rows, columns):
        entries = [self.gram[i, j] for i in rows for j in columns]
        return fmpq_mat(len(rows), len(columns), entries)

    def _solved(self, active, right):
        """K_aa^-1 right, for independent rows."""
        column = fmpq_mat(len(active), 1, right)
        return [v for (v,) in self._block(active, active).solve(column).tolist()] if active else []

    def _slacks(self, active, multipliers):
        """w on all rows."""
        every = range(len(self.rows))
        if not active:
            return [-r for r in self.rhs]
        column = fmpq_mat(len(active), 1, multipliers)
        pulled = (self._block(every, active) * column).tolist()
        return [value - r for (value,), r in zip(pulled, self.rhs, strict=True)]

    def independent(self, active):
        """The first of these rows that are independent of those before them."""
        if not active:
            return []
        echelon, rank = self._block(active, active).rref()
        kept, column = [], 0
        for row in range(rank):
            while echelon[row, column] == 0:
                column += 1
            kept.append(active[column])
        return kept

    def point(self, active) -> ExactPoint:
        """The point that active rows hold, exactly, and whether it is the optimum."""
        active = self.independent(list(active))
        return self._point(active, self._solved(active, [self.rhs[j] for j in active]))

    def _point(self, active, values):
        multipliers = [ZERO] * len(self.rows)
        moves = [[ZERO] * 3 for _ in self.masses]
        for j, value in zip(active, values, strict=True):
            multipliers[j] = value
            for vertex, gradient in self.rows[j].items():
                for axis in range(3):
                    moves[vertex][axis] += gradient[axis] * value / self.masses[vertex]
        optimal = min(values, default=ZERO) >= 0
        optimal = optimal and min(self._slacks(active, values), default=ZERO) >= 0
        return ExactPoint(moves, multipliers, optimal)

    def solve(self, active=()) -> ExactPoint | None:
        """The optimum; None if no point satisfies the constraints.

        Args:
            active: rows to begin with, a guess; a good one saves time.
        """
        active = self.independent(list(active))
        values = self._solved(active, [self.rhs[j] for j in active])
        while values and min(values) < 0:
            active.pop(values.index(min(values)))
            values = self._solved(active, [self.rhs[j] for j in active])
        while True:
            slacks = self._slacks(active, values)
            if min(slacks, default=ZERO) >= 0:
                return self._point(active, values)
            values = self._add(slacks.index(min(slacks)), active, values, -min(slacks))
            if values is None:
                return None

    def _add(self, entering, active, values, missing):
        """Take a violated row in, dropping rows that block; changes `active`."""
        gained = ZERO
        while True:
            direction = self._solved(active, [self.gram[j, entering] for j in active])
            curvature = self.gram[entering, entering] - sum(
                (self.gram[entering, j] * v for j, v in zip(active, direction, strict=True)), ZERO
            )
            blocking = [
                (value / v, k)
                for k, (value, v) in enumerate(zip(values, direction, strict=True))
                if v > 0
            ]
            limit, drop = min(blocking, default=(None, None))
            full = missing / curvature if curvature > 0 else None
            if limit is None and full is None:
                return None
            is_full = limit is None or (full is not None and full <= limit)
            step = full if is_full else limit
            values = [value - step * v for value, v in zip(values, direction, strict=True)]
            gained += step
            if is_full:
                active.append(entering)
                return [*values, gained]
            missing -= step * curvature
            active.pop(drop)
            values.pop(drop)

    def moves(self, positions):
        """x - y of positions in floats, without rounding."""
        return [
            [rational(x) - y for x, y in zip(point, target, strict=True)]
            for point, target in zip(positions, self.proposed, strict=True)
        ]

    def distance(self, a, b) -> float:
        """[m kg^1/2], between two displacements in the norm of the masses."""
        total = ZERO
        for mass, p, q in zip(self.masses, a, b, strict=True):
            if mass is not None:
                total += mass * sum(
                    ((_exact(x) - _exact(y)) ** 2 for x, y in zip(p, q, strict=True)), ZERO
                )
        return _root(total)

    def relative_error(self, moves, exact: ExactPoint) -> float:
        """|x - x*| over |x* - y|, in the norm of the masses; infinite for no answer."""
        if not all(isinstance(x, fmpq) or math.isfinite(x) for p in moves for x in p):
            return math.inf
        return self.distance(moves, exact.moves) / self.distance(exact.moves, self.still)


def _exact(number):
    return number if isinstance(number, fmpq) else rational(number)


def _root(number):
    """Square root of a rational, as a float."""
    if number == 0:
        return 0.0
    # four to some power in front, so that numerator and denominator fit into floats
    shift = (int(number.p).bit_length() - int(number.q).bit_length()) // 2
    scaled = number / fmpq(4) ** shift
    return math.ldexp(math.sqrt(float(_fraction(scaled))), shift)


def _fraction(number):
    return Fraction(int(number.p), int(number.q))


def to_float(rows) -> np.ndarray:
    """Rationals, rounded; those too small for a float become zero."""
    return np.array([[float(_fraction(value)) for value in row] for row in rows])


def active_rows(multipliers) -> np.ndarray:
    """A guess of the active rows from multipliers in floats."""
    return np.flatnonzero(np.asarray(multipliers) > 0.0)

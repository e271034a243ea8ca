"""The optimum of a zone in rational arithmetic: without rounding, at any mass ratio.

Question: which positions are closest to the proposed ones and satisfy the constraints of the zone?

Method: the data are floats, so they are rationals. With A the matrix of the constraints, M the
masses and y the proposed positions, the optimum is x = y + M^-1 A^T l, and l solves

    l >= 0,  w = K l - r >= 0,  l . w = 0,   K = A M^-1 A^T,  r = d - A y.

Take a set of active constraints with independent gradients. Then l on this set solves
K_aa l_a = r_a, and the signs of l_a and of w on all constraints say exactly whether the set is
optimal. If it is not, a dual active-set method begins with this set and changes it until it is
optimal. In exact arithmetic the method ends, since its objective rises with each set, and ties need
no tolerance.

Independent of `izo_ref`: every number is a rational of FLINT, the problem is stated from the
mathematics, and the answer does not depend on the set from which the method begins.

Limits: rationals grow with the number of active constraints, so judges and studies ask for zones of
up to EXACT_IMPACTS impacts only.

Source: docs/method section 5; D. Goldfarb, A. Idnani, Mathematical Programming 27 (1983).
"""

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.typing import ArrayLike

from validation.oracles.answer import Floats, Indices, ZoneArrays

Moves: TypeAlias = Sequence[Sequence[fmpq | float]]  # [m], three numbers for each vertex
Gradient: TypeAlias = dict[int, list[fmpq]]  # of one constraint: three numbers for some vertices

# Largest number of impacts of a zone whose exact optimum is asked for. Begun from our answer, no
# random zone of that size took more than 0.2 s (`exact_s` in `reports/zones.json`).
EXACT_IMPACTS = 64
ZERO = fmpq(0)


class ExactPoint(NamedTuple):
    """A point with its multipliers, and whether it is the optimum."""

    moves: list[list[fmpq]]  # [m], x - y, three numbers for each vertex
    multipliers: list[fmpq]  # [kg], one for each constraint
    optimal: bool


def rational(number: float) -> fmpq:
    """Convert a float to the rational number that it is."""
    numerator, denominator = float(number).as_integer_ratio()
    return fmpq(numerator, denominator)


class ExactZone:
    """A zone problem in rationals.

    Args:
        problem: A zone problem, for example a `ZoneProblem`.

    Attributes:
        masses: One mass for each vertex [kg]; None for a pinned vertex.
        inverse_masses: The inverse of each mass [1/kg]; zero for a pinned vertex.
        proposed: The proposed positions [m], three numbers for each vertex.
        still: Displacements of zero, three numbers for each vertex.
        gradients: The gradient of each constraint.
        rhs: d - A y of each constraint [m].
        gram: K, a matrix of FLINT.
    """

    def __init__(self, problem: ZoneArrays) -> None:
        """Convert the problem and compute K."""
        self.masses = [None if math.isinf(m) else rational(m) for m in problem.masses]
        self.inverse_masses = [ZERO if m is None else 1 / m for m in self.masses]
        self.proposed = proposed = [[rational(c) for c in point] for point in problem.proposed]
        self.still = [[ZERO] * 3 for _ in proposed]
        thickness = rational(problem.thickness)
        self.gradients: list[Gradient] = []
        self.rhs: list[fmpq] = []
        for nodes, weights, normal in zip(
            problem.nodes.tolist(), problem.weights, problem.normals, strict=True
        ):
            normal = [rational(c) for c in normal]
            gradient: Gradient = {}
            gap = ZERO
            for vertex, weight in zip(nodes, map(rational, weights), strict=True):
                for axis in range(3):
                    gap += weight * normal[axis] * proposed[vertex][axis]
                    if self.masses[vertex] is not None:
                        gradient.setdefault(vertex, [ZERO] * 3)
                        gradient[vertex][axis] += weight * normal[axis]
            self.gradients.append(gradient)
            self.rhs.append(thickness - gap)
        self.gram = fmpq_mat(len(self.gradients), len(self.gradients))
        for i, gradient in enumerate(self.gradients):
            for j in range(i + 1):
                self.gram[i, j] = self.gram[j, i] = self._product(gradient, self.gradients[j])

    def _product(self, a: Gradient, b: Gradient) -> fmpq:
        """Compute a M^-1 b."""
        return sum(
            (
                sum((p * q for p, q in zip(a[v], b[v], strict=True)), ZERO) * self.inverse_masses[v]
                for v in a.keys() & b.keys()
            ),
            ZERO,
        )

    def _block(self, rows: Sequence[int], columns: Sequence[int]) -> fmpq_mat:
        """Return a block of K."""
        entries = [self.gram[i, j] for i in rows for j in columns]
        return fmpq_mat(len(rows), len(columns), entries)

    def _solved(self, active: Sequence[int], right: Sequence[fmpq]) -> list[fmpq]:
        """Compute K_aa^-1 right; the active constraints are independent."""
        column = fmpq_mat(len(active), 1, right)
        return [v for (v,) in self._block(active, active).solve(column).tolist()] if active else []

    def _slacks(self, active: Sequence[int], multipliers: Sequence[fmpq]) -> list[fmpq]:
        """Compute w on all constraints from the multipliers of the active ones."""
        every = range(len(self.gradients))
        if not active:
            return [-r for r in self.rhs]
        column = fmpq_mat(len(active), 1, multipliers)
        pulled = (self._block(every, active) * column).tolist()
        return [value - r for (value,), r in zip(pulled, self.rhs, strict=True)]

    def independent(self, active: Sequence[int]) -> list[int]:
        """Return the constraints that are independent of those before them in the list."""
        if not active:
            return []
        echelon, rank = self._block(active, active).rref()
        kept, column = [], 0
        for row in range(rank):
            while echelon[row, column] == 0:
                column += 1
            kept.append(active[column])
        return kept

    def point(self, active: Iterable[int]) -> ExactPoint:
        """Compute the point at which active constraints hold with equality.

        Args:
            active: Indices of the active constraints.

        Returns:
            The point, exactly, and whether it is the optimum.
        """
        active = self.independent(list(active))
        return self._point(active, self._solved(active, [self.rhs[j] for j in active]))

    def _point(self, active: Sequence[int], values: Sequence[fmpq]) -> ExactPoint:
        """Compute the point that belongs to multipliers of active constraints."""
        multipliers = [ZERO] * len(self.gradients)
        moves = [[ZERO] * 3 for _ in self.masses]
        for j, value in zip(active, values, strict=True):
            multipliers[j] = value
            for vertex, gradient in self.gradients[j].items():
                for axis in range(3):
                    moves[vertex][axis] += gradient[axis] * value * self.inverse_masses[vertex]
        optimal = min(values, default=ZERO) >= 0
        optimal = optimal and min(self._slacks(active, values), default=ZERO) >= 0
        return ExactPoint(moves, multipliers, optimal)

    def solve(self, active: Iterable[int] = ()) -> ExactPoint | None:
        """Compute the optimum.

        Args:
            active: Constraints to begin with, a guess; a good guess saves time.

        Returns:
            The optimum; None if no point satisfies the constraints.
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
            raised = self._add(slacks.index(min(slacks)), active, values, -min(slacks))
            if raised is None:
                return None
            values = raised

    def _add(
        self, entering: int, active: list[int], values: list[fmpq], missing: fmpq
    ) -> list[fmpq] | None:
        """Add a violated constraint to the active ones, and drop those that block it.

        Args:
            entering: The constraint.
            active: The active constraints; changed in place.
            values: Their multipliers.
            missing: By how much the entering constraint is violated.

        Returns:
            The multipliers of the active constraints; None if no point satisfies the constraints.
        """
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
            full = missing / curvature if curvature > 0 else None
            if full is not None and (not blocking or full <= min(blocking)[0]):
                active.append(entering)
                values = [value - full * v for value, v in zip(values, direction, strict=True)]
                return [*values, gained + full]
            if not blocking:
                return None
            step, dropped = min(blocking)
            values = [value - step * v for value, v in zip(values, direction, strict=True)]
            gained += step
            missing -= step * curvature
            active.pop(dropped)
            values.pop(dropped)

    def moves(self, positions: Iterable[Iterable[float]]) -> list[list[fmpq]]:
        """Compute x - y without rounding.

        Args:
            positions: (n, 3) f8 [m].

        Returns:
            [m], three numbers for each vertex.
        """
        return [
            [rational(x) - y for x, y in zip(point, proposed, strict=True)]
            for point, proposed in zip(positions, self.proposed, strict=True)
        ]

    def distance(self, a: Moves | Floats, b: Moves | Floats) -> float:
        """Compute the distance of two displacements in the norm of the masses [m kg^1/2].

        The sum of squares is exact; the root is rounded to a float.

        Args:
            a: (n, 3) [m], floats or rationals.
            b: (n, 3) [m], floats or rationals.
        """
        apart: list[fmpq] = []
        pull: list[fmpq] = []
        for mass, p, q in zip(self.masses, a, b, strict=True):
            if mass is not None:
                own = [_exact(x) - _exact(y) for x, y in zip(p, q, strict=True)]
                apart += own
                pull += [mass * value for value in own]
        if not apart:
            return 0.0
        # The product of two matrices uses a common denominator. That is ten times as fast as a sum.
        (squared,) = (fmpq_mat(1, len(pull), pull) * fmpq_mat(len(apart), 1, apart)).entries()
        return _root(squared)

    def relative_error(self, moves: Moves | Floats, exact: ExactPoint) -> float:
        """Compute |x - x*| over |x* - y|, in the norm of the masses.

        Args:
            moves: (n, 3) [m], x - y, floats or rationals.
            exact: The optimum.

        Returns:
            The relative error; infinity if a displacement is not finite.
        """
        if not all(isinstance(x, fmpq) or math.isfinite(x) for p in moves for x in p):
            return math.inf
        return self.distance(moves, exact.moves) / self.distance(exact.moves, self.still)


def _exact(number: fmpq | float) -> fmpq:
    return number if isinstance(number, fmpq) else rational(number)


def _root(number: fmpq) -> float:
    """Return the square root of a rational, as a float."""
    if number == 0:
        return 0.0
    # a power of four is taken out, so that numerator and denominator fit into floats
    shift = (int(number.p).bit_length() - int(number.q).bit_length()) // 2
    scaled = number / fmpq(4) ** shift
    return math.ldexp(math.sqrt(float(_fraction(scaled))), shift)


def _fraction(number: fmpq) -> Fraction:
    return Fraction(int(number.p), int(number.q))


def to_float(rows: Iterable[Iterable[fmpq]]) -> Floats:
    """Round rows of rationals to floats; a rational too small for a float becomes zero."""
    return np.array([[float(_fraction(value)) for value in row] for row in rows])


def active_rows(multipliers: ArrayLike) -> Indices:
    """Guess the active constraints from multipliers in floats.

    Args:
        multipliers: (n_impacts,) f8 [kg].

    Returns:
        Indices of the constraints whose multiplier is positive.
    """
    return np.flatnonzero(np.asarray(multipliers) > 0.0)

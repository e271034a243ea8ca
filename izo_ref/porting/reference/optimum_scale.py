"""How exactly a port can know the optimum of a zone: the scale of the tolerances of stage S11.

Let F be tight constraints that are linearly independent, and P = M^-1 A_F^T K_FF^-1. Then the moves
are x - y = P s_F. If constraint j holds up to an error e_j, the moves change by P e, so a port that
makes errors e_j has moved vertex i by at most sum_j |P_ij| e_j more or less. The errors are

* of an iteration that stops: a fraction of S, the largest sum_k |a_jk| |x_k - y_k| of a tight
  constraint. S is the size of the answer, to which ports compare what they leave;
* of rounding: eps times the terms of d - A y, and those of K l, which a port sums up that solves
  for l;
* of an inactive constraint, whose multiplier an iteration leaves at e_j / K_jj in place of 0, as
  `kkt` accepts. It moves the vertices of that impact by M^-1 A_j^T e_j / K_jj, and changes the gap
  of a tight constraint f by K_fj e_j / K_jj;
* and where x - y = M^-1 A^T l is computed: a fraction of the move, and eps times the terms of
  M^-1 A^T l. The position itself is rounded too.

If tight constraints are dependent, rounding decides which of them a port takes for active. So the
scale is the largest one of all choices of F.

The multiples say how well a port is expected to converge: 2^22 eps = 1e-9 of the answer in float64,
and 2^10 eps = 1.2e-4 in float32. Rounding has to be better than that by ROUNDING, which leaves it
8 eps in float32.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any, NamedTuple

from izo_ref.porting.reference.optimum import ZERO, Optimum, Rows, Vector, solve
from izo_ref.porting.reference.rounded import EPS

MULTIPLE = {"f8": 2**22, "f4": 2**10}
ROUNDING = Fraction(1, 2**7)
USELESS = 1e-2  # a bound of more than this fraction of the largest move says nothing
# Normals are rounded to float64, so constraints that are tight by construction miss it by so much.
TIGHT = Fraction(1, 2**40)


class Scales(NamedTuple):
    """Scales of the tolerances of one zone.

    Attributes:
        positions: For each coordinate of each vertex [m]; 0 where y is the answer bit for bit.
        gaps: For each constraint [m].
        dtypes: Types of floats for which the tolerances say something.
    """

    positions: list[float]
    gaps: list[float]
    dtypes: tuple[str, ...]


def scales(zone: Mapping[str, Any], rows: Rows, found: Optimum) -> Scales:
    """Return the scales for the optimum of a zone that is feasible."""
    terms = _terms(zone)
    gaps = [_dot(row, found.moves) - s for row, s in zip(rows.matrix, rows.rhs, strict=True)]
    tight = [j for j, gap in enumerate(gaps) if gap <= TIGHT * terms[j]]
    sizes = [_dot(map(abs, row), map(abs, found.moves)) for row in rows.matrix]
    size = max((sizes[j] for j in tight), default=ZERO)
    pushes = [abs(value) for value in found.multipliers]
    sums = [_dot(map(abs, row), pushes) for row in rows.gram]
    errors = [size + ROUNDING * (t + s) for t, s in zip(terms, sums, strict=True)]
    parts = [ZERO] * len(rows.unknowns)
    if any(found.moves):  # or else the proposed positions are the answer
        parts = _parts(zone, rows, found, tight, errors)
    by_unknown = dict(zip(rows.unknowns, parts, strict=True))
    own = [by_unknown.get((i // 3, i % 3), ZERO) for i in range(len(zone["proposed"]))]
    own_gaps = [
        _dot(map(abs, row), parts) + error for row, error in zip(rows.matrix, errors, strict=True)
    ]
    dtypes = ("f8", "f4")
    if size > 0:
        largest_move = max(abs(move) for move in found.moves)
        relative = float(max(parts) / largest_move)
        dtypes = tuple(name for name in dtypes if MULTIPLE[name] * EPS[name] * relative < USELESS)
    return Scales([float(part) for part in own], [float(gap) for gap in own_gaps], dtypes)


def _parts(
    zone: Mapping[str, Any], rows: Rows, found: Optimum, tight: list[int], errors: Vector
) -> Vector:
    """Return the scale of each unknown."""
    left = _left_multipliers(rows, tight, errors)
    disturbed = [
        error + _dot(map(abs, row), left) for row, error in zip(rows.gram, errors, strict=True)
    ]
    parts = _propagated(rows, tight, disturbed)
    pushes = [abs(value) for value in found.multipliers]
    for i, (vertex, axis) in enumerate(rows.unknowns):
        column = [abs(row[i]) for row in rows.matrix]
        first = i - axis
        move = max(abs(found.moves[first + k]) for k in range(3))
        place = abs(Fraction(zone["proposed"][3 * vertex + axis])) + move
        rounded = place + _dot(column, pushes) * rows.inverse_masses[i]
        parts[i] += move + ROUNDING * rounded + _dot(column, left) * rows.inverse_masses[i]
    return parts


def _left_multipliers(rows: Rows, tight: list[int], errors: Vector) -> Vector:
    """Return the multiplier that an iteration may leave to each constraint that is not tight."""
    return [
        ZERO if j in tight or rows.gram[j][j] == 0 else error / rows.gram[j][j]
        for j, error in enumerate(errors)
    ]


def _propagated(rows: Rows, tight: list[int], errors: Vector) -> Vector:
    """Return sum_j |P_ij| e_j of each unknown, the largest one of all choices of F."""
    largest, n = [ZERO] * len(rows.unknowns), len(tight)
    for count in range(n, 0, -1):
        regular = False
        for chosen in combinations(tight, count):
            gram = [[rows.gram[i][j] for j in chosen] for i in chosen]
            unit = [[Fraction(int(i == j)) for j in range(count)] for i in range(count)]
            inverse = [solve(gram, row) for row in unit]
            if inverse[0] is None or _is_nearly_singular(gram, inverse):
                continue
            regular = True
            for i in range(len(largest)):
                column = [rows.matrix[j][i] for j in chosen]
                terms = (
                    abs(_dot(row or [], column)) * errors[j]
                    for row, j in zip(inverse, chosen, strict=True)
                )
                largest[i] = max(largest[i], sum(terms, ZERO) * rows.inverse_masses[i])
        if regular:
            break
    return largest


def _is_nearly_singular(gram: Sequence[Vector], inverse: Sequence[Vector | None]) -> bool:
    """Return whether constraints are dependent but for the rounding of normals to float64."""
    size = sum((gram[i][i] * (row or [ZERO] * len(gram))[i] for i, row in enumerate(inverse)), ZERO)
    return size > 1 / TIGHT**2


def _terms(zone: Mapping[str, Any]) -> Vector:
    """Return the sum of the magnitudes of all terms of d - A y, for each constraint [m]."""
    result = []
    for j in range(len(zone["nodes"]) // 4):
        total = Fraction(zone["thickness"])
        for k in range(4):
            vertex = zone["nodes"][4 * j + k]
            weight = abs(Fraction(zone["weights"][4 * j + k]))
            for axis in range(3):
                place = abs(Fraction(zone["proposed"][3 * vertex + axis]))
                total += weight * abs(Fraction(zone["normals"][3 * j + axis])) * place
        result.append(total)
    return result


def _dot(a: Iterable[Fraction], b: Iterable[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), ZERO)

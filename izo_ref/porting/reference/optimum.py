"""The exact optimum of a small zone, in fractions: the reference of stage S11.

The method is the dual active-set method of Goldfarb and Idnani. In exact arithmetic it ends after
finitely many steps, needs no tolerance, and copes with redundant rows. `check` proves the answer by
the conditions of optimality, or by Farkas' lemma if no positions satisfy the constraints.

Source: D. Goldfarb and A. Idnani, A numerically stable dual method for solving strictly convex
quadratic programs (1983); docs/method section 5.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

Vector = list[Fraction]
Matrix = list[Vector]
ZERO, ONE = Fraction(0), Fraction(1)


class Rows(NamedTuple):
    """The constraints of a zone in the unknowns z = x - y: A z >= s.

    Attributes:
        unknowns: (vertex, axis) of each unknown.
        matrix: A, one row for each impact.
        rhs: s = d - A y, with all vertices in A y [m].
        inverse_masses: 1 / m of the vertex of each unknown [1/kg].
        gram: K = A M^-1 A^T [1/kg].
    """

    unknowns: list[tuple[int, int]]
    matrix: Matrix
    rhs: Vector
    inverse_masses: Vector
    gram: Matrix


class Optimum(NamedTuple):
    """The optimum of a zone, or the proof that there is none.

    Attributes:
        feasible: Whether positions exist that satisfy all constraints.
        moves: z = x - y of each unknown [m]; empty if infeasible.
        multipliers: l of each impact, for 1/2 sum m |x - y|^2. If infeasible, combine the
            constraints with these factors: the unknowns cancel, and a contradiction is left.
    """

    feasible: bool
    moves: Vector
    multipliers: Vector


def rows_of(zone: Mapping[str, Any]) -> Rows:
    """Return the constraints of a zone from the inputs of stage S11."""
    pinned, flat = zone["pinned"], zone["nodes"]
    nodes = [flat[i : i + 4] for i in range(0, len(flat), 4)]
    used = sorted({v for quad in nodes for v in quad if not pinned[v]})
    unknowns = [(v, axis) for v in used for axis in range(3)]
    column = {unknown: i for i, unknown in enumerate(unknowns)}
    inverse = [1 / Fraction(zone["masses"][v]) for v, _ in unknowns]
    matrix, rhs = [], []
    for j, quad in enumerate(nodes):
        row, bound = [ZERO] * len(unknowns), Fraction(zone["thickness"])
        for k, vertex in enumerate(quad):
            for axis in range(3):
                entry = Fraction(zone["weights"][4 * j + k]) * Fraction(
                    zone["normals"][3 * j + axis]
                )
                bound -= entry * Fraction(zone["proposed"][3 * vertex + axis])
                if not pinned[vertex]:
                    row[column[vertex, axis]] += entry
        matrix.append(row)
        rhs.append(bound)
    scaled = [[a * w for a, w in zip(row, inverse, strict=True)] for row in matrix]
    gram = [[_dot(a, b) for b in scaled] for a in matrix]
    return Rows(unknowns, matrix, rhs, inverse, gram)


def optimum(rows: Rows) -> Optimum:
    """Solve a zone exactly."""
    active: list[int] = []
    multipliers = [ZERO] * len(rows.matrix)
    while True:
        gaps = [_dot(row, multipliers) - s for row, s in zip(rows.gram, rows.rhs, strict=True)]
        new = min(range(len(gaps)), key=lambda j: gaps[j], default=None)
        if new is None or gaps[new] >= 0:
            return Optimum(True, moves_of(rows, multipliers), multipliers)
        proof = _enter(rows, active, multipliers, new)
        if proof is not None:
            return Optimum(False, [], proof)


def moves_of(rows: Rows, multipliers: Sequence[Fraction]) -> Vector:
    """Return z = M^-1 A^T l."""
    columns = zip(*rows.matrix, strict=True) if rows.matrix else ([] for _ in rows.unknowns)
    pushes = [_dot(column, multipliers) for column in columns]
    return [w * push for w, push in zip(rows.inverse_masses, pushes, strict=True)]


def natural_residuals(
    rows: Rows, moves: Sequence[Fraction], multipliers: Sequence[Fraction]
) -> tuple[Vector, Vector]:
    """Return how far positions and multipliers are from the optimum, in metres.

    Args:
        rows: The constraints of the zone.
        moves: x - y of each unknown [m].
        multipliers: l of each impact.

    Returns:
        x - y - M^-1 A^T l of each unknown, and min(l_j K_jj, -c_j) of each impact. All are zero at
        the optimum and nowhere else. The second one is negative if a constraint is violated or if a
        multiplier is negative, and positive if an impact pushes although it has room.
    """
    ideal = moves_of(rows, multipliers)
    gaps = [_dot(row, moves) - s for row, s in zip(rows.matrix, rows.rhs, strict=True)]
    pushes = [multiplier * rows.gram[j][j] for j, multiplier in enumerate(multipliers)]
    return (
        [z - own for z, own in zip(moves, ideal, strict=True)],
        [min(push, gap) for push, gap in zip(pushes, gaps, strict=True)],
    )


def check(rows: Rows, found: Optimum) -> None:
    """Prove an answer exactly.

    Raises:
        ArithmeticError: The answer is wrong.
    """
    if found.feasible:
        residuals = natural_residuals(rows, found.moves, found.multipliers)
        right = not any(value for part in residuals for value in part)
    else:
        columns = list(zip(*rows.matrix, strict=True))
        cancels = not any(_dot(column, found.multipliers) for column in columns)
        right = cancels and min(found.multipliers) >= 0
        right = right and _dot(rows.rhs, found.multipliers) > 0
    if not right:
        raise ArithmeticError("the answer does not satisfy the conditions of optimality")


def solve(matrix: Matrix, rhs: Vector) -> Vector | None:
    """Solve linear equations by elimination; return None if the matrix is singular."""
    n = len(matrix)
    work = [[*row, value] for row, value in zip(matrix, rhs, strict=True)]
    for k in range(n):
        pivot = next((i for i in range(k, n) if work[i][k] != 0), None)
        if pivot is None:
            return None
        work[k], work[pivot] = work[pivot], work[k]
        for i in range(k + 1, n):
            factor = work[i][k] / work[k][k]
            if factor:
                work[i] = [a - factor * b for a, b in zip(work[i], work[k], strict=True)]
    result = [ZERO] * n
    for k in reversed(range(n)):
        known = sum((work[k][i] * result[i] for i in range(k + 1, n)), ZERO)
        result[k] = (work[k][n] - known) / work[k][k]
    return result


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), ZERO)


def _enter(rows: Rows, active: list[int], multipliers: Vector, new: int) -> Vector | None:
    """Let a violated constraint become active; others may leave.

    Args:
        rows: The constraints.
        active: The active constraints, which are linearly independent; changed in place.
        multipliers: Changed in place.
        new: The constraint that becomes active.

    Returns:
        None, or the factors of a contradiction if the constraint cannot be satisfied.
    """
    while True:
        gram = [[rows.gram[i][j] for j in active] for i in active]
        falls = solve(gram, [rows.gram[i][new] for i in active])
        if falls is None:
            raise ArithmeticError("the active constraints are dependent")
        slope = rows.gram[new][new] - sum(
            (rows.gram[new][i] * fall for i, fall in zip(active, falls, strict=True)), ZERO
        )
        gap = _dot(rows.gram[new], multipliers) - rows.rhs[new]
        steps = [(multipliers[i] / f, i) for i, f in zip(active, falls, strict=True) if f > 0]
        if slope == 0 and not steps:
            proof = [ZERO] * len(multipliers)
            proof[new] = ONE
            for i, fall in zip(active, falls, strict=True):
                proof[i] = -fall
            return proof
        blocking = min(steps, default=None)
        full = -gap / slope if slope > 0 else None
        enters = blocking is None or (full is not None and full <= blocking[0])
        step = full if enters and full is not None else (blocking or (ZERO, new))[0]
        multipliers[new] += step
        for i, fall in zip(active, falls, strict=True):
            multipliers[i] -= step * fall
        if enters:
            active.append(new)
            return None
        if blocking is not None:
            active.remove(blocking[1])
            multipliers[blocking[1]] = ZERO

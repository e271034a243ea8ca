"""Judge `kkt`: positions and multipliers of a zone satisfy the conditions of its optimum.

All residuals are lengths: x - y - M^-1 A^T l of each coordinate, and min(l_j K_jj, -c_j) of each
impact, where K = A M^-1 A^T. They are zero at the optimum and nowhere else. `scale` is for the
first ones, `gap_scale` for the second ones; `scale` serves both if there is no `gap_scale`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from izo_ref.porting.judge.geometry import Vector, dot, vectors
from izo_ref.porting.judge.measure import ratio, tolerance
from izo_ref.porting.judge.outcome import Difference, Question


class _Row(NamedTuple):
    """One impact: the sum of its weights at each vertex, and its normal."""

    weights: dict[int, Fraction]
    normal: Vector


def judge_kkt(question: Question) -> list[Difference]:
    """Check M (x - y) = A^T l, l >= 0, c <= 0 and l . c = 0 within tolerance.

    Pinned vertices count as fixed at their proposed positions.
    """
    for name in ("positions", "multipliers"):
        if name not in question.replies:
            return [question.needs(name)]
    inputs: Any = question.case.inputs
    proposed = vectors(inputs["proposed"])
    at = [
        y if pinned else x
        for x, y, pinned in zip(
            vectors(question.replies["positions"]), proposed, inputs["pinned"], strict=True
        )
    ]
    multipliers = [Fraction(number) for number in question.replies["multipliers"]]
    rows = _rows(inputs)
    found = _impacts(question, at, rows, multipliers)
    return found + _stationary(question, at, rows, multipliers)


def _rows(inputs: Any) -> list[_Row]:
    rows = []
    for j, normal in enumerate(vectors(inputs["normals"])):
        weights: dict[int, Fraction] = {}
        for k in range(4 * j, 4 * j + 4):
            vertex = inputs["nodes"][k]
            weights[vertex] = weights.get(vertex, Fraction(0)) + Fraction(inputs["weights"][k])
        rows.append(_Row(weights, normal))
    return rows


def _impacts(
    question: Question, at: Sequence[Vector], rows: Sequence[_Row], multipliers: Sequence[Fraction]
) -> list[Difference]:
    """Check sign, violation and complementarity of each impact."""
    inputs: Any = question.case.inputs
    name = "gap_scale" if "gap_scale" in question.expected else "scale"
    found = []
    for j, (row, multiplier) in enumerate(zip(rows, multipliers, strict=True)):
        gap = sum(
            (weight * dot(row.normal, at[i]) for i, weight in row.weights.items()), Fraction(0)
        )
        room = gap - Fraction(inputs["thickness"])
        push = multiplier * _stiffness(inputs, row)
        residual, tol = min(push, room), tolerance(question, j, name)
        if abs(residual) <= tol:
            continue
        if residual > 0:
            text = f"impact {j} pushes ({_number(multiplier)} kg) and is not in contact: it has "
            text += f"{_number(room)} m of room"
        elif room < push:
            text = f"constraint {j} is violated by {_number(-room)} m"
        else:
            text = f"multiplier {j} is negative: {_number(multiplier)} kg"
        difference = Difference("multipliers", text, (j,), None, _number(multiplier))
        found.append(difference._replace(tolerances=ratio(abs(residual), tol)))
    return found


def _stiffness(inputs: Any, row: _Row) -> Fraction:
    """Return K_jj [1/kg]: how far a multiplier of 1 kg opens the gap."""
    return sum(
        (
            weight**2 * dot(row.normal, row.normal) / Fraction(inputs["masses"][i])
            for i, weight in row.weights.items()
            if not inputs["pinned"][i]
        ),
        Fraction(0),
    )


def _stationary(
    question: Question, at: Sequence[Vector], rows: Sequence[_Row], multipliers: Sequence[Fraction]
) -> list[Difference]:
    """Check x - y = M^-1 A^T l at each unpinned vertex."""
    inputs: Any = question.case.inputs
    pushes = [[Fraction(0)] * 3 for _ in at]
    for row, multiplier in zip(rows, multipliers, strict=True):
        for i, weight in row.weights.items():
            for axis in range(3):
                pushes[i][axis] += weight * row.normal[axis] * multiplier
    found = []
    for i, (x, y) in enumerate(zip(at, vectors(inputs["proposed"]), strict=True)):
        if inputs["pinned"][i]:
            continue
        mass = Fraction(inputs["masses"][i])
        for axis in range(3):
            moved, own = x[axis] - y[axis], pushes[i][axis] / mass
            tol = tolerance(question, 3 * i + axis)
            if abs(moved - own) > tol:
                text = f"x - y is {_number(moved)} m and M^-1 A^T l is {_number(own)} m"
                difference = Difference("positions", text, (i, axis), None, _number(x[axis]))
                found.append(difference._replace(tolerances=ratio(abs(moved - own), tol)))
    return found


def _number(number: Fraction) -> float:
    return ratio(number, Fraction(1)) if number >= 0 else -ratio(-number, Fraction(1))

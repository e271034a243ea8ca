"""Vectors of fractions, and the four nodes of a pair."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TypeAlias

Vector: TypeAlias = "tuple[Fraction, ...]"


def vectors(numbers: Sequence[float]) -> list[Vector]:
    """Return the rows of three of a flat list."""
    exact = [Fraction(number) for number in numbers]
    return [tuple(exact[i : i + 3]) for i in range(0, len(exact), 3)]


def dot(a: Iterable[Fraction], b: Iterable[Fraction]) -> Fraction:
    """Return the scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def combined(weights: Sequence[float | Fraction], nodes: Sequence[Vector]) -> Vector:
    """Return sum_k a_k x_k."""
    exact = [Fraction(weight) for weight in weights]
    return tuple(dot(exact, column) for column in zip(*nodes, strict=True))


def at_time(start: Sequence[Vector], end: Sequence[Vector], time: float) -> list[Vector]:
    """Return (1 - t) x(0) + t x(1) for each node."""
    t = Fraction(time)
    return [
        tuple((1 - t) * a + t * b for a, b in zip(node, moved, strict=True))
        for node, moved in zip(start, end, strict=True)
    ]

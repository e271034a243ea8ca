"""Random numbers that are the same with every version of Python, exact in float32."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import TypeVar

Item = TypeVar("Item")


def shuffled(random: Random, items: Sequence[Item]) -> list[Item]:
    """Return items in a random order."""
    result = list(items)
    for i in range(len(result) - 1, 0, -1):
        j = int((i + 1) * random.random())
        result[i], result[j] = result[j], result[i]
    return result


def dyadic(random: Random, low: float, high: float, bits: int = 10) -> float:
    """Return a random multiple of 2^-bits from low to high."""
    steps = 2**bits
    return round((low + (high - low) * random.random()) * steps) / steps

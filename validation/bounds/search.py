"""Search the input at which an error comes closest to its bound."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Floats

# Draws an input; changes one; returns the exact error of the computed value over its bound.
Draw: TypeAlias = Callable[[np.random.Generator], Any]
Change: TypeAlias = Callable[[np.random.Generator, Any], Any]
Ratio: TypeAlias = Callable[[Any], float]

RESTARTS = 8  # inputs from which the search climbs, besides the best of the first draws


class Bound(NamedTuple):
    """A derived bound.

    Attributes:
        name: What is bounded.
        file: Where the bound is derived, from the root of the repository.
        sentence: What the bound covers, and which part of it one call can reach.
        ratio: The error of an input over the bound, computed exactly.
        draw: Draws an input.
        change: Changes an input a little.
        written: Returns the text of an input.
        parsed: Returns the input of a text.
        tries: Number of inputs that the study tries.
    """

    name: str
    file: str
    sentence: str
    ratio: Ratio
    draw: Draw
    change: Change
    written: Callable[[Any], str]
    parsed: Callable[[str], Any]
    tries: int


class Found(NamedTuple):
    """The result of a search: the largest ratio, its input, and how many inputs were tried."""

    ratio: float
    worst: Any
    tried: int


def search(bound: Bound, seed: int, tries: int) -> Found:
    """Search for the largest error over the bound.

    A quarter of the tries are random draws. The others climb from the best of them and from some
    more: a change is kept if the ratio does not fall, so that the search crosses plateaus.

    Args:
        bound: The bound.
        seed: Seed of all draws.
        tries: Number of inputs.
    """
    rng = np.random.default_rng(seed)
    first = [bound.draw(rng) for _ in range(max(RESTARTS, tries // 4))]
    rated = sorted(((bound.ratio(x), i) for i, x in enumerate(first)), reverse=True)
    best = Found(rated[0][0], first[rated[0][1]], tries)
    climbs = (tries - len(first)) // RESTARTS
    for ratio, i in rated[:RESTARTS]:
        x = first[i]
        for _ in range(climbs):
            other = bound.change(rng, x)
            value = bound.ratio(other)
            if value >= ratio:
                ratio, x = value, other
        if ratio > best.ratio:
            best = Found(ratio, x, tries)
    return best


def hard_floats(rng: np.random.Generator, n: int) -> Floats:
    """Draw numbers near 1 in magnitude whose rounding errors are large.

    The rounding of a number just above a power of two is twice as large, relative to it, as that of
    one just below. So mantissas are drawn near 1 half of the time, with a few random last bits.
    """
    low = 1.0 + rng.integers(0, 64, n) * 2.0**-52
    low += rng.integers(0, 2, n) * 2.0 ** -rng.integers(2, 30, n)
    values = np.where(rng.random(n) < 0.5, low, 1.0 + rng.random(n))
    values *= 2.0 ** rng.integers(-2, 1, n)
    return np.where(rng.random(n) < 0.5, values, -values)


def change_floats(rng: np.random.Generator, x: Floats) -> Floats:
    """Change one or two of the numbers: another number, other last bits, or another sign."""
    x = x.copy()
    for i in rng.integers(0, len(x), rng.integers(1, 3)):
        kind = rng.integers(4)
        if kind == 0:
            x[i] = hard_floats(rng, 1)[0]
        elif kind == 1:
            x[i] *= 1.0 + rng.integers(-8, 9) * 2.0**-52
        elif kind == 2:
            x[i] += (rng.random() - 0.5) * 2.0 ** -rng.integers(1, 50)
        else:
            x[i] = x[rng.integers(0, len(x))] * (-1.0) ** rng.integers(2)
    return x


def written_floats(x: Floats) -> str:
    """Return numbers as text, without rounding."""
    return " ".join(float(v).hex() for v in x)


def parsed_floats(text: str) -> Floats:
    """Return the numbers of a text of `written_floats`."""
    return np.array([float.fromhex(word) for word in text.split()])


def bound_of_floats(
    name: str, file: str, sentence: str, ratio: Callable[[Floats], float], draw: Draw
) -> Bound:
    """Return a bound whose inputs are arrays of floats."""
    return Bound(
        name, file, sentence, ratio, draw, change_floats, written_floats, parsed_floats, 20_000
    )

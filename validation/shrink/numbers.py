"""Make numbers simpler: fewer digits, small whole numbers, zero."""

from collections.abc import Callable, Iterator

import numpy as np

from izo_ref.base.arrays import AnyArray
from validation.shrink.search import Input, Search

DIGITS = 17
BITS = (1, 2, 4, 8, 12, 16, 24, 32, 44)


def length(values: AnyArray) -> int:
    """Return how many characters the numbers take, without the sign; zeros take none."""
    return sum(map(_length, np.asarray(values, float).ravel().tolist()))


def _length(value: float) -> int:
    if value == 0.0:
        return 0
    # powers of two are simple however many digits they have
    power = abs(np.frexp(value)[0]) == 0.5
    text = f"{abs(value):.17g}" if not power else "1e9"
    return min(len(text), len(repr(abs(value)).removesuffix(".0")))


def rounded(values: AnyArray) -> Iterator[AnyArray]:
    """Yield the numbers with few digits first, then with more, then with few bits."""
    size = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    if size == 0.0:
        return
    first = -int(np.floor(np.log10(size)))
    for digits in range(first - 1, first + DIGITS):
        with np.errstate(all="ignore"):
            made = np.round(values, digits) if abs(digits) < 300 else values
        if np.isfinite(made).all() or not np.isfinite(values).all():
            yield made
    for bits in BITS:
        mantissa, exponent = np.frexp(values)
        yield np.ldexp(np.round(np.ldexp(mantissa, bits)), exponent - bits)


def one_by_one(
    search: Search[Input],
    values: Callable[[Input], AnyArray],
    change: Callable[[Input, AnyArray], Input | None],
) -> bool:
    """Make each number of an array as simple as the failure allows.

    Args:
        search: The search.
        values: Returns the array of an input.
        change: Returns an input with another array; None if there is none.

    Returns:
        Whether any number became simpler.
    """
    better = False
    for place in np.ndindex(values(search.best).shape):
        value = float(values(search.best)[place])
        for simple in _simpler(value):
            array = values(search.best).copy()
            array[place] = simple
            if search.take(change(search.best, array)):
                better = True
                break
    return better


def _simpler(value: float) -> Iterator[float]:
    """Yield simpler numbers, the simplest first."""
    if value == 0.0 or not np.isfinite(value):
        return
    whole = [float(np.sign(value)), float(np.round(value))] if abs(value) < 1e6 else []
    near = [float(np.array(made)) for made in rounded(np.array(value))]
    seen = {value}
    for number in (0.0, *whole, *near):
        if number not in seen and _length(number) < _length(value):
            seen.add(number)
            yield number


def together(
    search: Search[Input],
    values: Callable[[Input], AnyArray],
    change: Callable[[Input, AnyArray], Input | None],
) -> bool:
    """Round a whole array to as few digits as the failure allows; return whether it changed."""
    before = values(search.best)
    return search.take_first(
        made
        for array in rounded(before)
        if length(array) < length(before) and (made := change(search.best, array)) is not None
    )

"""Numbers in files that are texts."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import AnyFloats, Indices, Positions


def float_of(token: bytes) -> float | None:
    """Return the number that a text says, which may be infinite or NaN.

    Args:
        token: The text.

    Returns:
        The number; None if the text is no number.
    """
    try:
        return None if b"_" in token else float(token)
    except ValueError:
        return None


def floats_of(tokens: list[bytes]) -> list[float] | int:
    """Return the numbers that texts say, which may be infinite or NaN.

    Args:
        tokens: The texts.

    Returns:
        The numbers; or which of the texts is the first that is no number.
    """
    try:
        numbers = [float(token) for token in tokens]
        if not any(b"_" in token for token in tokens):  # Python reads 1_0 as ten
            return numbers
    except ValueError:
        pass
    return next(i for i, token in enumerate(tokens) if float_of(token) is None)


def with_numbers(content: bytes, spans: Indices, old: AnyFloats, new: Positions) -> bytes:
    """Replace numbers in a text where they changed.

    Each is written with as many digits as it takes to read it back exactly.

    Args:
        content: The text.
        spans: (n, 3, 2) i8, where each number begins and ends; from the first to the last.
        old: (n, 3) f4 or f8, the numbers in the text.
        new: (n, 3) f8, the numbers to write; floats of the type of `old`.
    """
    changed = old != new
    parts, done = list[bytes](), 0
    as_text = repr if old.dtype == np.float64 else _single
    for (begin, end), number in zip(spans[changed].tolist(), new[changed].tolist(), strict=True):
        parts += (content[done:begin], as_text(number).encode())
        done = end
    parts.append(content[done:])
    return b"".join(parts)


def _single(number: float) -> str:
    """Return the shortest text of a float32.

    A reader may take the nearest float64 first and round that. Where it would get another float32
    so, all digits are written.
    """
    text = str(np.float32(number))
    return text if np.float32(float(text)) == number else repr(number)

"""Values that a user may pass: what is a number, and how a message shows a value."""

from __future__ import annotations

import reprlib
from typing import Any

import numpy as np

LONGEST = 80  # characters of a value that a message shows
PRINTED_BITS = 256  # of an integer; Python refuses to print some that are longer

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = LONGEST


def shown(value: Any) -> str:
    """Return a value as a message shows it: on one short line, whatever `repr` does with it.

    Args:
        value: Anything.
    """
    if isinstance(value, int) and value.bit_length() > PRINTED_BITS:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, np.ndarray) and value.size > 4:
        return f"an array of shape {value.shape} and type {value.dtype}"
    try:
        text = " ".join(_REPR.repr(value).split())
    except Exception:  # `repr` of the caller's own class, or of an integer that is too long
        return f"a value of type {type(value).__name__}"
    return text if len(text) <= LONGEST else text[:LONGEST] + "..."


def plain_text(text: Any) -> str:
    """Return a text of others, such as a name in a file, without quotes where it is plain."""
    text = str(text)
    return text if text.isascii() and text.isprintable() and len(text) <= LONGEST else shown(text)


def real_number(value: Any) -> float | None:
    """Return a value as a float, which may be NaN or infinite; None if it is no real number.

    Numbers are integers, floats, and whatever converts itself to a float, as fractions and arrays
    without dimensions do. Flags, texts, times, complex numbers and masked numbers are none, and
    neither is a number beyond the largest float.

    Args:
        value: Anything.
    """
    if isinstance(value, (bool, str, bytes)) or getattr(value, "ndim", 0) != 0:
        return None
    if isinstance(value, np.ndarray):
        if np.ma.is_masked(value):
            return None
        value = value[()]
    if isinstance(value, np.generic) and not isinstance(value, (np.integer, np.floating)):
        return None
    if not (hasattr(type(value), "__float__") or hasattr(type(value), "__index__")):
        return None
    try:
        with np.errstate(all="ignore"):
            return float(value)
    except MemoryError:
        raise
    except Exception:  # an integer too large for a float, or the code of the caller's own class
        return None


def as_array(values: Any) -> np.ndarray[Any, Any]:
    """Return values as numpy sees them.

    Args:
        values: Anything.

    Raises:
        ValueError: They are no array: rows of several lengths, masked entries, or a class of the
            caller whose conversion fails.
    """
    try:
        if isinstance(values, np.ma.MaskedArray):
            return _unmasked(values)
        if isinstance(values, (list, tuple)) and any(
            isinstance(row, np.ma.MaskedArray) and np.ma.is_masked(row) for row in values
        ):
            raise ValueError("some entries are masked; replace them by numbers first")
        return np.asarray(values)
    except MemoryError:  # it is no fault of the values
        raise
    except Exception as error:  # the conversion may run code of the caller's own class
        raise ValueError(f"{error}".strip() or type(error).__name__) from None


def _unmasked(values: Any) -> np.ndarray[Any, Any]:
    masked = int(np.ma.count_masked(values))
    if masked:
        raise ValueError(f"{masked} entries are masked; replace them by numbers first")
    return np.asarray(values.data)

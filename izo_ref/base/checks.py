"""Check what the user passes in: each error says what was expected, what was found and where."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Ints, Masses
from izo_ref.base.errors import (
    IndexRangeError,
    MassError,
    NonFiniteError,
    OptionError,
    ShapeError,
    ThicknessError,
)


def floats(name: str, values: Any, shape: tuple[int | None, ...]) -> Floats:
    """Copy numbers into a float64 array, and check that all of them are finite.

    Args:
        name: The name of the array in messages.
        values: Anything that numpy converts to an array.
        shape: The expected shape; None stands for any size.

    Returns:
        A copy of the given shape, f8.

    Raises:
        ShapeError: The values are no numbers, or have another shape.
        NonFiniteError: A number is NaN or infinite; names the first one.
    """
    array = _shaped(name, values, shape)
    finite = np.isfinite(array)
    if not finite.all():
        bad = np.argwhere(~finite)
        first = tuple(bad[0].tolist())
        raise NonFiniteError(
            f"{name}: expected finite numbers, found {len(bad)} that are not, the first is "
            f"{array[first]} at {list(first)}"
        )
    return array


def indices(name: str, values: Any, width: int, n: int) -> Ints:
    """Copy indices into an int32 array, and check that each is from 0 to n - 1.

    Args:
        name: The name of the array in messages.
        values: Anything that numpy converts to an array.
        width: The expected number of columns.
        n: The number of things that the indices point at.

    Returns:
        (m, width) i4, a copy.

    Raises:
        ShapeError: The values are not integers, or do not have this number of columns.
        IndexRangeError: An index is out of range; names the first row with one.
    """
    array = np.asarray(values)
    if array.size == 0 and array.ndim <= 2:
        return np.empty((0, width), np.int32)
    if array.ndim != 2 or array.shape[1] != width:
        raise ShapeError(f"{name}: expected shape (n, {width}), got {array.shape}")
    if array.dtype.kind not in "iu":
        raise ShapeError(f"{name}: expected integers, got {array.dtype}")
    bad = np.flatnonzero(((array < 0) | (array >= n)).any(axis=1))
    if len(bad):
        raise IndexRangeError(
            f"{name}: expected indices from 0 to {n - 1}, found {len(bad)} rows with others, the "
            f"first is row {bad[0]}: {array[bad[0]].tolist()}"
        )
    return np.array(array, dtype=np.int32, order="C")


def masses(values: Any, n: int, *, infinite_allowed: bool = False) -> Masses:
    """Copy masses into a float64 array, and check that all of them are positive.

    Args:
        values: Anything that numpy converts to an array [kg].
        n: The expected number of masses.
        infinite_allowed: Whether a mass may be infinite.

    Returns:
        (n,) f8 [kg], a copy.

    Raises:
        ShapeError: The values are not n numbers.
        NonFiniteError: A mass is NaN or infinite, and that is not allowed; names the first one.
        MassError: A mass is not positive; names the first one.
    """
    array = _shaped("masses", values, (n,)) if infinite_allowed else floats("masses", values, (n,))
    bad = np.flatnonzero(~(array > 0.0))
    if len(bad):
        raise MassError(
            f"masses: expected numbers > 0 [kg], found {len(bad)} that are not, the first is "
            f"{array[bad[0]]} at vertex {bad[0]}"
        )
    return array


def flags(name: str, values: Any, n: int) -> Flags:
    """Copy flags into a bool array.

    Args:
        name: The name of the array in messages.
        values: Anything that numpy converts to an array of bool.
        n: The expected number of flags.

    Returns:
        (n,) b1, a copy.

    Raises:
        ShapeError: The values are not n values of type bool.
    """
    array = np.array(values)
    if array.shape != (n,) or array.dtype != bool:
        raise ShapeError(f"{name}: expected shape ({n},) bool, got {array.shape} {array.dtype}")
    return array


def thickness(value: Any) -> float:
    """Check that a thickness is a positive, finite number of metres, and return it.

    Raises:
        ThicknessError: It is not.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not (number > 0.0 and math.isfinite(number)):
        raise ThicknessError(f"thickness: expected a finite number > 0 [m], got {value!r}")
    return number


def device(name: Any) -> str:
    """Check that a device is `cpu`, `cuda` or `auto`, and return it.

    Raises:
        OptionError: It is not.
    """
    if name not in ("cpu", "auto", "cuda"):
        raise OptionError(f"device: expected 'cpu', 'auto' or 'cuda', got {name!r}")
    return name


def _shaped(name: str, values: Any, shape: tuple[int | None, ...]) -> Floats:
    text = "(" + ", ".join("n" if size is None else str(size) for size in shape) + ")"
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ShapeError(f"{name}: expected numbers of shape {text}: {error}") from None
    fits = array.ndim == len(shape) and all(
        want is None or want == found for want, found in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ShapeError(f"{name}: expected shape {text}, got {array.shape}")
    return array

"""Checks of what comes in: each error names what was expected, what was found and where."""

import math

import numpy as np

from izo_ref.base.errors import (
    IndexRangeError,
    MassError,
    NonFiniteError,
    OptionError,
    ShapeError,
    ThicknessError,
)


def floats(name, values, shape):
    """A copy as f8 of the given shape (None: any size), finite throughout.

    Raises:
        ShapeError, NonFiniteError.
    """
    array = _shaped(name, values, shape)
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        first = tuple(bad[0].tolist())
        raise NonFiniteError(
            f"{name}: expected finite numbers, found {len(bad)} others, the first "
            f"{array[first]} at {list(first)}"
        )
    return array


def indices(name, values, width, n):
    """A copy as (m, width) i4, each 0 to n - 1.

    Raises:
        ShapeError, IndexRangeError.
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
            f"{name}: expected indices 0 to {n - 1}, found {len(bad)} rows with others, the "
            f"first row {bad[0]}: {array[bad[0]].tolist()}"
        )
    return np.array(array, dtype=np.int32, order="C")


def masses(values, n, *, infinite_allowed=False):
    """A copy as (n,) f8 [kg], all positive.

    Raises:
        ShapeError, NonFiniteError, MassError.
    """
    array = _shaped("masses", values, (n,)) if infinite_allowed else floats("masses", values, (n,))
    bad = np.flatnonzero(~(array > 0.0))
    if len(bad):
        raise MassError(
            f"masses: expected numbers > 0 [kg], found {len(bad)} others, the first "
            f"{array[bad[0]]} at vertex {bad[0]}"
        )
    return array


def flags(name, values, n):
    """A copy as (n,) bool.

    Raises:
        ShapeError.
    """
    array = np.array(values)
    if array.shape != (n,) or array.dtype != bool:
        raise ShapeError(f"{name}: expected shape ({n},) bool, got {array.shape} {array.dtype}")
    return array


def thickness(value) -> float:
    """A positive, finite number of metres.

    Raises:
        ThicknessError.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not (number > 0.0 and math.isfinite(number)):
        raise ThicknessError(f"thickness: expected a number > 0 [m], got {value!r}")
    return number


def device(name) -> str:
    """`cpu`, `cuda` or `auto`.

    Raises:
        OptionError.
    """
    if name not in ("cpu", "auto", "cuda"):
        raise OptionError(f"device: expected 'cpu', 'auto' or 'cuda', got {name!r}")
    return name


def _shaped(name, values, shape):
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

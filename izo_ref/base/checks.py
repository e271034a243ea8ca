"""Check what the user passes in: each error says what was expected, what was found and where."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, Faces, Flags, Floats, Ints, Masses
from izo_ref.base.errors import (
    DegenerateFaceError,
    IndexRangeError,
    MassError,
    NonFiniteError,
    OptionError,
    ShapeError,
    ThicknessError,
)
from izo_ref.base.options import DEFAULTS, Options


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
    array = _rectangular(name, values, width)
    if array.size == 0 and array.ndim <= 2:
        return np.empty((0, width), np.int32)
    if array.ndim != 2 or array.shape[1] != width:
        raise ShapeError(f"{name}: expected shape (n, {width}), got {array.shape}{_advice(array)}")
    array = _integers(name, array)
    bad = np.flatnonzero(((array < 0) | (array >= n)).any(axis=1))
    if len(bad):
        from_one = array.min() == 1 and array.max() == n
        raise IndexRangeError(
            f"{name}: expected indices from 0 to {n - 1}, found {len(bad)} rows with others, the "
            f"first is row {bad[0]}: {array[bad[0]].tolist()}"
            + (f". They seem to count from 1: pass {name} - 1" if from_one else "")
        )
    return np.array(array, dtype=np.int32, order="C")


def faces(values: Any, n: int) -> Faces:
    """Copy faces into an int32 array, and check that each has three different vertices.

    Args:
        values: Anything that numpy converts to an array.
        n: The number of vertices.

    Returns:
        (m, 3) i4, a copy.

    Raises:
        ShapeError: The values are not integers, or do not have three columns.
        IndexRangeError: An index is out of range; names the first row with one.
        DegenerateFaceError: A face has the same vertex twice; names the first one.
    """
    array = indices("faces", values, 3, n)
    a, b, c = array.T
    repeated = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(repeated):
        first = repeated[0]
        raise DegenerateFaceError(
            f"faces: expected three different vertices each, found {len(repeated)} with a "
            f"repeated one, the first face {first}: {array[first].tolist()}"
        )
    return array


def _rectangular(name: str, values: Any, width: int) -> AnyArray:
    """Return values as an array; name the first row that has another length than `width`."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, OverflowError) as error:
        lengths = [len(row) if hasattr(row, "__len__") else 1 for row in values]
        other = next((i for i, length in enumerate(lengths) if length != width), None)
        found = f": {error}" if other is None else f", got {lengths[other]} in row {other}"
        raise ShapeError(f"{name}: expected {width} indices in each row{found}") from None
    return array


def _advice(array: AnyArray) -> str:
    """Return what to do with an array of faces that does not have three columns."""
    if array.ndim == 1 and array.size % 3 == 0:
        return ". If every three indices are a triangle, pass the array as reshape(-1, 3)"
    if array.ndim == 2 and array.shape[1] == 4:
        return ". Divide each quad [a, b, c, d] into the triangles [a, b, c] and [a, c, d]"
    if array.ndim == 2 and array.shape[1] > 4:
        return ". Divide each polygon into triangles"
    return ""


def _integers(name: str, array: AnyArray) -> AnyArray:
    """Return an array of integers; floats and objects are taken if they are whole numbers."""
    if array.dtype.kind in "iu":
        return array
    if array.dtype.kind in "fO":
        try:
            numbers = array.astype(np.float64)
        except (TypeError, ValueError, OverflowError):
            numbers = np.full(array.shape, np.nan)
        other = np.argwhere(~(np.abs(numbers) < 2.0**31) | (numbers != np.round(numbers)))
        if len(other) == 0:
            return numbers.astype(np.int64)
        first = tuple(other[0].tolist())
        raise ShapeError(
            f"{name}: expected integers, found {len(other)} other values, the first is "
            f"{array[first]!r} at {list(first)}"
        )
    raise ShapeError(f"{name}: expected integers, got {array.dtype}")


def masses(
    values: Any, n: int, pinned: Flags | None = None, *, infinite_allowed: bool = False
) -> Masses:
    """Copy masses into a float64 array, and check that all of them are positive.

    Args:
        values: Anything that numpy converts to an array [kg]; one number stands for n equal ones,
            and a column of numbers is taken too.
        n: The expected number of masses.
        pinned: (n,) b1, vertices whose masses are not used, or None. If such a mass is not positive
            and finite, it becomes NaN.
        infinite_allowed: Whether a mass may be infinite.

    Returns:
        (n,) f8 [kg], a copy.

    Raises:
        ShapeError: The values are not n numbers.
        NonFiniteError: A mass is NaN or infinite, and that is not allowed; names the first one.
        MassError: A mass is not positive; names the first one.
    """
    if np.ndim(values) == 0:
        values = np.full(n, values)
    elif np.shape(values) == (n, 1):
        values = np.reshape(values, n)
    array = _shaped("masses", values, (n,))
    if pinned is not None:
        array[pinned & ~((array > 0.0) & (array < np.inf))] = np.nan
    used = np.ones(n, bool) if pinned is None else ~pinned
    if not infinite_allowed:
        floats("masses", np.where(used, array, 1.0), (n,))
    bad = np.flatnonzero(used & ~(array > 0.0))
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
        values: Anything that numpy converts to an array of bool; numbers that are 0 or 1 are
            taken too.
        n: The expected number of flags.

    Returns:
        (n,) b1, a copy.

    Raises:
        ShapeError: The values are not n flags.
    """
    array = np.array(values)
    if array.shape == (n,) and array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all():
        array = array.astype(bool)
    if array.shape != (n,) or array.dtype != bool:
        raise ShapeError(
            f"{name}: expected shape ({n},) bool, one flag for each vertex, got {array.shape} "
            f"{array.dtype}"
        )
    return array


def choice(name: str, value: Any, choices: tuple[str, ...]) -> None:
    """Check that an argument is one of some words.

    Raises:
        OptionError: It is not.
    """
    if value not in choices:
        raise OptionError(f"{name}: expected one of {choices}, got {value!r}")


def function(name: str, value: Any) -> None:
    """Check that an argument is a function or None.

    Raises:
        OptionError: It is something else.
    """
    if value is not None and not callable(value):
        raise OptionError(f"{name}: expected a function or None, got {type(value).__name__}")


def scene(value: Any) -> None:
    """Check that a value has the arrays of a scene.

    Raises:
        OptionError: It does not, for example because it is the name of a file.
    """
    if not all(hasattr(value, name) for name in ("positions_t0", "positions_t1", "faces", "edges")):
        raise OptionError(
            f"scene: expected a Scene, got {type(value).__name__}. Make one with "
            "izo_ref.Scene(positions_t0, positions_t1, faces)"
        )


def options(value: Any) -> Options:
    """Check that a value is an `Options` or None, and return it, or the defaults for None.

    Raises:
        OptionError: It is something else.
    """
    if value is None:
        return DEFAULTS
    if not isinstance(value, Options):
        raise OptionError(
            f"options: expected Options, got {type(value).__name__}. Pass "
            "izo_ref.Options(name=value, ...)"
        )
    return value


def weld(value: Any) -> float | None:
    """Check that a tolerance for welding is None or a finite number of metres, not negative.

    Raises:
        OptionError: It is not.
    """
    if value is None:
        return None
    try:
        number = math.nan if isinstance(value, (bool, np.bool_)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not 0.0 <= number < math.inf:
        raise OptionError(
            f"weld: expected None or a finite number >= 0 [m], got {value!r}. Pass weld=0 to join "
            "vertices that coincide exactly"
        )
    return number


def thickness(value: Any) -> float:
    """Check that a thickness is a positive, finite number of metres, and return it.

    Raises:
        ThicknessError: It is not.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
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
        kind = np.asarray(values).dtype
        if kind.kind in "cSU":
            raise TypeError(f"got {kind}")
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(f"{name}: expected real numbers of shape {text}: {error}") from None
    fits = array.ndim == len(shape) and all(
        want is None or want == found for want, found in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ShapeError(f"{name}: expected shape {text}, got {array.shape}")
    return array

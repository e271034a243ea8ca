"""Check arrays that the user passes in: each error says what was expected and found, and where."""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, Faces, Flags, Floats, Ints, Masses
from izo_ref.base.errors import (
    DegenerateFaceError,
    IndexRangeError,
    MassError,
    NonFiniteError,
    ShapeError,
)
from izo_ref.base.values import as_array, real_number, shown

REAL = "fiu"  # kinds of types whose values are real numbers; bool and times are none


def numbers(name: str, values: Any, shape: tuple[int | None, ...]) -> Floats:
    """Copy real numbers into a float64 array; they may be NaN or infinite.

    Args:
        name: The name of the array in messages.
        values: Anything that numpy converts to an array.
        shape: The expected shape; None stands for any size.

    Returns:
        A copy of the given shape, f8; numbers of other types are rounded.

    Raises:
        ShapeError: The values are no real numbers, or have another shape.
    """
    text = "(" + ", ".join("n" if size is None else str(size) for size in shape) + ")"
    try:
        array = as_array(values)
    except ValueError as error:
        raise ShapeError(f"{name}: expected real numbers of shape {text}: {error}") from None
    if array.dtype.kind not in REAL + "O":
        raise ShapeError(f"{name}: expected real numbers of shape {text}, got {array.dtype}")
    fits = array.ndim == len(shape) and all(
        want is None or want == found for want, found in zip(shape, array.shape, strict=True)
    )
    if not fits:
        found = f"{array.shape}" if array.ndim or array.dtype != object else shown(values)
        raise ShapeError(f"{name}: expected shape {text}, got {found}")
    if array.dtype == object:
        return _converted(name, array)
    with np.errstate(over="ignore", under="ignore"):  # of long doubles
        return np.array(array, dtype=np.float64, order="C")


def _converted(name: str, array: AnyArray) -> Floats:
    """Return an array of objects as floats; name the first object that is no real number."""
    out = np.empty(array.shape)
    for place, value in np.ndenumerate(array):
        number = real_number(value)
        if number is None:
            raise ShapeError(
                f"{name}: expected real numbers, got {shown(value)} at {list(place)}; "
                "convert the array to float64 first"
            )
        out[place] = number
    return out


def floats(name: str, values: Any, shape: tuple[int | None, ...]) -> Floats:
    """Copy real numbers into a float64 array, and check that all of them are finite.

    Args:
        name: The name of the array in messages.
        values: Anything that numpy converts to an array.
        shape: The expected shape; None stands for any size.

    Returns:
        A copy of the given shape, f8; numbers of other types are rounded.

    Raises:
        ShapeError: The values are no real numbers, or have another shape.
        NonFiniteError: A number is NaN or infinite; names the first one.
    """
    array = numbers(name, values, shape)
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
    if array.shape != (0,) and (array.ndim != 2 or array.shape[1] != width):
        raise ShapeError(f"{name}: expected shape (n, {width}), got {array.shape}{_advice(array)}")
    array = _integers(name, array).reshape(-1, width)
    bad = np.flatnonzero(((array < 0) | (array >= n)).any(axis=1))
    if len(bad):
        from_one = array.min() == 1 and array.max() == n
        raise IndexRangeError(
            f"{name}: expected indices from 0 to {n - 1}, found {len(bad)} rows with others, the "
            f"first is row {bad[0]}: [{', '.join(map(shown, array[bad[0]].tolist()))}]"
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
        return as_array(values)
    except ValueError as error:
        other = _other_row(values, width)
        found = f": {error}" if other is None else f", got {other}"
        raise ShapeError(f"{name}: expected {width} indices in each row{found}") from None


def _other_row(values: Any, width: int) -> str | None:
    """Return what is in the first row that has not `width` entries, if there is one."""
    if not isinstance(values, (list, tuple)):
        return None
    for i, row in enumerate(values):
        length = len(row) if isinstance(row, (list, tuple, np.ndarray)) else 1
        if length != width:
            return f"{length} in row {i}"
    return None


def _advice(array: AnyArray) -> str:
    """Return what to do with an array of faces that does not have three columns."""
    if array.ndim == 1 and array.size and array.size % 3 == 0:
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
    if array.dtype.kind not in "fO":
        raise ShapeError(f"{name}: expected integers, got {array.dtype}")
    if array.dtype == object:
        whole = np.array([_is_whole(value) for value in array.flat], bool).reshape(array.shape)
    else:
        whole = np.isfinite(array) & (array == np.round(array))
    other = np.argwhere(~whole)
    if len(other):
        first = tuple(other[0].tolist())
        raise ShapeError(
            f"{name}: expected integers, found {len(other)} other values, the first is "
            f"{shown(array[first])} at {list(first)}"
        )
    if array.dtype == object or array.size == 0:
        out = np.empty(array.shape, object)  # integers of any size, until their range is checked
        out.ravel()[:] = [int(value) for value in array.flat]
        return out
    with np.errstate(over="ignore"):  # of long doubles
        return array.astype(np.float64)


def _is_whole(value: Any) -> bool:
    """Return whether an object is a whole number, of any size."""
    if type(value) is int:
        return True
    number = real_number(value)
    try:
        return number is not None and number.is_integer() and int(value) == value
    except MemoryError:
        raise
    except Exception:  # the code of the caller's own class
        return False


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
        ShapeError: The values are not n real numbers.
        NonFiniteError: A mass is NaN or infinite, and that is not allowed; names the first one.
        MassError: A mass is not positive; names the first one.
    """
    number = real_number(values)
    try:
        array = np.full(n, number) if number is not None else as_array(values)
    except ValueError as error:
        raise ShapeError(f"masses: expected {n} real numbers, or one: {error}") from None
    array = numbers("masses", array.reshape(n) if array.shape == (n, 1) else array, (n,))
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
    try:
        array = as_array(values)
    except ValueError as error:
        raise ShapeError(f"{name}: expected shape ({n},) bool: {error}") from None
    if array.shape != (n,) or array.dtype.kind not in REAL + "b":
        raise ShapeError(
            f"{name}: expected shape ({n},) bool, one flag for each vertex, got {array.shape} "
            f"{array.dtype}"
        )
    if array.dtype == bool:
        return array.view(np.uint8) != 0  # memory of others may hold other bytes than 0 and 1
    other = np.flatnonzero((array != 0) & (array != 1))
    if len(other):
        raise ShapeError(
            f"{name}: expected shape ({n},) bool, found {len(other)} flags of {array.dtype} that "
            f"are neither 0 nor 1, the first is {shown(array[other[0]])} at {other[0]}"
        )
    return array != 0

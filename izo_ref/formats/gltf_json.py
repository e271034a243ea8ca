"""Take values from the JSON of glTF, which may hold anything in a damaged file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import FilePath


@contextmanager
def errors(path: FilePath) -> Iterator[None]:
    """Turn errors of a damaged document into errors of the file.

    Args:
        path: The file that is read or written.

    Raises:
        FileFormatError: What it holds is not what glTF allows.
    """
    try:
        yield
    except KeyError as error:
        raise FileFormatError(f"{path}: expected {error} in an object") from None
    except (ValueError, TypeError, AttributeError, IndexError, OverflowError) as error:
        raise FileFormatError(f"{path}: {error}") from None


def item(holder: Any, key: str, index: Any) -> Any:
    """Return an object in one of the lists of the JSON.

    Raises:
        ValueError: There is none with this number.
    """
    things = many(holder, key)
    if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(things):
        raise ValueError(f"expected a number below {len(things)} of {key}, found {index!r:.40}")
    if not isinstance(things[index], dict):
        raise ValueError(f"expected an object as number {index} of {key}")
    return things[index]


def many(holder: Any, key: str) -> list[Any]:
    """Return a list of the JSON; an empty one if it is not there.

    Raises:
        ValueError: It is no list.
    """
    found = holder.get(key, [])
    if not isinstance(found, list):
        raise ValueError(f"expected a list of {key}, found {found!r:.40}")
    return found


def whole(holder: Any, key: str, default: int | None = None) -> int:
    """Return a number of the JSON that is whole and not negative.

    Raises:
        ValueError: It is not.
    """
    found = holder.get(key, default)
    if not isinstance(found, int) or isinstance(found, bool) or found < 0:
        raise ValueError(f"expected a whole number as {key}, found {found!r:.40}")
    return found


def numbers(holder: Any, key: str, count: int, default: tuple[float, ...]) -> Floats:
    """Return a list of numbers of the JSON, (count,) f8.

    Raises:
        ValueError: It has another length, or holds what is no number.
    """
    found = holder.get(key, list(default))
    is_list = isinstance(found, list) and len(found) == count
    if not is_list or not all(type(number) in (int, float) for number in found):
        raise ValueError(f"expected {count} numbers as {key}, found {found!r:.40}")
    return np.array(found, np.float64)

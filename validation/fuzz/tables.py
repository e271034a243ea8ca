"""Values as the contract sees them: what numpy makes of a value, in Python's own numbers."""

from typing import Any, NamedTuple

import numpy as np

DEPTH = 64  # of lists in lists, more than arrays of numpy have


class Table(NamedTuple):
    """An array as a list of Python objects, row by row."""

    shape: tuple[int, ...]
    items: list[Any]


def table_of(value: Any, depth: int = 0) -> Table | None:
    """Return what numpy makes of a value; None if it makes no array of it, or masks an entry."""
    if isinstance(value, np.ma.MaskedArray) and bool(np.any(np.ma.getmaskarray(value))):
        return None
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biufOUSMmcV" or value.dtype.kind == "V":
            return Table(value.shape, [b"no number"] * value.size)
        if value.dtype.kind not in "biufO":
            return Table(value.shape, [b"no number"] * max(value.size, 1))
        return Table(value.shape, list(value.flat))
    if isinstance(value, (range, memoryview)):
        value = list(value)
    if not isinstance(value, (list, tuple)):
        return Table((), [value])
    if depth > DEPTH:
        return None
    rows = [table_of(item, depth + 1) for item in value]
    if any(row is None for row in rows):
        return None
    known = [row for row in rows if row is not None]
    if any(row.shape != known[0].shape for row in known):
        return None
    inner = known[0].shape if known else ()
    items = [item for row in known for item in row.items]
    plain = (bool, np.bool_, float, int, np.number)
    is_plain = depth == 0 and all(isinstance(x, plain) and not abs(x) >= 2**63 for x in items)
    if is_plain and not all(isinstance(x, (bool, np.bool_)) for x in items):
        items = [+x if isinstance(x, bool) else x for x in items]  # as numpy does in a list
    return Table((len(known), *inner), items)


def mixes_flags(table: Table) -> bool:
    """Return whether numbers and flags are in one list, of which numpy makes numbers."""
    flags = [isinstance(item, (bool, np.bool_)) for item in table.items]
    return any(flags) and not all(flags)


def number_of(item: Any) -> float | None:
    """Return a real number, rounded to a float; None for everything else."""
    if isinstance(item, (bool, np.bool_, str, bytes, complex, np.complexfloating)):
        return None
    if isinstance(item, (np.datetime64, np.timedelta64, np.ndarray)):
        return None
    if not hasattr(item, "__float__"):
        return None
    try:
        with np.errstate(all="ignore"):
            return float(item)
    except Exception:
        return None


def is_empty_flags(value: Any) -> bool:
    """Return whether a value is an array of flags without any; no page says what that is."""
    return isinstance(value, np.ndarray) and value.size == 0 and value.dtype == bool


def is_ordinary(table: Table) -> bool:
    """Return whether all coordinates are 0, or of sizes for which no limit is documented."""
    sizes = [abs(number_of(item) or 0.0) for item in table.items]
    return all(size == 0.0 or 1e-20 < size < 1e20 for size in sizes)

"""The contract of the door, as the documentation states it: slow, obvious, with Python's numbers.

Each function returns the ways in which an input is wrong. None stands for an input of which the
documentation says only that it may be refused.
"""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from izo_ref.base.options import CHOICES, MOST, PRESET_METHODS, RULES, SWEEPS
from validation.fuzz.tables import (
    Table,
    is_empty_flags,
    is_ordinary,
    mixes_flags,
    number_of,
    table_of,
)
from validation.fuzz.trial import Wrong

MODES = {
    "initial_intersections": ("raise", "ratchet", "exclude"),
    "prescribed": ("exclude", "block"),
}
WHOLE = ("max_iterations", "relinearize", "max_steps", "small_zone")
TOLERANCES = ("relinearize_gain", "gap_tolerance", "violation_tolerance")


def real_wrong(name: str, value: Any, shape: tuple[int | None, ...]) -> Wrong | None:
    """Return what is wrong with an array of finite real numbers."""
    table = table_of(value)
    if table is None or len(table.shape) != len(shape):
        return Wrong(name)
    if any(want not in (None, found) for want, found in zip(shape, table.shape, strict=True)):
        return Wrong(name)
    numbers = [number_of(item) for item in table.items]
    if any(number is None for number in numbers):
        return Wrong(name)
    for i, number in enumerate(numbers):
        if number is None or not math.isfinite(number):
            return Wrong(name, str([int(k) for k in np.unravel_index(i, table.shape)]))
    return None


def index_wrong(name: str, value: Any, width: int, n: int) -> Wrong | None:
    """Return what is wrong with rows of indices from 0 to n - 1."""
    table = table_of(value)
    if table is None:
        return Wrong(name)
    if table.shape != (0,) and (len(table.shape) != 2 or table.shape[1] != width):
        return Wrong(name)
    for i, item in enumerate(table.items):
        if type(item) is int:
            continue
        number = number_of(item)
        if isinstance(item, (bool, np.bool_, str, bytes, complex, np.complexfloating)):
            return Wrong(name)  # the message names the type of the array
        if number is None or not math.isfinite(number) or number != int(number) or number != item:
            return Wrong(name, str([i // width, i % width]))
    for i, item in enumerate(table.items):
        if not 0 <= int(item) < n:
            return Wrong(name, f"row {i // width}")
    return None


def face_wrong(value: Any, n: int) -> Wrong | None:
    """Return what is wrong with faces."""
    wrong = index_wrong("faces", value, 3, n)
    if wrong is not None:
        return wrong
    table = table_of(value)
    assert table is not None
    items = [int(item) for item in table.items]
    for i in range(0, len(items), 3):
        if len(set(items[i : i + 3])) < 3:
            return Wrong("faces", f"face {i // 3}")
    return None


def flags_of(value: Any, n: int) -> list[bool] | None:
    """Return n flags; None if the value is something else."""
    table = table_of(value)
    if table is None or table.shape != (n,):
        return None
    if isinstance(value, np.ndarray) and value.dtype == object:
        return None
    flags = []
    for item in table.items:
        if isinstance(item, (bool, np.bool_)):
            flags.append(bool(item))
        elif number_of(item) in (0.0, 1.0):
            flags.append(number_of(item) == 1.0)
        else:
            return None
    return flags


def mass_wrong(value: Any, n: int, pinned: Sequence[bool], infinite: bool = False) -> Wrong | None:
    """Return what is wrong with masses; those of pinned vertices may be any numbers."""
    if isinstance(value, np.ndarray) and value.ndim == 0 and not np.ma.is_masked(value):
        value = value.item()
    number = number_of(value)
    if number is not None:
        value = [number] * n
    table = table_of(value)
    if table is None or table.shape not in ((n,), (n, 1)):
        return Wrong("masses")
    numbers = [number_of(item) for item in table.items]
    if any(number is None for number in numbers):
        return Wrong("masses")
    used = [x for x, fixed in zip(numbers, pinned, strict=True) if not fixed and x is not None]
    if any(math.isnan(x) or (math.isinf(x) and not (infinite and x > 0)) for x in used):
        return Wrong("masses")
    if any(x <= 0.0 for x in used):
        return Wrong("masses")
    finite = [x for x in used if math.isfinite(x)]
    if finite and Fraction(min(finite)) * 2**100 < Fraction(max(finite)):
        return Wrong("masses")
    return None


def positive_wrong(name: str, value: Any, least: float = math.ulp(0.0)) -> Wrong | None:
    """Return what is wrong with one finite number of at least `least`."""
    if isinstance(value, np.ndarray):
        value = value.item() if value.ndim == 0 and not np.ma.is_masked(value) else None
    number = number_of(value)
    right = number is not None and math.isfinite(number) and number >= least
    return None if right else Wrong(name)


def scene_wrongs(arguments: Mapping[str, Any]) -> list[Wrong] | None:
    """Return what is wrong with the arguments of a `Scene`, but for where its mesh is."""
    wrongs = [
        Wrong(name)
        for name, choices in MODES.items()
        if name in arguments
        and not (isinstance(arguments[name], str) and arguments[name] in choices)
    ]
    start, end, faces = (arguments[k] for k in ("positions_t0", "positions_t1", "faces"))
    wrong = real_wrong("positions_t0", start, (None, 3))
    table = table_of(start)
    if wrong is not None or table is None:
        mixed = _mixed(arguments, "positions_t0")
        return None if mixed else [*wrongs, wrong or Wrong("positions_t0")]
    n = table.shape[0]
    given = arguments.get("pinned")
    pinned = [False] * n if given is None else flags_of(given, n)
    found = [
        real_wrong("positions_t1", end, (n, 3)),
        face_wrong(faces, n),
        Wrong("pinned") if pinned is None else None,
    ]
    if arguments.get("masses") is not None and pinned is not None:
        found.append(mass_wrong(arguments["masses"], n, pinned))
    if arguments.get("weld") is not None:
        found.append(positive_wrong("weld", arguments["weld"], 0.0))
    wrongs += [one for one in found if one is not None]
    named = ("positions_t0", "positions_t1")
    tables = [table_of(arguments[k]) for k in named]
    is_open = any(t is not None and not is_ordinary(t) for t in tables)
    # a vertex that is welded to a pinned one is pinned, and its mass may be anything
    welded = arguments.get("weld") is not None
    sure = [wrong for wrong in wrongs if not (welded and wrong.argument == "masses")]
    is_open |= len(sure) < len(wrongs)
    if _mixed(arguments, *named, "faces", "masses", "pinned"):
        return None
    return None if is_open and not sure else wrongs


def _mixed(arguments: Mapping[str, Any], *names: str) -> bool:
    given = [arguments[name] for name in names if name in arguments]
    tables = [table_of(value) for value in given]
    mixed = any(table is not None and mixes_flags(table) for table in tables)
    return mixed or any(map(is_empty_flags, given))


def options_wrongs(given: Mapping[str, Any]) -> list[Wrong]:
    """Return what is wrong with the arguments of `Options`."""
    wrongs = []
    for name, value in given.items():
        if name in CHOICES:
            text = isinstance(value, str) and value in CHOICES[name]
            if not text and not (value is None and name == "preset"):
                wrongs.append(Wrong(name))
        elif name == "plan":
            names = value if isinstance(value, (tuple, list, set, frozenset)) else None
            whole = isinstance(value, str) and value in ("needed", "everything")
            known = names is not None and all(isinstance(x, str) and x in RULES for x in names)
            if not (whole or known):
                wrongs.append(Wrong("plan"))
        else:
            number = None if isinstance(value, np.ndarray) else number_of(value)
            plain = isinstance(value, (int, float, np.integer, np.floating))
            if not plain or number is None or not _fits(name, number):
                wrongs.append(Wrong(name))
    if not wrongs:
        wrongs += _excluded_combinations(given)
    return wrongs


def _fits(name: str, number: float) -> bool:
    if name in WHOLE:
        return 0 <= number <= MOST and number == int(number)
    if name == "relinearize_budget":
        return number >= 0.0
    if name == "thickness_fraction":
        return 0.0 < number < math.inf
    return 0.0 <= number < math.inf


def _excluded_combinations(given: Mapping[str, Any]) -> list[Wrong]:
    preset, method = given.get("preset"), given.get("method", "auto")
    if preset is not None and method not in ("auto", PRESET_METHODS[preset]):
        return [Wrong("preset")]
    lagrangian = method in (*SWEEPS, "gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
    if given.get("precision") == "float32" and preset is None and not lagrangian:
        return [Wrong("precision")]
    return []


def zone_wrongs(arguments: Mapping[str, Any]) -> list[Wrong]:
    """Return what is wrong with the arguments of a `ZoneProblem`."""
    table = table_of(arguments["proposed"])
    wrong = real_wrong("proposed", arguments["proposed"], (None, 3))
    if wrong is not None or table is None:
        return [Wrong("proposed", wrong.place if wrong else "")]
    n = table.shape[0]
    found = [
        index_wrong("nodes", arguments["nodes"], 4, n),
        mass_wrong(arguments["masses"], n, [False] * n, infinite=True),
        positive_wrong("thickness", arguments["thickness"]),
    ]
    nodes = table_of(arguments["nodes"])
    k = 0 if nodes is None or not nodes.shape else nodes.shape[0]
    found += [
        real_wrong("weights", arguments["weights"], (k, 4)),
        real_wrong("normals", arguments["normals"], (k, 3)),
    ]
    weights = table_of(arguments["weights"])
    if found[3] is None and weights is not None:
        found.append(_sum_wrong([Fraction(number_of(x) or 0.0) for x in weights.items]))
    for name in ("weights", "normals"):
        rows = table_of(arguments[name])
        if all(one is None for one in found) and rows is not None:
            found.append(_size_wrong(name, rows))
    return [one for one in found if one is not None]


def _sum_wrong(weights: list[Fraction]) -> Wrong | None:
    """Return the first impact whose weights do not sum to zero, up to float32 rounding."""
    for i in range(0, len(weights), 4):
        row = weights[i : i + 4]
        if abs(sum(row)) > max(map(abs, row)) / 2**20:
            return Wrong("weights", f"impact {i // 4}")
    return None


def _size_wrong(name: str, rows: Table) -> Wrong | None:
    """Return the first row that is neither zero nor of a size that the solvers take."""
    width = rows.shape[1]
    for i in range(0, len(rows.items), width):
        largest = max(abs(number_of(x) or 0.0) for x in rows.items[i : i + width])
        if largest and not 2.0**-100 <= largest <= 2.0**100:
            return Wrong(name, f"row {i // width}")
    return None

"""Check what the user passes in: each error says what was expected, what was found and where.

`array_checks.py` has the checks of arrays.
"""

from __future__ import annotations

import math
from collections.abc import Set
from typing import Any

import numpy as np

from izo_ref.base.array_checks import faces, flags, floats, indices, masses, numbers
from izo_ref.base.errors import OptionError, ThicknessError
from izo_ref.base.options import DEFAULTS, RULES, Options
from izo_ref.base.records import SceneArrays
from izo_ref.base.values import real_number, shown

__all__ = [
    "choice",
    "device",
    "faces",
    "flag",
    "flags",
    "floats",
    "function",
    "indices",
    "masses",
    "numbers",
    "options",
    "rules",
    "scene",
    "thickness",
    "tolerance",
    "weld",
]


def choice(name: str, value: Any, choices: tuple[str, ...]) -> None:
    """Check that an argument is one of some words.

    Raises:
        OptionError: It is not.
    """
    if not isinstance(value, str) or value not in choices:
        raise OptionError(f"{name}: expected one of {choices}, got {shown(value)}")


def flag(name: str, value: Any) -> bool:
    """Check that an argument is True or False, and return it.

    Raises:
        OptionError: It is something else.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise OptionError(f"{name}: expected True or False, got {shown(value)}")
    return bool(value)


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
    if not all(hasattr(value, name) for name in SceneArrays.__annotations__):
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
    number = real_number(value)
    if number is None or not 0.0 <= number < math.inf:
        raise OptionError(
            f"weld: expected None or a finite number >= 0 [m], got {shown(value)}. Pass weld=0 to "
            "join vertices that coincide exactly"
        )
    return number


def thickness(value: Any) -> float:
    """Check that a thickness is a positive, finite number of metres, and return it.

    Raises:
        ThicknessError: It is not.
    """
    number = real_number(value)
    if number is None or not 0.0 < number < math.inf:
        raise ThicknessError(f"thickness: expected a finite number > 0 [m], got {shown(value)}")
    return number


def tolerance(name: str, value: Any) -> float:
    """Check that a tolerance is a finite number that is not negative, and return it.

    Raises:
        OptionError: It is not.
    """
    number = real_number(value)
    if number is None or not 0.0 <= number < math.inf:
        raise OptionError(f"{name}: expected a finite number >= 0, got {shown(value)}")
    return number


def rules(value: Any) -> Set[str]:
    """Check that a value is a set with names of `RULES`, and return it.

    Raises:
        OptionError: It is something else, or has another name.
    """
    if not isinstance(value, Set):
        raise OptionError(f"rules: expected a set with names of {tuple(RULES)}, got {shown(value)}")
    unknown = [name for name in value if not isinstance(name, str) or name not in RULES]
    if unknown:
        raise OptionError(
            f"rules: expected a set with names of {tuple(RULES)}, got {shown(unknown[0])} in it"
        )
    return value


def device(name: Any) -> str:
    """Check that a device is `cpu`, `cuda` or `auto`, and return it.

    Raises:
        OptionError: It is not.
    """
    if not isinstance(name, str) or name not in ("cpu", "auto", "cuda"):
        raise OptionError(f"device: expected 'cpu', 'auto' or 'cuda', got {shown(name)}")
    return name

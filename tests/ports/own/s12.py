"""Stage S12 by our own compiled functions."""

from typing import Any

import numpy as np

import izo_ref


def rows(flat: list[Any], kind: type) -> Any:
    """Return rows of three numbers; a list that cannot be divided so stays flat."""
    array = np.array(flat, kind)
    return array.reshape(-1, 3) if len(array) % 3 == 0 else array


def resolved(inputs: dict[str, Any], dtype: str, **arguments: Any) -> izo_ref.Result:
    """Return the result of a step; `arguments` are those of `resolve`."""
    if dtype != "f8":
        raise NotImplementedError("steps are resolved in float64")
    scene = izo_ref.Scene(
        rows(inputs["positions_t0"], float),
        rows(inputs["positions_t1"], float),
        rows(inputs["faces"], int),
        np.array(inputs["masses"]),
        np.array(inputs["pinned"], bool),
    )
    return izo_ref.resolve(scene, inputs["thickness"], **arguments)


def answer(inputs: dict[str, Any], dtype: str, **arguments: Any) -> dict[str, Any]:
    """Return the end positions, and whether their path is certified free."""
    result = resolved(inputs, dtype, **arguments)
    return {
        "free": int(result.certificate.free),
        "positions": result.positions.ravel().tolist(),
    }

"""Stage S4 by our own compiled functions."""

from typing import Any

import numpy as np

from izo_ref.base.records import Impacts
from izo_ref.zones.selection import select_impacts


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return which impacts are selected."""
    if dtype != "f8":
        raise NotImplementedError("times of impact are float64")
    n = len(inputs["toi"])
    impacts = Impacts(
        np.array(inputs["nodes"], np.int32).reshape(n, 4),
        np.array(inputs.get("edge_edge_impacts", [0] * n), bool),
        np.array(inputs["toi"], np.float64),
        np.array(inputs.get("weights", [0.0] * 4 * n), np.float64).reshape(n, 4),
        np.zeros((n, 3)),
    )
    deep = np.full(n, inputs["selection"] == "deep")
    selection = "independent" if inputs["selection"] == "deep" else inputs["selection"]
    selected = select_impacts(impacts, np.array(inputs["pinned"], bool), selection, deep)
    return {"selected": selected.astype(int).tolist()}

"""Stage S3 by our own functions."""

from typing import Any

import numpy as np

from izo_ref.detection.formulas.advance import advance
from izo_ref.detection.formulas.frame import impact_frame
from tests.ports.own.s02 import relative


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the weights and the normal of a pair at a time.

    `impact_frame` takes the last direction that separated the sides; `advance` finds it.
    """
    if dtype != "f8":
        raise NotImplementedError("only float64")
    is_edge_edge = bool(inputs["is_edge_edge"])
    path = *relative(inputs["start"]), *relative(inputs["end"])
    with np.errstate(all="ignore"):  # compiled code does not warn, either
        direction = advance(is_edge_edge, *path)[2]
        weights, normal = impact_frame(is_edge_edge, *path, np.float64(inputs["toi"]), direction)
    return {"weights": [float(w) for w in weights], "normal": [float(x) for x in normal]}

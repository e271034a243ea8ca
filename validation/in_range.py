"""Results to judge, brought into the range of the judges with their scene (`base/sizes.py`)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from izo_ref.app.files import SavedResult
from izo_ref.base import checks
from izo_ref.base.arrays import AnyFloats, Positions
from izo_ref.base.sizes import path_in_range
from izo_ref.base.units import Units, times_power
from izo_ref.scene import Scene


def result_in_range(
    scene: Scene,
    twin: Scene,
    units: Units,
    result: SavedResult | None,
    known: Mapping[str, Positions] | None,
) -> tuple[SavedResult | None, dict[str, Positions]]:
    """Return a result and the known ones in the units of a scene of ordinary size.

    Args:
        scene: The scene, in the units of the caller.
        twin: The scene of ordinary size.
        units: The powers of two by which it was multiplied.
        result: The result to judge, or None.
        known: `{name: positions}` of other results.

    Raises:
        ShapeError: The positions of a result do not fit the scene.
        NonFiniteError: A position is not finite.
        SizeError: A position is too large or too small to compute with.
    """

    def scaled(positions: Positions) -> Any:
        ends = checks.floats("positions", positions, scene.positions_t0.shape)
        path_in_range(scene, ends)  # raises an error if a power of two would change the path
        same = (ends == scene.positions_t1).all(axis=1)
        moved: AnyFloats = np.where(
            same[:, None], twin.positions_t1, times_power(ends, units.length)
        )
        is_single = np.asarray(positions).dtype == np.float32  # its rounding is judged
        return moved.astype(np.float32) if is_single else moved

    others = {name: scaled(positions) for name, positions in (known or {}).items()}
    if result is None:
        return None, others
    multipliers, thickness = result.multipliers, result.thickness
    return result._replace(
        positions=scaled(result.positions),
        thickness=None if thickness is None else times_power(thickness, units.length),
        multipliers=None
        if multipliers is None
        else times_power(multipliers, units.length + units.mass),
    ), others

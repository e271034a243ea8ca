"""Results of a scene of extraordinary size, in the units of the caller (`base/units.py`).

Each number is multiplied by its own power of two: positions, gaps and the thickness by that of
lengths, objectives by its square, multipliers by that of lengths and of masses. A number that no
float can hold becomes infinite or zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from izo_ref.base.devices import implementation
from izo_ref.base.records import SceneArrays
from izo_ref.base.sizes import positions_back
from izo_ref.base.units import Units, times_power
from izo_ref.certificate.certify import certify_path
from izo_ref.loop.iterate import Iteration
from izo_ref.loop.verdict import statuses_of_zones, verdict


def iterations_back(
    on_iteration: Callable[[Iteration], object] | None, units: Units
) -> Callable[[Iteration], object] | None:
    """Return a function that passes records of iterations on in the units of the caller.

    Args:
        on_iteration: The function of the caller, or None.
        units: The powers of two by which the scene was multiplied.
    """
    if on_iteration is None:
        return None
    return lambda record: on_iteration(_iteration_back(record, units))


def _iteration_back(record: Iteration, units: Units) -> Iteration:
    return record._replace(objective=times_power(record.objective, -2 * units.length))


def result_back(
    result: Any, scene: SceneArrays, twin: SceneArrays, units: Units, device: str
) -> Any:
    """Return a result in the units of the caller.

    The path is certified anew. Positions of a scene of 1e-300 m may be rounded when they are
    multiplied back, and the certificate has to hold for the bits that are returned.

    Args:
        result: The `Result` of the scene of ordinary size.
        scene: The scene of the caller.
        twin: The scene of ordinary size.
        units: The powers of two by which it was multiplied.
        device: The device that certifies the path.

    Raises:
        SizeError: A vertex ends where no float is; names the first one.
    """
    positions = positions_back(scene, twin, result.positions, units)
    certificate = certify_path(scene, positions, result.options.rules, device)
    facts = certificate, result.scaled_back, result.residuals, result.options
    status, converged, feasible = verdict(*facts)
    on_gpu = result.positions_on_gpu
    if on_gpu is not None:
        to_gpu = implementation("cuda", np.asarray, "izo_ref.base.gpu_arrays:to_gpu")
        on_gpu = to_gpu(positions)
    return replace(
        result,
        positions=positions,
        positions_on_gpu=on_gpu,
        status=status,
        objective=times_power(result.objective, -2 * units.length),
        thickness=times_power(result.thickness, -units.length),
        converged=converged,
        feasible=feasible,
        multipliers=times_power(result.multipliers, -units.length - units.mass),
        residuals=[
            judged._replace(violation_m=times_power(judged.violation_m, -units.length))
            for judged in result.residuals
        ],
        zone_statuses=statuses_of_zones(result.zones, *facts),
        certificate=certificate,
        time_free=certificate.time_free,
        history=[_iteration_back(record, units) for record in result.history],
    )

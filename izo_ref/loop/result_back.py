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
from izo_ref.loop.ending import at_start, certified_ending
from izo_ref.loop.iterate import Iteration
from izo_ref.loop.time_plan import TimePlan
from izo_ref.loop.verdict import judge_zones, statuses_of_zones, verdict
from izo_ref.zones.objective import objective


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
    result: Any, scene: SceneArrays, twin: SceneArrays, units: Units, device: str, times: TimePlan
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
        times: The stages of the run.

    Raises:
        SizeError: A vertex ends where no float is; names the first one.
    """
    positions, stayed = positions_back(scene, twin, result.positions, units), times.stays
    more = result.scaled_back, result.options.rules, device, times
    positions, certificate, scaled_back = certified_ending(scene, positions, *more)
    times.end()
    if times.stays and not stayed:  # the zones of the twin were judged at another end
        ends, own = at_start(twin), (result.impacts, result.multipliers, result.zones)
        judged = judge_zones(twin, *own, result.thickness, ends)
        result = replace(result, residuals=judged, objective=objective(twin, ends))
    facts = certificate, scaled_back, result.residuals, result.options
    status, converged, feasible = verdict(*facts, times.reason)
    on_gpu = result.positions_on_gpu
    if on_gpu is not None:
        send = implementation("cuda", np.asarray, "izo_ref.base.gpu_arrays:shared_copy")
        on_gpu = send(positions)
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
        scaled_back=scaled_back,
        reason=times.reason,
        time_free=certificate.time_free,
        history=[_iteration_back(record, units) for record in result.history],
    )

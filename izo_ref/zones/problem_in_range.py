"""Zone problems of ordinary size, and their answers in the units of the caller.

`base/units.py` says what is ordinary, and why a power of two changes no bits.
"""

from __future__ import annotations

import copy
import math

import numpy as np

from izo_ref.base.errors import SizeError
from izo_ref.base.units import (
    AS_THEY_ARE,
    LENGTHS,
    Units,
    into_range,
    mass_exponent,
    times_power,
)
from izo_ref.zones.problem import Residuals, ZoneProblem, ZoneSolution


def problem_in_range(problem: ZoneProblem) -> tuple[ZoneProblem, Units]:
    """Return a zone problem of ordinary size, and the powers of two by which it was multiplied.

    Args:
        problem: The problem, in the units of the caller.

    Returns:
        The problem itself if its size is ordinary, else another one.

    Raises:
        SizeError: The lengths differ too much from each other to compute with them.
    """
    largest = float(np.abs(problem.proposed).max(initial=0.0))
    units = Units(
        into_range(max(largest, problem.thickness), LENGTHS), mass_exponent(problem.masses)
    )
    if units == AS_THEY_ARE:
        return problem, units
    twin = copy.copy(problem)
    twin.proposed = times_power(problem.proposed, units.length)
    twin.thickness = times_power(problem.thickness, units.length)
    twin.masses = times_power(problem.masses, units.mass)
    changed = times_power(twin.proposed, -units.length) != problem.proposed
    if changed.any() or times_power(twin.thickness, -units.length) != problem.thickness:
        least = math.ldexp(1.0, -1022 - units.length)
        raise SizeError(
            f"proposed: expected a thickness and coordinates that are 0 or at least {least:.3g} "
            f"[m] beside lengths of up to {max(largest, problem.thickness):.3g} m, got smaller ones"
        )
    return twin, units


def residuals_back(residuals: Residuals, units: Units) -> Residuals:
    """Return residuals in the units of the caller; all but one have none."""
    return residuals._replace(violation_m=times_power(residuals.violation_m, -units.length))


def solution_back(solution: ZoneSolution, units: Units) -> ZoneSolution:
    """Return the solution of a problem in the units of the caller.

    A number that no float can hold becomes infinite or zero.
    """
    trace = solution.trace
    if trace is not None:
        factors = np.array([-2 * units.length - units.mass, -units.length])
        trace = times_power(trace, factors)
    return solution._replace(
        positions=times_power(solution.positions, -units.length),
        displacements=times_power(solution.displacements, -units.length),
        multipliers=times_power(solution.multipliers, -units.length - units.mass),
        residuals=residuals_back(solution.residuals, units),
        trace=trace,
    )

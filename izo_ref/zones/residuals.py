"""The residuals that judge every solver."""

from __future__ import annotations

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Multipliers, Positions
from izo_ref.base.units import AS_THEY_ARE, times_power
from izo_ref.zones.problem import Residuals, ZoneProblem, require_problem
from izo_ref.zones.problem_in_range import problem_in_range, residuals_back
from izo_ref.zones.serial.residuals import judge_zones
from izo_ref.zones.system import ZoneSystem


def residuals(problem: ZoneProblem, positions: Positions, multipliers: Multipliers) -> Residuals:
    """Judge positions and multipliers of a zone without asking the solver.

    The gap between p(x) and the dual function at l+ = max(l, 0) is, for any x and l,
    1/2 |M (x - y) - A^T l+|^2 + l+ . (A x - d), with the norm of M^-1. In this form nothing
    cancels. The second term is computed with |A x - d|, so that a violation cannot hide a gap.

    The floors bound the error of a frozen gap at positions that are rounded to floats, if the exact
    positions satisfy the constraint with equality: `GAP_ROUNDING` of `zones/serial/residuals.py`
    times the largest coordinate. Far from the origin that is more than any tolerance.

    Args:
        problem: The zone problem.
        positions: (n, 3) f8 [m], the positions x.
        multipliers: (n_impacts,) f8 [kg], the multipliers l.

    Returns:
        The residuals.

    Raises:
        ShapeError: `positions` or `multipliers` have the wrong shape or type. NaN and infinity are
            numbers here: the residuals of such an answer are infinite.
        SizeError: The lengths of the problem differ too much from each other.
        OptionError: `problem` is no `ZoneProblem`.

    Source: docs/method section 8; S. Boyd, L. Vandenberghe, Convex Optimization (2004), 5.5.
    """
    require_problem(problem)
    positions = checks.numbers("positions", positions, problem.proposed.shape)
    multipliers = checks.numbers("multipliers", multipliers, (len(problem.nodes),))
    problem, units = problem_in_range(problem)
    if units != AS_THEY_ARE:
        positions = times_power(positions, units.length)
        multipliers = times_power(multipliers, units.length + units.mass)
    whole = ZoneSystem(
        np.array([0, len(problem.nodes)]),
        np.array([0, len(problem.proposed)]),
        problem.nodes,
        problem.weights,
        problem.normals,
        problem.proposed,
        problem.masses,
        problem.thickness,
    )
    return residuals_back(residuals_of_zones(whole, positions, multipliers)[0], units)


def residuals_of_zones(
    system: ZoneSystem, positions: Positions, multipliers: Multipliers
) -> list[Residuals]:
    """Return the `residuals` of zones that lie side by side.

    Args:
        system: The zones. They share pinned vertices only, which may be anywhere.
        positions: (n, 3) f8 [m], the positions x.
        multipliers: (n_impacts,) f8 [kg], the multipliers l.
    """
    rows = np.empty((len(system.impact_offsets) - 1, len(Residuals._fields)))
    judge_zones(
        *system,
        np.ascontiguousarray(positions, np.float64),
        np.ascontiguousarray(multipliers, np.float64),
        rows,
    )
    return [Residuals(*row) for row in rows.tolist()]

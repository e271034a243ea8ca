"""Bound the distance of a zone's answer to the optimum; the bound holds in spite of rounding.

In scaled variables the zone problem is: minimise 1/2 |z|^2 subject to C z >= s, where each row of C
has unit length. The objective is strongly convex with modulus 1. So for a z that satisfies all
constraints, and for any l >= 0,

    |z - z*|^2 <= 2 gap = |z - C^T l|^2 + 2 l . (C z - s).                            (1)

Two things prevent (1) from being a bound for the answer of a solver. The answer satisfies its
constraints only to rounding. And where a constraint with a positive multiplier l has a slack of e,
(1) gives sqrt(2 l e), which is far more than the true distance of about e. So z is first moved onto
the active constraints J:

* If the rows of J are independent, let sigma be their smallest singular value. Then there is a
  point at a distance of |w| with C_J (z - w) = s_J exactly. w is computed in floats; the residual
  that is left, and its rounding, are covered by (residual + rounding) / sigma more. If that point
  satisfies the other constraints, the second term of (1) vanishes there for an l that is positive
  on J alone:
      |z - z*| <= |w| + |z - w - C^T l|.
  Near the optimum the two terms are the distances across and along the active constraints. These
  are orthogonal, so the bound is at most sqrt 2 times the true distance, plus rounding.
* Otherwise z is moved along a direction in which all constraints of J open, so far that every
  constraint holds in spite of rounding, and (1) is evaluated there. The bound is then no smaller
  than about the square root of the rounding, 2e-7 |z*|. It is larger where rows of J are nearly
  opposed.

Both bounds hold, so the smaller one is returned; infinity if neither can be computed. Equal impacts
count as one constraint.

Source: docs/method section 8; S. Boyd, L. Vandenberghe, Convex Optimization (2004), 9.1.2.
"""

from __future__ import annotations

import math

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import AnyInts, Flags, Floats, Multipliers, Positions
from izo_ref.base.units import times_power
from izo_ref.zones.problem import ZoneProblem, require_problem
from izo_ref.zones.problem_in_range import problem_in_range
from izo_ref.zones.scaled_zone import ScaledZone, U, norm

# Largest number of active constraints for which singular values are computed: that takes 0.2 s for
# this many, on 2 cores.
DENSE_ROWS = 1024
# How often constraints that turn out to be active are added.
ROUNDS = 8


def distance_bound(
    problem: ZoneProblem,
    positions: Positions,
    multipliers: Multipliers,
    displacements: Floats | None = None,
) -> float:
    """Return an upper bound of the mass-weighted distance of positions to the optimum of a zone.

    Args:
        problem: The zone problem.
        positions: (n, 3) f8 [m], the positions to judge, whatever computed them.
        multipliers: (n_impacts,) f8 [kg], multipliers for the objective 1/2 sum m |x - y|^2. They
            say which constraints to take for active. They may be inexact, and need not come from
            a solver.
        displacements: (n, 3) f8 [m], positions less the proposed positions, if they are known more
            exactly than the positions are. The bound is then for them, whatever `positions` are.

    Returns:
        An upper bound of sqrt(sum m |x - x*|^2) [m kg^1/2]. It is infinity if no bound can be
        computed. That is so where a pinned vertex is not at its proposed position, where an impact
        names a vertex twice, and where numbers overflow.

    Raises:
        ShapeError: An array has the wrong shape or type.
        SizeError: The lengths of the problem differ too much from each other.
        OptionError: `problem` is no `ZoneProblem`.
    """
    require_problem(problem)
    positions = checks.numbers("positions", positions, problem.proposed.shape)
    multipliers = checks.numbers("multipliers", multipliers, (len(problem.nodes),))
    if displacements is not None:
        displacements = checks.numbers("displacements", displacements, positions.shape)
    problem, units = problem_in_range(problem)
    if units.length != 0:
        positions = times_power(positions, units.length)
        if displacements is not None:
            displacements = np.asarray(times_power(displacements, units.length))
    if displacements is None:
        displacements = positions - problem.proposed
    if not (np.isfinite(displacements).all() and np.isfinite(multipliers).all()):
        return math.inf
    if displacements[np.isinf(problem.masses)].any() or _names_a_vertex_twice(problem.nodes):
        return math.inf
    with np.errstate(over="ignore", invalid="ignore"):  # the results are checked instead
        zone = ScaledZone(problem, displacements)
        if not zone.is_sound():
            return math.inf
        # the bound has the unit m kg^1/2, and the exponent of masses is even
        return times_power(_bound(zone, multipliers), -units.length - units.mass // 2)


def _names_a_vertex_twice(nodes: AnyInts) -> bool:
    in_order = np.sort(nodes, axis=1)
    return bool((in_order[:, 1:] == in_order[:, :-1]).any())


def _bound(zone: ScaledZone, multipliers: Multipliers) -> float:
    """Choose the active constraints, and return the smaller of the two bounds."""
    if len(zone.slack) == 0:
        return _rounded_up(norm(zone.z))
    clamped = np.maximum(multipliers, 0.0)
    pushes = np.bincount(zone.constraint_of.ravel(), clamped, len(zone.slack))
    pushes *= zone.lengths
    active = (pushes > 0.0) & (pushes > zone.slack)
    across = zone.correction(active)
    for _ in range(ROUNDS):
        slack, error = zone.moved(across)
        wanting = (slack < -error) & ~active
        if not wanting.any():
            break
        active |= wanting
        across = zone.correction(active)
    pushes = np.where(active, pushes, 0.0)
    bounds = (
        _bound_on_active(zone, active, across, pushes),
        _bound_inside(zone, active, across, pushes),
    )
    return min(bound if bound >= 0.0 else math.inf for bound in bounds)  # NaN is no bound


def _bound_on_active(zone: ScaledZone, active: Flags, across: Floats, pushes: Floats) -> float:
    """Return the first bound: z is moved onto independent active constraints.

    Args:
        zone: The zone.
        active: (k,) b1.
        across: (3 n_unpinned,) f8, the step w that brings active constraints to zero slack.
        pushes: (k,) f8, multipliers of the scaled constraints, 0 where they are not active.

    Returns:
        The bound; infinity if this bound cannot be computed.
    """
    count = int(active.sum())
    if count > DENSE_ROWS:
        return math.inf
    slack, error = zone.moved(across)
    beyond, multipliers = 0.0, pushes
    if count:
        matrix = zone.matrix[active]
        values, vectors = np.linalg.eigh((matrix @ matrix.T).toarray())
        # Entries have an error of 24 u, so the matrix one of 24 u times count. Eigenvalues have a
        # rounding of the order of u times the norm (at most count) times count; 8 covers its
        # factor.
        smallest = values[0] - (24 + 8 * count) * count * U
        if not smallest > 0.0:
            return math.inf
        residual = norm(slack[active]) + norm(error[active])
        beyond = residual / math.sqrt(smallest)
        fitted = np.zeros_like(pushes)
        fitted[active] = vectors @ ((vectors.T @ (matrix @ (zone.z - across))) / values)
        multipliers = np.maximum(fitted, 0.0)
    # the length of a row differs from 1 by a few u
    if not (slack - error - (1.0 + 1e-9) * beyond >= 0.0)[~active].all():
        return math.inf
    point = zone.z - across
    along = min(_misfit(zone, point, multipliers), _misfit(zone, point, pushes))
    return _rounded_up(norm(across) + 2.0 * beyond + along)


def _misfit(zone: ScaledZone, z: Floats, pushes: Floats) -> float:
    """Return a bound of |z - C^T pushes| that covers its rounding."""
    pulled, error = zone.pulled(pushes)
    return norm(z - pulled) + error + 5 * U * norm(z)


def _bound_inside(zone: ScaledZone, active: Flags, across: Floats, pushes: Floats) -> float:
    """Return the second bound: z is moved to where every constraint holds; the gap is taken there.

    The arguments and the result are those of `_bound_on_active`.
    """
    slack, error = zone.moved(across)
    missing = np.maximum(error - slack, 0.0)
    step = across
    if missing.any():
        chosen = active | (missing > 0.0)
        direction = zone.opening(chosen)
        opened = zone.matrix @ direction
        if not (opened[missing > 0.0] > 0.0).all():
            return math.inf
        # twice as far as is missing, because moving has a rounding of its own
        step = across - 2.0 * direction * float(
            (missing / np.where(missing > 0.0, opened, 1.0)).max()
        )
        slack, error = zone.moved(step)
        if not (slack >= error).all():
            return math.inf
    products = 2.0 * float(pushes @ (slack + error))
    along = math.hypot(_misfit(zone, zone.z - step, pushes), math.sqrt(products))
    return _rounded_up(norm(step) + along)


def _rounded_up(length: float) -> float:
    """Return a length that covers the rounding of norms.

    The norm of n numbers has an error of (n + 4) u / 2: less than 1e-9 for 10^7 numbers.
    """
    return length * (1.0 + 1e-9)

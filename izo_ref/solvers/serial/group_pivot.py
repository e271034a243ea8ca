"""Block pivoting for one zone by a thread group, such as a block of a GPU.

It is the method of `solvers/pivoting.py`, which says where it is from: the set F of active
constraints is guessed, (C_F C_F^T + rho) u_F = s_F + rho v_F gives all multipliers, and constraints
on the wrong side change sides, by the same rules. Two things differ.

* The factors are kept in their envelope (`envelope.py`), with the constraints in an order along the
  zone (`group_order.py`), so that all threads follow one regular pattern.
* The last solution, if there is one, is only where the guess starts (`group_guess.py`).
"""

import math

import numpy as np

from izo_ref.base.arrays import Floats, Ints, Normals, Positions
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_maxima, group_sums
from izo_ref.solvers.serial.envelope import (
    SHIFT,
    SIDE,
    Envelope,
    factorize,
    fits,
    size_of,
    tile_at,
)
from izo_ref.solvers.serial.envelope_solve import solve
from izo_ref.solvers.serial.exchange_rules import (
    FALLS,
    MAX_STEPS,
    PATIENCE,
    RHO,
    STALLED_SLOP,
    TOLERATED_SLOP,
)
from izo_ref.solvers.serial.group_exchange import exchange, flag_wrong
from izo_ref.solvers.serial.group_guess import guess_active
from izo_ref.solvers.serial.group_memory import Memory, memory_of, vector_size
from izo_ref.solvers.serial.group_order import number_active, order_constraints
from izo_ref.solvers.serial.group_zone import Zone, add_gram_row, link_entries, product, pull
from izo_ref.solvers.serial.settings import LEAST_TOLERANCE
from izo_ref.solvers.serial.small_zone import Limits

NO_ROOM = -1  # a number of solves: the factor does not fit


@compiled
def group_pivot(
    group: ThreadGroup,
    begin: int,
    end: int,
    first: int,
    last: int,
    unknowns: Ints,
    coefficients: Floats,
    normals: Normals,
    rhs: Floats,
    lengths: Floats,
    positions: Positions,
    limits: Limits,
    near: Floats,
    numbers: Floats,
    indices: Ints,
    multipliers_out: Floats,
    z_out: Floats,
) -> tuple[bool, int]:
    """Solve the zone of the impacts begin..end and the unknowns first..last.

    Args:
        group: The threads that share the zone.
        begin: The zone's first impact.
        end: Its last impact + 1.
        first: The zone's first unknown.
        last: Its last unknown + 1.
        unknowns: (n_impacts, 4) i4, of all zones; < 0 for pinned vertices.
        coefficients: (n_impacts, 4) f8; with the normals, constraints of unit length.
        normals: (n_impacts, 3) f8.
        rhs: (n_impacts,) f8 [m kg^1/2], s.
        lengths: (n_impacts,) f8 [kg^-1/2], of the constraints before scaling.
        positions: (n_unknowns, 3) f8 [m], proposed positions of the unpinned vertices.
        limits: What counts as solved.
        near: f8, fast memory of any size that all threads see; it is used as far as it goes.
        numbers: f8, work space; `work_of_group_pivot` says how much. A zone whose factor does not
            fit is not solved.
        indices: i4, work space; `work_of_group_pivot` says how much.
        multipliers_out: (n_impacts,) f8 [m kg^1/2], u; begin..end are written. Before that, they
            have the last solution, or 0, from which the guess starts.
        z_out: (3 n_unknowns,) f8 [m kg^1/2]; the coordinates of first..last are written.

    Returns:
        Whether the zone is solved to the limits, and the number of solves, or NO_ROOM if its factor
        does not fit. If it is not solved, u and z are invalid.
    """
    n, n_vertices = end - begin, last - first
    zone = Zone(
        group,
        first,
        unknowns[begin:end],
        coefficients[begin:end],
        normals[begin:end],
        rhs[begin:end],
        indices[:n_vertices],
        indices[n_vertices : n_vertices + 4 * n],
    )
    size = vector_size(n, n_vertices)
    vectors, factors = numbers[:size], numbers[size:]
    if size <= near.shape[0]:
        vectors, near = near[:size], near[size:]
    memory = memory_of(n, n_vertices, vectors, indices[n_vertices + 4 * n :])
    largest, longest = 0.0, 0.0
    for j in range(group.rank(), n, group.size()):
        value = zone.rhs[j]
        # nothing satisfies a NaN; `max` would ignore it
        largest = max(largest, value if value < np.inf else np.inf)
        longest = max(longest, lengths[begin + j])
    # this wait is also one for threads that still read the same memory of the zone before
    largest, longest = group_maxima(group, largest, longest)
    link_entries(zone)
    for j in range(group.rank(), n, group.size()):
        memory.earlier[j] = multipliers_out[begin + j]
    solved, steps = True, 0
    if largest > 0.0:
        tolerance = max(limits.violation / longest, LEAST_TOLERANCE)
        order_constraints(zone, positions[first:last], memory)
        guess_active(zone, memory)
        gap_tolerance = max(limits.gap, LEAST_TOLERANCE)
        farthest = limits.farthest * largest
        solved, steps = _pivot(zone, memory, gap_tolerance, tolerance, farthest, near, factors)
    else:  # the proposed positions satisfy every constraint
        for j in range(group.rank(), n, group.size()):
            memory.u[j] = 0.0
        for i in range(group.rank(), 3 * n_vertices, group.size()):
            memory.z[i] = 0.0
    for j in range(group.rank(), n, group.size()):
        multipliers_out[begin + j] = memory.u[j]
    for i in range(group.rank(), 3 * n_vertices, group.size()):
        z_out[3 * first + i] = memory.z[i]
    return solved, steps


@compiled
def _pivot(
    zone: Zone,
    memory: Memory,
    gap_tolerance: float,
    tolerance: float,
    farthest: float,
    near: Floats,
    far: Floats,
) -> tuple[bool, int]:
    """Solve for the active constraints and exchange them, until none is on the wrong side.

    Args:
        zone: The zone.
        memory: Work space, with the guess.
        gap_tolerance: Largest relative duality gap.
        tolerance: Largest s - C z.
        farthest: Largest |z|; an answer that is farther off is useless.
        near: f8, fast memory for the factor, where it fits.
        far: f8, memory for the factor; the zone is not solved if it does not fit there either.

    Returns:
        Whether the zone is solved, and the number of solves or NO_ROOM.
    """
    slop = TOLERATED_SLOP * tolerance
    fewest, since, last_off = zone.rhs.shape[0] + 1.0, 0, np.inf
    changed, factor, envelope = True, far, number_active(zone, memory)
    for step in range(1, MAX_STEPS + 1):
        if changed:
            if step > 1:
                envelope = number_active(zone, memory)
            if not fits(envelope, far):
                return False, NO_ROOM
            factor = near if fits(envelope, near) else far
            _factorize_active(zone, memory, envelope, factor)
        _solve_active(zone, memory, envelope, factor)
        count = flag_wrong(zone, memory, slop)
        changed = count > 0.0
        if changed:
            since = 0 if count < fewest else since + 1
            exchange(zone, memory, count >= FALLS * fewest, since <= PATIENCE)
            fewest = min(count, fewest)
            continue
        violation, gap, z_norm = _residuals(zone, memory)
        off = violation / tolerance
        if not gap / gap_tolerance <= off:  # a NaN stays one, while `max` of a GPU ignores it
            off = gap / gap_tolerance
        if off < TOLERATED_SLOP or 0.5 * last_off < off < STALLED_SLOP:
            return z_norm <= farthest, step
        fewest, since, last_off = zone.rhs.shape[0] + 1.0, 0, off
        for j in range(zone.group.rank(), zone.rhs.shape[0], zone.group.size()):
            memory.earlier[j] = memory.u[j]
        zone.group.wait()
    return False, MAX_STEPS


@compiled
def _factorize_active(zone: Zone, memory: Memory, envelope: Envelope, factor: Floats) -> None:
    """Compute K_FF + rho, each thread its own rows, and factor it."""
    group = zone.group
    for i in range(group.rank(), size_of(envelope), group.size()):
        factor[i] = 0.0
    group.wait()
    for a in range(group.rank(), envelope.n_rows, group.size()):
        row = factor[tile_at(envelope, a >> SHIFT, 0) + (a & (SIDE - 1)) :]
        row[SIDE * a] = RHO
        add_gram_row(zone, memory.active[a], memory.places, row, SIDE)
    group.wait()
    factorize(group, envelope, factor, memory.scales)


@compiled
def _solve_active(zone: Zone, memory: Memory, envelope: Envelope, factor: Floats) -> None:
    """Compute u, z = C^T u and C z for the active constraints."""
    group = zone.group
    for a in range(group.rank(), SIDE * envelope.n, group.size()):
        value = 0.0
        if a < envelope.n_rows:
            j = memory.active[a]
            value = zone.rhs[j] + RHO * memory.earlier[j]
        memory.right[a] = value
    group.wait()
    solve(group, envelope, factor, memory.scales, memory.right)
    for j in range(group.rank(), zone.rhs.shape[0], group.size()):
        place = memory.places[j]
        memory.u[j] = memory.right[place] if place >= 0 else 0.0
    group.wait()
    pull(zone, memory.u, memory.z)
    group.wait()
    for j in range(group.rank(), zone.rhs.shape[0], group.size()):
        memory.products[j] = product(zone, j, memory.z)


@compiled
def _residuals(zone: Zone, memory: Memory) -> tuple[float, float, float]:
    """Return the largest violation, the relative duality gap and |z|, for z = C^T u."""
    group, violation, products, z_sq = zone.group, 0.0, 0.0, 0.0
    for j in range(group.rank(), zone.rhs.shape[0], group.size()):
        missing = zone.rhs[j] - memory.products[j]
        violation = max(violation, missing)
        products += memory.u[j] * abs(missing)
    for i in range(group.rank(), memory.z.shape[0], group.size()):
        z_sq += memory.z[i] * memory.z[i]
    products, z_sq, _ = group_sums(group, products, z_sq, 0.0)
    violation, _ = group_maxima(group, violation, 0.0)
    gap = products / (0.5 * z_sq) if z_sq > 0.0 else (0.0 if products == 0.0 else np.inf)
    return violation, gap, math.sqrt(z_sq)

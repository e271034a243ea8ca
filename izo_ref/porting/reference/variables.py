"""A zone in the variables of stage S10, in numbers that carry their rounding.

The unknowns x are displacements from the proposed positions, three for each unpinned vertex:

    minimise sum_i w_i x_i^2 / 2   subject to   c_j = s_j - A_j x <= 0

    total-mass         metres, w_i = 2 m_i / sum m
    mean-inverse-mass  metres, w_i = m_i mean(1 / m)
    scaled             z_i = sqrt(m_i) (x_i - y_i) / S with w = 1, rows of unit length, and S so
                       that the largest |s_j| is 1

Source: docs/method sections 4 and 5.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from izo_ref.porting.reference.rounded import ZERO, Rounded, largest, total
from izo_ref.porting.reference.tracked import Tape
from izo_ref.porting.reference.zone import ZoneNumbers, constraints, dot

Flat: TypeAlias = list[Rounded]  # the unknowns, three for each unpinned vertex


class Variables(NamedTuple):
    """A zone in the variables of the solver.

    Attributes:
        rows: The entries of each constraint, by the number of the unknown.
        starts: s, the constraints at x = 0.
        metres: Violation [m] of a constraint with c = 1.
        curvatures: w of each unknown.
        lengths: Displacement [m] of each unknown with x = 1.
        masses: Mass of each unknown [kg].
    """

    rows: list[dict[int, Rounded]]
    starts: Flat
    metres: Flat
    curvatures: Flat
    lengths: Flat
    masses: Flat


def choose_variables(zone: ZoneNumbers, scaling: str) -> Variables:
    """Return a zone in the variables that `scaling` names."""
    masses = [m for m, free in zip(zone.masses, zone.free, strict=True) if free]
    starts = constraints(zone, zone.proposed)
    rows = _rows(zone, zone.weights)
    ones = [Rounded.of(1.0)] * len(masses)
    metres = [Rounded.of(1.0)] * len(starts)
    if scaling == "total-mass":
        scale = 2.0 / total(masses)
    elif scaling == "mean-inverse-mass":
        scale = total(1.0 / m for m in masses) / float(len(masses))
    else:
        return _scaled(zone, masses, starts)
    w = _triple([scale * m for m in masses])
    return Variables(rows, starts, metres, w, _triple(ones), _triple(masses))


def _scaled(zone: ZoneNumbers, masses: Flat, gaps: Flat) -> Variables:
    """Return a zone in the scaled variables of docs/method section 5."""
    divided = [
        [a / m.sqrt() if m.value > 0 else Rounded(ZERO) for a, m in _of_impact(zone, j)]
        for j in range(len(gaps))
    ]
    squares = [dot(a, a) * dot(n, n) for a, n in zip(divided, zone.normals, strict=True)]
    sizes = [square.sqrt() for square in squares]
    right = [c / size for c, size in zip(gaps, sizes, strict=True)]
    unit = largest(abs(s) for s in right)
    unit_rows = [[a / size for a in row] for row, size in zip(divided, sizes, strict=True)]
    return Variables(
        _rows(zone, unit_rows),
        [s / unit for s in right],
        [unit * size for size in sizes],
        [Rounded.of(1.0)] * (3 * len(masses)),
        _triple([unit / m.sqrt() for m in masses]),
        _triple(masses),
    )


def _of_impact(zone: ZoneNumbers, j: int) -> list[tuple[Rounded, Rounded]]:
    """Return the weight and the mass of each node of an impact; the mass is 0 where pinned."""
    return [(a, zone.masses[i]) for a, i in zip(zone.weights[j], zone.nodes[j], strict=True)]


def _rows(zone: ZoneNumbers, weights: Sequence[Sequence[Rounded]]) -> list[dict[int, Rounded]]:
    """Return the entries a N of each constraint that are not zero."""
    number = {i: n for n, i in enumerate(i for i, free in enumerate(zone.free) if free)}
    return [
        {
            3 * number[i] + axis: a * normal[axis]
            for i, a in zip(nodes, own, strict=True)
            for axis in range(3)
            if i in number and a.value != 0 and normal[axis].value != 0
        }
        for nodes, own, normal in zip(zone.nodes, weights, zone.normals, strict=True)
    ]


def _triple(numbers: Flat) -> Flat:
    """Return each number three times: one for each coordinate of a vertex."""
    return [number for number in numbers for _ in range(3)]


def tracked(zone: Variables, tape: Tape) -> Variables:
    """Return the zone with numbers that remember what is computed from them."""
    rows = [{i: tape.leaf(a) for i, a in row.items()} for row in zone.rows]
    return Variables(rows, *([tape.leaf(number) for number in numbers] for numbers in zone[1:]))


def products(zone: Variables, vector: Flat) -> Flat:
    """Return A v."""
    return [total(a * vector[i] for i, a in row.items()) for row in zone.rows]


def pull(zone: Variables, forces: Flat) -> Flat:
    """Return A^T f."""
    pulled = [Rounded(ZERO)] * len(zone.curvatures)
    for row, force in zip(zone.rows, forces, strict=True):
        for i, a in row.items():
            pulled[i] = pulled[i] + a * force
    return pulled


def displaced(zone: Variables, inputs: Mapping[str, Any], x: Flat) -> Flat:
    """Return the positions of all vertices [m]; pinned vertices stay at their proposed position."""
    moved = iter(a * length for a, length in zip(x, zone.lengths, strict=True))
    return [
        Rounded.of(y) if inputs["pinned"][i // 3] else Rounded.of(y) + next(moved)
        for i, y in enumerate(inputs["proposed"])
    ]


def objective(zone: Variables, x: Flat) -> Rounded:
    """Return 1/2 sum m |x - y|^2 [kg m^2]."""
    moved = [a * length for a, length in zip(x, zone.lengths, strict=True)]
    return 0.5 * total(m * v * v for m, v in zip(zone.masses, moved, strict=True))


def violation(zone: Variables, c: Flat) -> Rounded:
    """Return the largest violation [m], or 0, and note how clearly there is one."""
    worst = largest(a * metre for a, metre in zip(c, zone.metres, strict=True))
    return worst if worst > 0.0 else Rounded(ZERO)

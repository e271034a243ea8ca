"""The zone problem in numbers that carry their rounding: stages S6, S7 and S9.

    g   = sum m |x - y|^2 / sum m                                    over unpinned vertices
    c_j = d - N_j . sum_k a_jk (x_jk - x_j1)                         positive is a violation
    L   = sum w |x - y|^2 / 2 + mu/2 sum max(c_j + l_j / mu, 0)^2 - sum l_j^2 / (2 mu)

The weights of an impact sum to zero. So positions relative to its first node give the same
constraint, and far from the origin they lose less to rounding. The curvatures w are 2 m / sum m
where L belongs to g. `lagrangian` takes displacements x - y and constraints c, so that it also
serves other variables: a zone with other weights, other displacements and other curvatures.

Source: docs/method sections 1 and 3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from izo_ref.porting.reference.rounded import ZERO, Plain, Rounded, clamped, total

Vector: TypeAlias = tuple[Rounded, Rounded, Rounded]


class ZoneNumbers(NamedTuple):
    """The inputs of a zone.

    Attributes:
        nodes: The four vertices of each impact.
        weights: The four weights of each impact.
        normals: The normal of each impact.
        proposed: Proposed position of each vertex [m].
        masses: Mass of each vertex [kg]; 0 for a pinned one, whose mass is not used.
        free: Whether each vertex is unpinned.
        thickness: [m].
    """

    nodes: Sequence[Sequence[int]]
    weights: Sequence[Sequence[Rounded]]
    normals: Sequence[Vector]
    proposed: Sequence[Vector]
    masses: Sequence[Rounded]
    free: Sequence[bool]
    thickness: Rounded


class Evaluation(NamedTuple):
    """What `lagrangian` computes.

    Attributes:
        value: L.
        gradient: Gradient of L at each vertex; 0 at pinned vertices.
        pushed: c + l / mu of each impact, which is active where this is positive.
    """

    value: Rounded
    gradient: list[Vector]
    pushed: list[Rounded]


def vectors(flat: Sequence[Plain]) -> list[Vector]:
    """Return a flat list of numbers as vectors of three numbers."""
    numbers = [Rounded.of(number) for number in flat]
    return [(numbers[i], numbers[i + 1], numbers[i + 2]) for i in range(0, len(numbers), 3)]


def zone_of(inputs: Mapping[str, Any]) -> ZoneNumbers:
    """Return the zone of a case; `inputs` has the fields of `stages.py`, as flat lists."""
    nodes, weights = inputs["nodes"], inputs["weights"]
    free = [flag == 0 for flag in inputs["pinned"]]
    return ZoneNumbers(
        [nodes[j : j + 4] for j in range(0, len(nodes), 4)],
        [[Rounded.of(a) for a in weights[j : j + 4]] for j in range(0, len(weights), 4)],
        vectors(inputs["normals"]),
        vectors(inputs["proposed"]),
        [
            Rounded.of(m) if f else Rounded(ZERO)
            for m, f in zip(inputs["masses"], free, strict=True)
        ],
        free,
        Rounded.of(inputs["thickness"]),
    )


def dot(a: Sequence[Rounded], b: Sequence[Rounded]) -> Rounded:
    """Return the scalar product of two vectors."""
    return total(x * y for x, y in zip(a, b, strict=True))


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def displacements(zone: ZoneNumbers, positions: Sequence[Vector]) -> list[Vector]:
    """Return x - y of each vertex; 0 for pinned vertices."""
    zero = Rounded(ZERO)
    return [
        minus(x, y) if free else (zero, zero, zero)
        for x, y, free in zip(positions, zone.proposed, zone.free, strict=True)
    ]


def constraints(zone: ZoneNumbers, positions: Sequence[Vector]) -> list[Rounded]:
    """Return c at positions x [m]."""
    found = []
    for nodes, weights, normal in zip(zone.nodes, zone.weights, zone.normals, strict=True):
        relative = [minus(positions[i], positions[nodes[0]]) for i in nodes]
        found.append(zone.thickness - dot(normal, _combine(weights, relative)))
    return found


def products(zone: ZoneNumbers, moved: Sequence[Vector]) -> list[Rounded]:
    """Return A v, which is N . sum a v, for a displacement or direction v that is 0 where pinned.

    So c(x + s p) = c(x) - s A p, and c(x) = c(y) - A (x - y).
    """
    return [
        dot(normal, _combine(weights, [moved[i] for i in nodes]))
        for nodes, weights, normal in zip(zone.nodes, zone.weights, zone.normals, strict=True)
    ]


def _combine(weights: Sequence[Rounded], points: Sequence[Vector]) -> Vector:
    """Return sum_k a_k v_k."""
    x, y, z = (dot(weights, [point[axis] for point in points]) for axis in range(3))
    return x, y, z


def objective(zone: ZoneNumbers, moved: Sequence[Vector]) -> Rounded:
    """Return g [m^2] for displacements x - y."""
    squares = (
        m * dot(v, v) for m, v, free in zip(zone.masses, moved, zone.free, strict=True) if free
    )
    return total(squares) / total(zone.masses)


def curvatures(zone: ZoneNumbers) -> list[Rounded]:
    """Return w = 2 m / sum m, the second derivatives of g; 0 for pinned vertices."""
    mass = total(zone.masses)
    return [2.0 * m / mass for m in zone.masses]


def objective_gradient(w: Sequence[Rounded], moved: Sequence[Vector]) -> list[Vector]:
    """Return w (x - y), the gradient of sum w |x - y|^2 / 2."""
    return [(a * v[0], a * v[1], a * v[2]) for a, v in zip(w, moved, strict=True)]


def lagrangian(
    zone: ZoneNumbers,
    moved: Sequence[Vector],
    c: Sequence[Rounded],
    multipliers: Sequence[Plain],
    mu: Plain,
    w: Sequence[Rounded],
) -> Evaluation:
    """Evaluate the augmented Lagrangian as its formula is written.

    Args:
        zone: Only its nodes, weights, normals and pinned vertices are used.
        moved: x - y.
        c: The constraints at x.
        multipliers: l >= 0.
        mu: The penalty.
        w: The curvatures of the objective sum w |x - y|^2 / 2.
    """
    mu = Rounded.of(mu)
    multipliers = [Rounded.of(number) for number in multipliers]
    pushed = [a + b / mu for a, b in zip(c, multipliers, strict=True)]
    terms = [clamped(number) for number in pushed]
    squares = total(a * dot(v, v) for a, v in zip(w, moved, strict=True))
    value = 0.5 * squares + 0.5 * mu * total(t * t for t in terms)
    value = value - total(b * b for b in multipliers) / (2.0 * mu)
    return Evaluation(value, _gradient(zone, moved, updated(multipliers, c, mu), w), pushed)


def _gradient(
    zone: ZoneNumbers, moved: Sequence[Vector], forces: Sequence[Rounded], w: Sequence[Rounded]
) -> list[Vector]:
    """Return w (x - y) - sum_j a_j N_j max(l_j + mu c_j, 0)."""
    gradient = [list(vector) for vector in objective_gradient(w, moved)]
    for j, nodes in enumerate(zone.nodes):
        for i, a in zip(nodes, zone.weights[j], strict=True):
            for axis in range(3):
                if zone.free[i]:
                    gradient[i][axis] = gradient[i][axis] - a * zone.normals[j][axis] * forces[j]
    return [(x, y, z) for x, y, z in gradient]


def updated(multipliers: Sequence[Plain], c: Sequence[Plain], mu: Plain) -> list[Rounded]:
    """Return the new multipliers max(l + mu c, 0)."""
    mu = Rounded.of(mu)
    return [clamped(mu * Rounded.of(b) + a) for a, b in zip(multipliers, c, strict=True)]

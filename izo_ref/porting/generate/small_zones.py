"""Small zones for the vectors: inputs that a float32 holds exactly, from plain random numbers."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from random import Random
from typing import Any

from izo_ref.porting.generate.zone_parts import unit
from izo_ref.porting.reference.rounded import CONTEXT, to_float32

Inputs = dict[str, Any]
MILLIMETRE = 2.0**-10  # [m], about


def float32(number: float | Decimal) -> float:
    """Return the nearest float32, as a float."""
    return to_float32(float(number))


def dyadic(random: Random, low: float, high: float, bits: int = 10) -> float:
    """Return a random multiple of 2^-bits from low to high."""
    steps = 2**bits
    return round((low + (high - low) * random.random()) * steps) / steps


def some(random: Random, count: int, items: int) -> list[int]:
    """Return different numbers below `items` in a random order."""
    left = list(range(items))
    return [left.pop(int(random.random() * len(left))) for _ in range(count)]


def unit_vector(random: Random) -> list[float]:
    """Return a random direction, rounded to float32."""
    while True:
        vector = [Decimal(dyadic(random, -1.0, 1.0)) for _ in range(3)]
        square = sum((a * a for a in vector), Decimal(0))
        if Decimal("0.01") < square <= 1:
            length = CONTEXT.sqrt(square)
            return [float32(CONTEXT.divide(a, length)) for a in vector]


def pair_weights(random: Random, is_edge_edge: bool, bits: int = 10) -> list[float]:
    """Return the weights of a vertex and a face, or of two edges; their sum is exactly 0."""
    b, c = dyadic(random, 0.0, 1.0, bits), dyadic(random, 0.0, 1.0, bits)
    if is_edge_edge:
        return [1.0 - b, b, c - 1.0, -c]
    b, c = min(b, c), abs(b - c)
    return [1.0, -b, -c, -(1.0 - b - c)]


def random_zone(
    random: Random,
    impacts: int,
    vertices: int,
    *,
    masses: Sequence[float] = (1.0,),
    pinned: Sequence[int] = (),
    hub: bool = False,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    size: float = 1.0,
    move: float = 0.25,
) -> Inputs:
    """Return a zone of random impacts, with positions x to evaluate it at.

    Args:
        random: Source of random numbers.
        impacts: Their number.
        vertices: Their number.
        masses: [kg], repeated for all vertices.
        pinned: The pinned vertices.
        hub: Whether vertex 0 is in every impact.
        origin: [m], the middle of the zone.
        size: [m], largest distance of a proposed position from there along an axis; a power of 2.
        move: Largest distance of x from y along an axis, over `size`.
    """
    nodes: list[int] = []
    for _ in range(impacts):
        chosen = some(random, 4, vertices)
        if hub and 0 not in chosen:
            chosen[int(4 * random.random())] = 0
        nodes += chosen
    weights = [a for j in range(impacts) for a in pair_weights(random, j % 2 == 1)]
    normals = [a for _ in range(impacts) for a in unit_vector(random)]
    y, x = [], []
    for i in range(vertices):
        for axis in range(3):
            y.append(origin[axis] + size * dyadic(random, -1.0, 1.0))
            x.append(y[-1] if i in pinned else y[-1] + size * dyadic(random, -move, move))
    return {
        "nodes": nodes,
        "weights": weights,
        "normals": normals,
        "proposed": y,
        "masses": [masses[i % len(masses)] for i in range(vertices)],
        "pinned": [int(i in pinned) for i in range(vertices)],
        "thickness": size * MILLIMETRE,
        "positions": x,
    }


def with_all_digits(random: Random, inputs: Inputs) -> Inputs:
    """Return the inputs of a random zone without pinned vertices, changed beyond float32."""

    def changed(number: float) -> float:
        return number * (1.0 + dyadic(random, -1.0, 1.0, 26) * 2.0**-24)

    result = {
        name: [changed(a) if isinstance(a, float) else a for a in value]
        if isinstance(value, list)
        else (changed(value) if isinstance(value, float) else value)
        for name, value in inputs.items()
    }
    impacts = range(len(inputs["nodes"]) // 4)
    result["weights"] = [a for j in impacts for a in pair_weights(random, j % 2 == 1, 50)]
    normals = [inputs["normals"][3 * j : 3 * j + 3] for j in impacts]
    result["normals"] = [a for normal in normals for a in unit(*map(changed, normal))]
    return result


CORNERS = (-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0)
SPLITS = ((-0.5, -0.25, -0.25), (-0.25, -0.5, -0.25), (-0.25, -0.25, -0.5), (-0.125, -0.125, -0.75))


def zone_above_face(
    wanted: Sequence[float],
    thickness: float = MILLIMETRE,
    *,
    fall: float = 0.25,
    masses: Sequence[float] = (1.0,),
    pinned: Sequence[int] = (),
) -> Inputs:
    """Return vertices above one face in the plane z = 0, with constraints c as wanted.

    All numbers are short, so that c is exact in every type of floats.

    Args:
        wanted: [m], the constraint c of each vertex at x.
        thickness: [m].
        fall: [m], the proposed position of a vertex is this far below x.
        masses: [kg], repeated for all vertices; the last three are the corners of the face.
        pinned: The pinned vertices.
    """
    count = len(wanted)
    x = [a for c in wanted for a in (0.0, 0.0, thickness - c)] + list(CORNERS)
    y = [a - fall if i % 3 == 2 and i < 3 * count else a for i, a in enumerate(x)]
    x = [y[i] if i // 3 in pinned else a for i, a in enumerate(x)]
    return {
        "nodes": [i for j in range(count) for i in (j, count, count + 1, count + 2)],
        "weights": [a for j in range(count) for a in (1.0, *SPLITS[j % len(SPLITS)])],
        "normals": [0.0, 0.0, 1.0] * count,
        "proposed": y,
        "masses": [masses[i % len(masses)] for i in range(count + 3)],
        "pinned": [int(i in pinned) for i in range(count + 3)],
        "thickness": thickness,
        "positions": x,
    }

"""The same time step, written in another way, and how far its answer is from the first one.

A twin is a step whose answer is that of another step, moved, turned, scaled or numbered anew. All
coordinates of `validation/scenes/crossing.py` are multiples of a lattice, so a twin is exact: only
the computation rounds, never the step.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.options import Options
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from validation.scenes.crossing import Step


class Twin(NamedTuple):
    """A step with the same answer.

    Attributes:
        step: The other step.
        back: Takes its positions, and returns them as positions of the first step.
        options: The options with which it is resolved.
    """

    step: Step
    back: Callable[[Positions], Positions]
    options: Options | None = None


class Compared(NamedTuple):
    """How far two answers of the same step are apart.

    Attributes:
        deviation: Largest difference of a coordinate, over the largest move from the proposal.
        same_way: Whether both runs took equally many iterations and ended with equally many impacts
            in zones.
        objective: Objective of the other answer over that of the first one, less 1.
        statuses: Both statuses.
    """

    deviation: float
    same_way: bool
    objective: float
    statuses: tuple[str, str]


Symmetry: TypeAlias = Callable[[np.random.Generator, Step, Result], Compared]
MakeTwin: TypeAlias = Callable[[np.random.Generator, Step], Twin]


def resolved(step: Step, options: Options | None = None) -> Result:
    """Resolve a step."""
    return resolve(Scene(*step[:5]), step.thickness, options=options)


def by_twin(make: MakeTwin) -> Symmetry:
    """Return the symmetry that resolves a twin and brings its positions back."""

    def compare_twin(rng: np.random.Generator, step: Step, result: Result) -> Compared:
        twin = make(rng, step)
        other = resolved(twin.step, twin.options)
        return compared(step, result, other, twin.back(other.positions))

    return compare_twin


def compared(step: Step, result: Result, other: Result, positions: Positions) -> Compared:
    """Compare another answer of a step with the first one.

    Args:
        step: The step.
        result: Its answer.
        other: The other answer, in its own units.
        positions: (n, 3) f8 [m], the positions of the other answer, in the units of the step.
    """
    off = float(np.abs(positions - result.positions).max())
    move = float(np.abs(result.positions - step.end).max())
    ways = [(len(r.history), len(r.impacts.toi)) for r in (result, other)]
    own, others = (_objective(step, p) for p in (result.positions, positions))
    return Compared(
        off / move if move > 0.0 else float(off > 0.0),
        ways[0] == ways[1],
        others / own - 1.0 if own > 0.0 else float(others > 0.0),
        (result.status.name, other.status.name),
    )


def _objective(step: Step, positions: Positions) -> float:
    moved = (positions - step.end)[~step.pinned]
    return float((step.masses[~step.pinned, None] * moved**2).sum())


def unchanged(positions: Positions) -> Positions:
    """Return positions as they are: what brings those of a twin in the same place back."""
    return positions

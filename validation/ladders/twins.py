"""The same time step, written in another way, and what has to be equal then.

A twin is a step whose answer is that of another step, moved, turned, scaled or numbered anew. All
coordinates of `validation/scenes/crossing.py` are multiples of a lattice, so a twin is exact: only
the computation rounds, never the step.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numba
import numpy as np

from izo_ref.base.arrays import Floats, Positions
from izo_ref.base.options import Options
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from validation.scenes.crossing import Step, crossing_sheets, on_lattice

# (3, 3) whole numbers, each 5 times a rotation by the angles of the triangle 3-4-5.
TURNS = (
    np.array([[3.0, -4.0, 0.0], [4.0, 3.0, 0.0], [0.0, 0.0, 5.0]]),
    np.array([[5.0, 0.0, 0.0], [0.0, 3.0, -4.0], [0.0, 4.0, 3.0]]),
    np.array([[3.0, 0.0, 4.0], [0.0, 5.0, 0.0], [-4.0, 0.0, 3.0]]),
)


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


def _unchanged(positions: Positions) -> Positions:
    return positions


# --- twins whose answer has to have the same bits ---


def same_step(rng: np.random.Generator, step: Step) -> Twin:
    """The same step once more."""
    return Twin(step, _unchanged)


def without_rules(rng: np.random.Generator, step: Step) -> Twin:
    """Without the rules that leave work out, but for the closed form of one impact."""
    return Twin(step, _unchanged, Options(plan=("closed-form",)))


def scaled_by_power(rng: np.random.Generator, step: Step) -> Twin:
    """All lengths times 2^k, k from -900 to 900."""
    k = int(rng.integers(-900, 901))
    start, end = np.ldexp(step.start, k), np.ldexp(step.end, k)
    thickness = float(np.ldexp(step.thickness, k))
    twin = step._replace(start=start, end=end, thickness=thickness)
    return Twin(twin, lambda positions: np.ldexp(positions, -k))


def heavier_by_power(rng: np.random.Generator, step: Step) -> Twin:
    """All masses times 4^k, k from -400 to 400."""
    masses = np.ldexp(step.masses, 2 * int(rng.integers(-400, 401)))
    return Twin(step._replace(masses=masses), _unchanged)


def other_pinned_masses(rng: np.random.Generator, step: Step) -> Twin:
    """Other masses of pinned vertices, which are not used."""
    masses = np.where(step.pinned, rng.choice([0.0, -1.0, np.inf, 1e-9, 1e9]), step.masses)
    return Twin(step._replace(masses=masses), _unchanged)


def numbered_anew(rng: np.random.Generator, step: Step) -> Twin:
    """Vertices and faces in another order, and each face from another corner."""
    order = rng.permutation(len(step.start))
    place = np.argsort(order)
    faces = place[step.faces][rng.permutation(len(step.faces))]
    first = (np.arange(3) + rng.integers(3, size=(len(faces), 1))) % 3
    faces = np.take_along_axis(faces, first, axis=1)
    twin = Step(
        step.start[order],
        step.end[order],
        faces,
        step.masses[order],
        step.pinned[order],
        step.thickness,
    )
    return Twin(twin, lambda positions: positions[place])


def two_threads(rng: np.random.Generator, step: Step, result: Result) -> Compared:
    """On one thread, and on as many as there are."""
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        other = resolved(step)
    finally:
        numba.set_num_threads(before)
    return compared(step, result, other, other.positions)


def next_step(rng: np.random.Generator, step: Step, result: Result) -> Compared:
    """A step of `Scene.after`, and a new scene of the same arrays."""
    if not result.certificate.free:
        return compared(step, result, result, result.positions)
    end = result.positions + on_lattice(step.end - step.start)
    following = step._replace(start=result.positions, end=end)
    # the certificate belongs to its own scene object
    after = result.certificate.scene.after(result, end)
    own, fresh = resolve(after, step.thickness), resolved(following)
    return compared(following, own, fresh, fresh.positions)


def resolved_again(rng: np.random.Generator, step: Step, result: Result) -> Compared:
    """The answer as a proposal: nothing is left to do."""
    return _unmoved(step._replace(end=result.positions))


def reversed_in_time(rng: np.random.Generator, step: Step, result: Result) -> Compared:
    """The path of the answer backward, which is as free as forward: it ends at the start."""
    return _unmoved(step._replace(start=result.positions, end=step.start))


def _unmoved(step: Step) -> Compared:
    """Compare the answer of a step with its proposal."""
    result = resolved(step)
    off = float(np.abs(result.positions - step.end).max())
    move = float(np.abs(step.end - step.start).max())
    return Compared(off / move, True, result.objective, ("FREE", result.status.name))


# --- twins whose answer differs by rounding ---


def turned(rng: np.random.Generator, step: Step) -> Twin:
    """Turned by two angles of the triangle 3-4-5; lengths are 25 times as large."""
    first, second = rng.permutation(3)[:2]
    return _mapped(step, TURNS[first] @ TURNS[second], 25.0)


def axes_exchanged(rng: np.random.Generator, step: Step) -> Twin:
    """The axes in another order."""
    return _mapped(step, np.roll(np.eye(3), int(rng.integers(1, 3)), axis=0), 1.0)


def mirrored(rng: np.random.Generator, step: Step) -> Twin:
    """Mirrored at planes of one, two or three axes."""
    signs = rng.choice([-1.0, 1.0], 3)
    signs[int(rng.integers(3))] = -1.0
    return _mapped(step, np.diag(signs), 1.0)


def moved(rng: np.random.Generator, step: Step) -> Twin:
    """Moved by whole metres, up to 16 times the size of the mesh."""
    shift = rng.integers(-16, 17, 3).astype(float)
    twin = step._replace(start=step.start + shift, end=step.end + shift)
    return Twin(twin, lambda positions: positions - shift)


def scaled_by_three(rng: np.random.Generator, step: Step) -> Twin:
    """Lengths three times as large."""
    return _mapped(step, 3.0 * np.eye(3), 3.0)


def heavier(rng: np.random.Generator, step: Step) -> Twin:
    """All masses times 2, 3, 10 or 1e6."""
    return Twin(step._replace(masses=step.masses * rng.choice([2.0, 3.0, 10.0, 1e6])), _unchanged)


def turned_over(rng: np.random.Generator, step: Step) -> Twin:
    """Half of the faces with the opposite orientation."""
    chosen = rng.random((len(step.faces), 1)) < 0.5
    faces = np.where(chosen, step.faces[:, ::-1], step.faces)
    return Twin(step._replace(faces=faces), _unchanged)


def with_something_at_rest(rng: np.random.Generator, step: Step) -> Twin:
    """With a triangle at rest, from 4 to 1e6 m away."""
    away = 2.0 ** rng.integers(2, 21) * rng.choice([-1.0, 1.0], 3)
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]) + away
    faces = np.arange(3, dtype=np.int32)[None]
    at_rest = Step(points, points, faces, np.ones(3), np.zeros(3, bool))
    return _together(step, at_rest)


def with_another_step(rng: np.random.Generator, step: Step) -> Twin:
    """With a light step, 64 m away."""
    return beside(rng, step, 64.0)


def beside(rng: np.random.Generator, step: Step, distance: float) -> Twin:
    """Return a step together with a light one that is some distance away [m]."""
    other = crossing_sheets(rng, 4.0 ** rng.uniform(-2.0, 0.0))
    moved_away = other._replace(start=other.start + distance, end=other.end + distance)
    return _together(step, moved_away)


def without_closed_form(rng: np.random.Generator, step: Step) -> Twin:
    """Without any rule: a solver solves the zones of one impact too."""
    return Twin(step, _unchanged, Options(plan="everything"))


def _mapped(step: Step, matrix: Floats, length: float) -> Twin:
    """Return the twin of a linear map that multiplies all lengths by a number."""
    twin = step._replace(
        start=step.start @ matrix.T,
        end=step.end @ matrix.T,
        thickness=length * step.thickness,
    )
    return Twin(twin, lambda positions: positions @ matrix / length**2)


def _together(step: Step, other: Step) -> Twin:
    """Return two steps as one."""
    n = len(step.start)
    parts = zip(step[:5], (*other[:2], other.faces + n, *other[3:5]), strict=True)
    twin = Step(*(np.concatenate(pair) for pair in parts), step.thickness)
    return Twin(twin, lambda positions: positions[:n])


SAME_BITS: dict[str, Symmetry] = {
    "again": by_twin(same_step),
    "one thread": two_threads,
    "lengths times 2^k": by_twin(scaled_by_power),
    "masses times 4^k": by_twin(heavier_by_power),
    "other masses of pinned vertices": by_twin(other_pinned_masses),
    "without rules": by_twin(without_rules),
    "next step": next_step,
    "resolved again": resolved_again,
    "backward": reversed_in_time,
    "numbered anew": by_twin(numbered_anew),
}
ROUNDED: dict[str, Symmetry] = {
    "turned": by_twin(turned),
    "axes exchanged": by_twin(axes_exchanged),
    "mirrored": by_twin(mirrored),
    "moved": by_twin(moved),
    "lengths times 3": by_twin(scaled_by_three),
    "masses times 2, 3, 10, 1e6": by_twin(heavier),
    "faces turned over": by_twin(turned_over),
    "something at rest": by_twin(with_something_at_rest),
    "another step beside it": by_twin(with_another_step),
    "without the closed form": by_twin(without_closed_form),
}

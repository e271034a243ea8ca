"""Twins of a step whose answer differs by rounding, or takes another way."""

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.options import Options
from validation.ladders.twins import Symmetry, Twin, by_twin, unchanged
from validation.scenes.crossing import Step, crossing_sheets

# (3, 3) whole numbers, each 5 times a rotation by the angles of the triangle 3-4-5.
TURNS = (
    np.array([[3.0, -4.0, 0.0], [4.0, 3.0, 0.0], [0.0, 0.0, 5.0]]),
    np.array([[5.0, 0.0, 0.0], [0.0, 3.0, -4.0], [0.0, 4.0, 3.0]]),
    np.array([[3.0, 0.0, 4.0], [0.0, 5.0, 0.0], [-4.0, 0.0, 3.0]]),
)


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
    return Twin(step._replace(masses=step.masses * rng.choice([2.0, 3.0, 10.0, 1e6])), unchanged)


def turned_over(rng: np.random.Generator, step: Step) -> Twin:
    """Half of the faces with the opposite orientation."""
    chosen = rng.random((len(step.faces), 1)) < 0.5
    faces = np.where(chosen, step.faces[:, ::-1], step.faces)
    return Twin(step._replace(faces=faces), unchanged)


def with_something_at_rest(rng: np.random.Generator, step: Step) -> Twin:
    """With a triangle at rest, from 4 to 1e6 m away."""
    away = 2.0 ** rng.integers(2, 21) * rng.choice([-1.0, 1.0], 3)
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]) + away
    faces = np.arange(3, dtype=np.int32)[None]
    at_rest = Step(points, points, faces, np.ones(3), np.zeros(3, bool))
    return _together(step, at_rest)


def beside(rng: np.random.Generator, step: Step, distance: float) -> Twin:
    """Return a step together with a light one that is some distance away [m]."""
    other = crossing_sheets(rng, 4.0 ** rng.uniform(-2.0, 0.0))
    moved_away = other._replace(start=other.start + distance, end=other.end + distance)
    return _together(step, moved_away)


def without_closed_form(rng: np.random.Generator, step: Step) -> Twin:
    """Without any rule: a solver solves the zones of one impact too."""
    return Twin(step, unchanged, Options(plan="everything"))


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
    twin = Step(
        np.concatenate((step.start, other.start)),
        np.concatenate((step.end, other.end)),
        np.concatenate((step.faces, other.faces + np.int32(n))),
        np.concatenate((step.masses, other.masses)),
        np.concatenate((step.pinned, other.pinned)),
        step.thickness,
    )
    return Twin(twin, lambda positions: positions[:n])


ROUNDED: dict[str, Symmetry] = {
    "turned": by_twin(turned),
    "axes exchanged": by_twin(axes_exchanged),
    "mirrored": by_twin(mirrored),
    "moved": by_twin(moved),
    "lengths times 3": by_twin(scaled_by_three),
    "masses times 2, 3, 10, 1e6": by_twin(heavier),
    "faces turned over": by_twin(turned_over),
    "something at rest": by_twin(with_something_at_rest),
    "without the closed form": by_twin(without_closed_form),
}

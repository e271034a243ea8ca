"""Twins of a step whose answer has to have the same bits."""

from typing import Any

import numba
import numpy as np

from izo_ref.base.options import Options
from izo_ref.loop.resolve import Result, resolve
from validation.ladders.twins import (
    Compared,
    Symmetry,
    Twin,
    by_twin,
    compared,
    resolved,
    unchanged,
)
from validation.scenes.crossing import Step, on_lattice


def same_step(rng: np.random.Generator, step: Step) -> Twin:
    """The same step once more."""
    return Twin(step, unchanged)


def without_rules(rng: np.random.Generator, step: Step) -> Twin:
    """Without the rules that leave work out, but for the closed form of one impact."""
    return Twin(step, unchanged, Options(plan=("closed-form",)))


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
    return Twin(step._replace(masses=masses), unchanged)


def other_pinned_masses(rng: np.random.Generator, step: Step) -> Twin:
    """Other masses of pinned vertices, which are not used."""
    masses = np.where(step.pinned, rng.choice([0.0, -1.0, np.inf, 1e-9, 1e9]), step.masses)
    return Twin(step._replace(masses=masses), unchanged)


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
        faces.astype(np.int32),
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
    scene: Any = result.certificate.scene  # what was resolved; `after` takes no other scene
    after = scene.after(result, end)
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

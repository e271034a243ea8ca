"""Whole steps whose coordinates change a little: what stays, and how often another way is taken."""

import time

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.loop.resolve import Result
from validation.ladders.ladder import RIGHT, SAYS_SO, WRONG, Ladder, Outcome, Rung
from validation.ladders.noise import UNIT, estimated_digits, perturbed, shared_digits
from validation.ladders.twins import resolved
from validation.oracles.pairs import meeting_pairs
from validation.scenes.crossing import Step, crossing_sheets, regular_layers

FAMILY = "precision"
SEED = 20240610
STEPS, SAMPLES = 4, 25  # of each depth: 100 noisy steps
KINDS = {
    "light": "crossing sheets, up to 1 edge length deep",
    "deep": "crossing sheets, 4 edge lengths deep",
    "very deep": "crossing sheets, 32 edge lengths deep",
    "ties": "regular layers, in which many impacts happen at the same time",
}
NOISES = (UNIT, 1e-15, 1e-14, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
OBJECTIVE_TOLERANCE = 0.1  # of the objective, where noise is far below it


def draw(kind: str, number: int) -> Step:
    """Draw a step of a kind of KINDS."""
    rng = np.random.default_rng([SEED, number])
    if kind == "ties":
        return regular_layers(rng)
    light = float(4.0 ** rng.uniform(-2.0, 0.0))
    return crossing_sheets(rng, {"deep": 4.0, "very deep": 32.0}.get(kind, light))


def noisy(rng: np.random.Generator, step: Step, size: float) -> Step:
    """Return a step whose coordinates change by up to a fraction of the size of the mesh.

    With UNIT, each coordinate changes by a unit in the last place, up or down, or not.
    """
    if size == UNIT:
        return step._replace(
            start=perturbed(rng, step.start, UNIT), end=perturbed(rng, step.end, UNIT)
        )
    changes = [size * rng.uniform(-1.0, 1.0, step.start.shape) for _ in range(2)]
    return step._replace(start=step.start + changes[0], end=step.end + changes[1])


def judge_noisy_steps(kind: str, size: float, steps: int, samples: int) -> list[Outcome]:
    """Resolve steps with noise, and compare the moves with those of the steps without noise.

    One noisy step of each ten is also judged by exact arithmetic over all of its pairs.
    """
    begin = time.perf_counter()
    flips = refuted = worse = 0
    statuses: set[str] = set()
    shared, estimated, deviation = [], [], 0.0
    for number in range(steps):
        step = draw(kind, number)
        base = resolved(step)
        move = base.positions - step.end
        largest, deviations = np.abs(move).max(), []
        for sample in range(samples):
            other = noisy(np.random.default_rng([SEED, number, sample]), step, size)
            found = resolved(other)
            statuses.add(found.status.name)
            flips += _way(found) != _way(base)
            refuted += sample % 10 == 0 and _meets(other, found.positions)
            if size <= 1e-6:
                worse += abs(found.objective / base.objective - 1.0) > OBJECTIVE_TOLERANCE
            deviations.append(((found.positions - other.end) - move).ravel() / largest)
        samples_of_step = np.array(deviations)
        deviation = max(deviation, float(np.abs(samples_of_step).max()))
        shared.append(shared_digits(samples_of_step))
        estimated.append(estimated_digits(samples_of_step))
    free = statuses == {"FREE"}
    verdict = WRONG if refuted or worse else RIGHT if free else SAYS_SO
    note = (
        f"{steps * samples} steps; {flips} with other impacts, iterations or status than without "
        f"noise; {refuted} refuted by exact arithmetic; {worse} with an objective that differs by "
        f"more than {100.0 * OBJECTIVE_TOLERANCE:.0f} %; shared digits of the moves "
        f"{min(shared):.1f}, median {np.median(shared):.1f}; by significantdigits "
        f"{min(estimated):.1f}"
    )
    seconds = (time.perf_counter() - begin) / (steps * samples)
    status = ", ".join(sorted(statuses))
    return [Outcome(verdict, status, error=deviation, seconds=seconds, note=note)]


def _way(result: Result) -> tuple[object, ...]:
    """Return the decisions of a run: status, iterations, and the impacts in zones."""
    return (
        result.status,
        len(result.history),
        result.impacts.nodes.tobytes(),
        result.impacts.is_edge_edge.tobytes(),
    )


def _meets(step: Step, positions: Positions) -> bool:
    """Return whether a pair of the mesh meets on the path, by exact arithmetic."""
    found = meeting_pairs(step.start, positions, step.faces)
    return len(found.vertex_face) + len(found.edge_edge) > 0


def _one_unit(rung: Rung) -> list[Outcome]:
    return judge_noisy_steps(str(rung), UNIT, STEPS, SAMPLES)


def _by_size(rung: Rung) -> list[Outcome]:
    return judge_noisy_steps("light", float(rung), STEPS, SAMPLES)


LADDERS: list[Ladder] = [
    Ladder(
        FAMILY,
        "one unit in the last place of a step",
        f"The coordinates of whole steps change by one unit in the last place or not, "
        f"{STEPS * SAMPLES} times. Every path is certified free, and exact arithmetic over all "
        "pairs agrees for one in ten. The error is the largest deviation of a move, over the "
        "largest move.",
        "kind",
        tuple(KINDS),
        _one_unit,
        (),
        600.0,
        tuple(KINDS)[-1],
    ),
    Ladder(
        FAMILY,
        "noise on a step",
        "The coordinates of light steps change by up to a fraction of the size of the mesh. Every "
        "path is certified free, and exact arithmetic over all pairs agrees for one in ten. The "
        "error is the largest deviation of a move, over the largest move.",
        "noise / size (0: one unit in the last place)",
        NOISES,
        _by_size,
        (),
        600.0,
        NOISES[-1],
    ),
]

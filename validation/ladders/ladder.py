"""The records of a ladder: cases of one kind with a known answer, from mild to absurd."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TypeAlias

# A rung: a number that grows, or the name of a kind of case.
Rung: TypeAlias = float | str

# Verdicts on an answer, from good to bad.
RIGHT = "right"  # the answer agrees with what is known, as closely as the ladder asks for
SAYS_SO = "says so"  # not reached, and the status or the error says it
ANOTHER = "another"  # free as the status says, but farther off than other forms of the same step
NO_ANSWER = "no answer"  # not reached within the limits of time and memory
WRONG = "wrong"  # wrong without saying so, or an exception that is no message to the user
VERDICTS = (RIGHT, SAYS_SO, ANOTHER, NO_ANSWER, WRONG)
OWN = "izo_ref"


class Outcome(NamedTuple):
    """What one program made of one rung.

    Attributes:
        verdict: One of VERDICTS.
        status: What the program said: a name of `Status`, the class of an error, "solved",
            "not solved", or the words of another program.
        by: Who answered: OWN, or another solver that stands beside it.
        error: Relative error against what is known; None if only the status is known.
        violation: Largest violation of a constraint, or depth of a contact, over the thickness.
        iterations: Iterations of the loop, or of the solver of a zone.
        seconds: Time of a run with everything compiled [s].
        condition: Condition number of A M^-1 A^T, the largest of all zones.
        note: A sentence: what is known and by whom, or the message.
    """

    verdict: str
    status: str
    by: str = OWN
    error: float | None = None
    violation: float | None = None
    iterations: int | None = None
    seconds: float | None = None
    condition: float | None = None
    note: str = ""


Run: TypeAlias = Callable[[Rung], Iterable[Outcome]]


class Ladder(NamedTuple):
    """Cases of one kind, from mild to absurd.

    Attributes:
        family: Name of the family, the same for all ladders of a file.
        name: Short name, unique in the family; it is a row of the map.
        sentence: One sentence: what grows or varies, what is known of the answer, and by whom.
        unit: What a rung is, for the axis, such as "mass ratio" or "thickness / edge length";
            "kind" if the rungs are names.
        rungs: From mild to absurd; all numbers, ascending or descending, or all names.
        run: Makes the case of a rung, runs it and judges it. Our own outcome comes first; outcomes
            of other solvers may follow. It is called in a process of its own, with limits.
        quick: The rungs that the quick part has, a second or less in all.
        seconds: Largest time of one rung [s].
        wanted: The rung up to which every answer has to be right; None if nothing is wanted.
    """

    family: str
    name: str
    sentence: str
    unit: str
    rungs: Sequence[Rung]
    run: Run
    quick: Sequence[Rung] = ()
    seconds: float = 60.0
    wanted: Rung | None = None


class Border(NamedTuple):
    """Where a ladder of numbers ends, or which kinds fail.

    Attributes:
        last: The last rung before the first that is not right; None if the first is not right.
        beyond: The first rung that is not right; None if all are.
        said: What the program says at the rungs that are not right, each once.
    """

    last: Rung | None
    beyond: Rung | None
    said: tuple[str, ...]


def border(outcomes: Sequence[tuple[Rung, Outcome]]) -> Border:
    """Return the border of a ladder.

    Args:
        outcomes: Our own outcome of each rung, in the order of the ladder.
    """
    last = beyond = None
    for rung, outcome in outcomes:
        if outcome.verdict != RIGHT:
            beyond = rung
            break
        last = rung
    said = [o.status for _, o in outcomes if o.verdict != RIGHT]
    return Border(last, beyond, tuple(dict.fromkeys(said)))


def worst(draws: Iterable[Sequence[Outcome]]) -> list[Outcome]:
    """Return the worst outcome of several draws of one rung, for each program.

    The worst is the one with the worst verdict, and of these the one with the largest error. Its
    time, its iterations, its violation and its condition number are the largest of all draws.

    Args:
        draws: The outcomes of each draw, our own first.

    Returns:
        One outcome for each program, our own first.
    """
    by_program: dict[str, list[Outcome]] = {}
    for outcomes in draws:
        for outcome in outcomes:
            by_program.setdefault(outcome.by, []).append(outcome)
    return [_worst_of_program(outcomes) for outcomes in by_program.values()]


def _worst_of_program(outcomes: Sequence[Outcome]) -> Outcome:
    chosen = max(outcomes, key=lambda o: (VERDICTS.index(o.verdict), o.error or 0.0))
    numbers = ("violation", "iterations", "seconds", "condition")
    found = {name: [v for o in outcomes if (v := getattr(o, name)) is not None] for name in numbers}
    return chosen._replace(**{name: max(values, default=None) for name, values in found.items()})

"""Study of stability: how far the method holds, where it ends, and what the program says beyond.

Each part adds the rows that are missing. A rung of a ladder runs in a process of its own, with
limits of time and memory, so that a crash is a row and not the end of the study. `python -m
validation study stability` starts it.
"""

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from validation.bounds.search import search
from validation.ladders.ladder import OWN, VERDICTS
from validation.ladders.rungs import ladders, run_rung, rung_text, warm_up
from validation.rows import Rows
from validation.study.parts import Part, Say

# The families of ladders, each a module of `validation/ladders/`.
FAMILIES = ("stiff", "scale", "geometry", "motion", "contact", "precision", "symmetry")
KEYS = ("family", "ladder", "rung", "by")
SEED = 20261129  # of the search for the largest errors


def ladder_rows(family: str, folder: Path, say: Say) -> None:
    """Add the missing rows of the ladders of a family.

    Args:
        family: One of FAMILIES; also the name of the CSV file.
        folder: Folder of the CSV files.
        say: Is called with a line of text for each ladder.
    """
    rows = Rows(folder, family, KEYS)
    warm_up()
    for ladder in ladders(family):
        verdicts: list[str] = []
        for rung in ladder.rungs:
            key = {"family": family, "ladder": ladder.name, "rung": rung_text(rung)}
            if not rows.has(**key, by=OWN):
                outcomes = run_rung(ladder, rung)
                # our own comes last: a rung that was killed half-way is run again
                for outcome in reversed(outcomes):
                    rows.add(**key, **outcome._asdict())
                verdicts.append(outcomes[0].verdict)
        if verdicts:
            say(f"{family}: {ladder.name}: {_counts(verdicts)}")


def _counts(verdicts: Iterable[str]) -> str:
    found = list(verdicts)
    return ", ".join(f"{found.count(v)} {v}" for v in VERDICTS if v in found)


def bound_rows(folder: Path, say: Say) -> None:
    """Add the missing rows of the derived bounds: the largest error found over each."""
    from validation.bounds import proofs, zones

    rows = Rows(folder, "bounds", ("bound",))
    for bound in (*proofs.BOUNDS, *zones.BOUNDS):
        if rows.has(bound=bound.name):
            continue
        found = search(bound, SEED, bound.tries)
        rows.add(
            bound=bound.name,
            file=bound.file,
            sentence=bound.sentence,
            ratio=found.ratio,
            tried=found.tried,
            seed=SEED,
            worst=bound.written(found.worst),
        )
        say(f"bounds: {bound.name}: {found.ratio:.3g} of the bound")


def _random_step_rows(folder: Path, say: Say) -> None:
    from validation.study.random_steps import random_steps

    random_steps(folder, say)


def _input_rows(folder: Path, say: Say) -> None:
    from validation.study.fuzz import measure

    measure(folder, say)


def _time_rows(folder: Path, say: Say) -> None:
    from validation.study import stability_time

    stability_time.rows(folder, say)


def _before_rows(folder: Path, say: Say) -> None:
    from validation.study.stability_before import before_rows

    before_rows(folder, say)


def _kill_rows(folder: Path, say: Say) -> None:
    from validation.study.kills import measure

    measure(folder, say)


PARTS: dict[str, Part] = {
    **{family: partial(ladder_rows, family) for family in FAMILIES},
    "random-steps": _random_step_rows,
    "input": _input_rows,
    "time": _time_rows,
    "kills": _kill_rows,
    "bounds": bound_rows,
    "before": _before_rows,
}

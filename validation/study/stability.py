"""Study of stability: how far the method holds, where it ends, and what the program says beyond.

Each part adds the rows that are missing. A rung of a ladder runs in a process of its own, with
limits of time and memory, so that a crash is a row and not the end of the study. `python -m
validation study stability` starts it.
"""

from collections.abc import Iterable
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np

from izo_ref import resolve
from validation.bounds.search import search
from validation.ladders.judge_zone import judge_zone
from validation.ladders.ladder import NO_ANSWER, OWN, VERDICTS, WRONG, Ladder, Outcome, Run, Rung
from validation.limits import Limits, NotDecidedError, limited
from validation.rows import Rows
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone
from validation.study.parts import Part, Say

# The families of ladders, each a module of `validation/ladders/`.
FAMILIES = ("stiff", "scale", "geometry", "motion", "contact", "precision", "symmetry")
KEYS = ("family", "ladder", "rung", "by")
SEED = 20261129  # of the search for the largest errors
MEMORY_BYTES = 4 << 30  # of one rung, in addition to what is in use


def ladders(family: str) -> list[Ladder]:
    """Return the ladders of a family, one of FAMILIES."""
    return list(import_module(f"validation.ladders.{family}").LADDERS)


def run_rung(ladder: Ladder, rung: Rung) -> list[Outcome]:
    """Run one rung in a process of its own; a rung without an answer is an outcome, too."""
    try:
        return limited(Limits(ladder.seconds, MEMORY_BYTES), _run, ladder.run, rung)
    except NotDecidedError as error:
        return [Outcome(NO_ANSWER, "no answer", note=f"It {error}.")]
    except Exception as error:  # a fault of the ladder, or of the program: neither may hide
        return [Outcome(WRONG, f"exception {type(error).__name__}", note=str(error))]


def _run(run: Run, rung: Rung) -> list[Outcome]:
    return list(run(rung))


def ladder_rows(family: str, folder: Path, say: Say) -> None:
    """Add the missing rows of the ladders of a family.

    Args:
        family: One of FAMILIES; also the name of the CSV file.
        folder: Folder of the CSV files.
        say: Is called with a line of text for each ladder.
    """
    rows = Rows(folder, family, KEYS)
    _warm_up()
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


def rung_text(rung: Rung) -> str:
    """Return the text of a rung in a row."""
    return rung if isinstance(rung, str) else f"{rung:.12g}"


def _counts(verdicts: Iterable[str]) -> str:
    found = list(verdicts)
    return ", ".join(f"{found.count(v)} {v}" for v in VERDICTS if v in found)


def _warm_up() -> None:
    """Load what is compiled, so that the processes of the rungs have it."""
    rng = np.random.default_rng(0)
    resolve(meeting_sheets(rng, 200))
    judge_zone(random_zone(rng, 4))


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
}

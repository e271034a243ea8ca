"""Run single rungs, each in a process of its own, with the core that this process imports.

`python -m validation.ladders.rungs FAMILY` answers questions of `study/stability_before.py`, which
starts it where another core is imported.
"""

import json
import sys
from importlib import import_module
from typing import TextIO

import numpy as np

import izo_ref
from validation.ladders.judge_zone import judge_zone
from validation.ladders.ladder import NO_ANSWER, WRONG, Ladder, Outcome, Run, Rung
from validation.limits import Limits, NotDecidedError, limited
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone

MEMORY_BYTES = 4 << 30  # of one rung, in addition to what is in use


def ladders(family: str) -> list[Ladder]:
    """Return the ladders of a family, which is the name of its module in this folder."""
    return list(import_module(f"validation.ladders.{family}").LADDERS)


def rung_text(rung: Rung) -> str:
    """Return the text of a rung in a row."""
    return rung if isinstance(rung, str) else f"{rung:.12g}"


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


def warm_up() -> None:
    """Load what is compiled, so that the processes of the rungs have it."""
    rng = np.random.default_rng(0)
    izo_ref.resolve(meeting_sheets(rng, 200))
    judge_zone(random_zone(rng, 4))


def answer(family: str, questions: TextIO, answers: TextIO) -> None:
    """Answer questions until there are no more.

    Args:
        family: Family of the ladders.
        questions: JSON lists `[name of a ladder, text of a rung]`, one a line.
        answers: Receives the file of the core, then the fields of our outcome of each rung.
    """
    known = {ladder.name: ladder for ladder in ladders(family)}
    print(izo_ref.__file__, file=answers, flush=True)
    warm_up()
    for line in questions:
        name, text = json.loads(line)
        (rung,) = (rung for rung in known[name].rungs if rung_text(rung) == text)
        outcome = run_rung(known[name], rung)[0]
        # a number may be one of numpy, which JSON does not know
        print(json.dumps(outcome, default=lambda value: value.item()), file=answers, flush=True)


if __name__ == "__main__":
    answer(sys.argv[1], sys.stdin, sys.stdout)

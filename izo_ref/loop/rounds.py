"""The rounds that take the normals again at the answer (docs/method section 6)."""

from __future__ import annotations

from izo_ref.base.deadline import OutOfTimeError
from izo_ref.base.options import Options
from izo_ref.loop.iterate import Iteration, Loop

# Work that the rounds with new normals may always do, see `_work`: 0.04 to 0.2 s.
LITTLE_WORK = 10_000


def relinearize(loop: Loop, options: Options) -> None:
    """Take the normals again at the answer, as often as it pays (docs/method section 6)."""
    best = loop.step.objective()
    budget = max(options.relinearize_budget * _work(loop.history), LITTLE_WORK)
    n_main = len(loop.history)
    loop.times.begin_rounds()
    for number in range(1, options.relinearize + 1):
        if _work(loop.history[n_main:]) > budget:
            return
        saved = loop.step.save()
        loop.step.relinearize()
        try:
            better = loop.run(number, limit=best)
        except OutOfTimeError:
            better = False
            loop.times.note("The answer is that of the rounds before.")
        if not better:
            loop.step.restore(saved)
            return
        value = loop.step.objective()
        paid = value <= best * (1.0 - options.relinearize_gain)
        best = value
        if not paid:
            return


def _work(history: list[Iteration]) -> int:
    """Return the work of some iterations: vertices that moved, and impacts that were found.

    For one of them, an iteration takes 4 us on stack-6k and 13 to 18 us on armadillo-rollers. The
    work is the same on every device and with every plan.
    """
    return sum(entry.moved + entry.found for entry in history)

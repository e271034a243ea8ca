"""One input: what is called, what the contract says of it, and how the program answered."""

import signal
import time
import traceback
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from izo_ref import IzoError

SECONDS = 5.0  # of processor time that one input may take
LONGEST_S = 20.0  # of wall time, after which an input that waits is interrupted
ACCEPTED, REFUSED = "accepted", "refused"
CRASH, HANG, SILENT = "crash", "hang", "silent acceptance"
UNFAIR, UNNAMED = "refusal of valid input", "message without the offender"
PROBLEMS = (CRASH, HANG, SILENT, UNFAIR, UNNAMED)


class Wrong(NamedTuple):
    """One way in which an input breaks the contract.

    Attributes:
        argument: Text that a message has to have: the argument, or the name of a file.
        place: A further text: where the first offender is; empty if there is no place.
    """

    argument: str
    place: str = ""


class Trial(NamedTuple):
    """An input that is ready to be tried.

    Attributes:
        call: Hands the input in, and returns the result.
        wrongs: Ways in which the input breaks the contract; empty if it is valid, None if the
            contract leaves it open.
        judge: Returns what is wrong with a result, or an empty text.
        what: Describes the input.
    """

    call: Callable[[], Any]
    wrongs: Sequence[Wrong] | None
    judge: Callable[[Any], str]
    what: str


class Outcome(NamedTuple):
    """How the program answered.

    Attributes:
        kind: One of the words above.
        error: Name of the error that refused the input, or an empty text.
        detail: What went wrong, for a problem.
        seconds: Processor time [s].
    """

    kind: str
    error: str
    detail: str
    seconds: float


class TooLongError(BaseException):
    """An input waits; it is no `Exception`, so that no reader takes it for damage."""


def run_trial(trial: Trial) -> Outcome:
    """Hand one input in, twice if it takes long, because the first time may compile code."""
    outcome = _run_once(trial)
    return _run_once(trial) if outcome.kind == HANG else outcome


def _run_once(trial: Trial) -> Outcome:
    begin = time.process_time()
    signal.signal(signal.SIGALRM, _interrupt)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            kind, error, detail = _answer(trial)
    except TooLongError:
        return Outcome(HANG, "", f"waits for more than {LONGEST_S:g} s: {trial.what}", LONGEST_S)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    seconds = time.process_time() - begin
    if caught and kind not in PROBLEMS:
        kind, detail = CRASH, f"warning: {caught[0].message}: {trial.what}"
    if seconds > SECONDS and kind not in PROBLEMS:
        kind, detail = HANG, f"{seconds:.1f} s: {trial.what}"
    return Outcome(kind, error, detail, seconds)


def _interrupt(number: int, frame: Any) -> None:
    raise TooLongError


def _answer(trial: Trial) -> tuple[str, str, str]:
    """Return the kind of an answer, the name of its error, and what is wrong with it."""
    try:
        result = trial.call()
    except IzoError as error:
        return _judged_refusal(trial, error)
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{last.filename.rpartition('/')[2]}:{last.lineno}"
        text = f"{type(error).__name__} at {place}: {error}"[:200]
        return CRASH, type(error).__name__, f"{text}: {trial.what}"
    if trial.wrongs:
        return SILENT, "", f"{trial.wrongs[0]}: {trial.what}"
    problem = trial.judge(result)
    if problem:
        return SILENT, "", f"{problem}: {trial.what}"
    return ACCEPTED, "", ""


def _judged_refusal(trial: Trial, error: IzoError) -> tuple[str, str, str]:
    name, text = type(error).__name__, str(error)
    shown = f"{name}: {text[:160]}: {trial.what}"
    if "pickle" in text.lower() or "Traceback" in text:
        return UNNAMED, name, shown
    if trial.wrongs is None:
        return REFUSED, name, ""
    if not trial.wrongs:
        return UNFAIR, name, shown
    if any(wrong.argument in text and wrong.place in text for wrong in trial.wrongs):
        return REFUSED, name, ""
    return UNNAMED, name, f"{trial.wrongs[0]}: {shown}"

"""`python -m validation shrink`: cut a failing step or zone down to a few simple numbers."""

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.app.files import check_outputs
from izo_ref.base.errors import FileFormatError
from validation.shrink import failing, snippet, steps, zones
from validation.shrink.search import OutOfTimeError, Search
from validation.stability_steps.case import load_case

SHRUNK, NOT_FAILING = 0, 1


class Kind(NamedTuple):
    """What the search needs to know of a kind of input."""

    load: Callable[[Path], Any]
    save: Callable[[Path, Any], None]
    key: Callable[[Any], bytes]
    describe: Callable[[Any], str]
    shrink: Callable[[Search[Any]], None]
    snippet: Callable[[Any], str]
    valid: Callable[[Any], str]  # how it comes through the door


STEP = Kind(
    load_case,
    lambda path, case: case.save(path),
    steps.key,
    steps.describe,
    steps.shrink_step,
    snippet.step_snippet,
    steps.door,
)
ZONE = Kind(
    zones.load_zone,
    zones.save_zone,
    zones.key,
    zones.describe,
    zones.shrink_zone,
    snippet.zone_snippet,
    lambda _: "",
)


def run(args: Namespace, say: Callable[[str], object]) -> int:
    """Shrink the input that the arguments name.

    Args:
        args: Arguments of `flags.add_flags`.
        say: Is called with each line of text.

    Returns:
        0 if it failed and the smaller input is written, 1 if it does not fail.

    Raises:
        FileFormatError: A file cannot be read or written.
        IzoError: The input is no zone problem.
    """
    kind = STEP if _is_step(args.input) else ZONE
    output = args.output or args.input.with_name(f"{args.input.stem}-shrunk.npz")
    check_outputs({"the input": args.input}, {"--output": output})
    first = kind.load(args.input)
    judge = _judge(args, kind)
    failure = judge(first)
    if failure is None:
        say("it does not fail, so there is nothing to shrink")
        return NOT_FAILING
    say(f"fails: {failure}")
    best, ended = shrink(first, kind, judge, failure, args.seconds, say)
    kind.save(output, best)
    say(f"before: {kind.describe(first)}")
    say(f"after:  {kind.describe(best)}")
    say(f"{output}: written, {ended}")
    say("")
    say(kind.snippet(best))
    return SHRUNK


def shrink(
    first: Any,
    kind: Kind,
    judge: failing.Judge,
    failure: str,
    seconds: float,
    say: Callable[[str], object],
) -> tuple[Any, str]:
    """Return the smallest input found that fails in the same way, and how the search ended.

    Args:
        first: The input that fails.
        kind: What it is.
        judge: Says how an input fails.
        failure: How the first one does.
        seconds: Time of the search [s].
        say: Is called with a line of text as the search goes on.
    """
    valid = kind.valid(first)

    def fails(candidate: Any) -> bool:
        return kind.valid(candidate) == valid and judge(candidate) == failure

    search = Search(first, fails, kind.key, seconds, say)
    try:
        kind.shrink(search)
    except OutOfTimeError:
        return search.best, f"not minimal: {seconds:g} s are over; {search.tried} tried"
    except KeyboardInterrupt:
        return search.best, f"not minimal: interrupted; {search.tried} tried"
    return search.best, f"nothing more can be left out; {search.tried} tried"


def _judge(args: Namespace, kind: Kind) -> failing.Judge:
    if args.command:
        return failing.by_command(args.command, kind.save, args.seconds_each)
    if kind is ZONE:
        return failing.by_zone
    return failing.by_check if args.by == "check" else failing.by_claims


def _is_step(path: Path) -> bool:
    """Return whether a file holds a step; else it holds a zone."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            names = set(archive.files)
    except (OSError, ValueError, EOFError) as error:
        raise FileFormatError(f"{path}: cannot be read: {error}") from None
    return "positions_t0" in names

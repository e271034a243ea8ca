"""Study of kills: what commands leave that are killed at random moments.

Each moment is one row: the command, the signal, when it came, and whether an output was half
written, an input was changed, or a file was left for ever. `validation/machine/kills.py` kills.
"""

import multiprocessing
import sys
import tempfile
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection
from pathlib import Path

from validation.machine.kills import killed, line, summary
from validation.machine.targets import TARGETS
from validation.rows import Row, Rows
from validation.study.parts import Say

KEYS = ("seed", "number")
SEED = 21
MOMENTS = 200
NAMES = tuple(target.name for target in TARGETS)
# The commands are forks of a process that has loaded them; elsewhere, forks are not safe.
CAN_KILL = sys.platform == "linux"


def measure(
    folder: Path,
    say: Say,
    moments: int = MOMENTS,
    seed: int = SEED,
    names: Sequence[str] = NAMES,
) -> None:
    """Kill commands at all moments that have no row yet.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line for each moment, and with the counts of all.
        moments: Number of moments.
        seed: Seed of the moments.
        names: Names of the commands, which take turns; a few for a quick run.
    """
    if not CAN_KILL:
        say("kills: not measured, because processes can be forked safely on Linux alone")
        return
    rows = Rows(folder, "kills", KEYS)
    missing = [number for number in range(moments) if not rows.has(seed=seed, number=number)]
    if not missing:
        return
    for number, row in _in_another_process(names, missing, seed):
        rows.add(seed=seed, number=number, **row)
        say(f"kills: {line(number, row)}")
    say(f"kills: {summary([row for row in rows.all() if row['seed'] == seed])}")


def _in_another_process(
    names: Sequence[str], numbers: Sequence[int], seed: int
) -> Iterator[tuple[int, Row]]:
    """Yield what `killed` yields, in a process that is free to change what its modules hold.

    Raises:
        RuntimeError: That process ended before the last moment.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send_killed, args=(sender, names, numbers, seed))
    process.start()
    sender.close()
    try:
        for _ in numbers:
            yield receiver.recv()
    except EOFError:
        process.join()
        raise RuntimeError(f"kills: their process ended with {process.exitcode}") from None
    finally:
        receiver.close()
        process.join()


def _send_killed(
    sender: Connection, names: Sequence[str], numbers: Sequence[int], seed: int
) -> None:
    targets = [target for target in TARGETS if target.name in names]
    with tempfile.TemporaryDirectory(prefix="kills-") as folder:
        for found in killed(Path(folder), targets, numbers, seed):
            sender.send(found)

"""The command `python -m validation.machine`: kill commands at random moments, and keep rows."""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

from izo_ref.app.process import run_and_exit
from validation.machine.kills import run, summary
from validation.machine.targets import TARGETS
from validation.rows import begin_run

RIGHT, WRONG = 0, 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code is 1 if an output was half written or a file was lost."""
    parser = argparse.ArgumentParser(prog="python -m validation.machine", description=__doc__)
    parser.add_argument("--moments", type=int, default=200, help="how many (default: %(default)s)")
    parser.add_argument(
        "--seed", type=int, default=21, help="of the moments (default: %(default)s)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("reports/machine/rows"),
        metavar="FOLDER",
        help="folder of the rows (default: %(default)s)",
    )
    names = [target.name for target in TARGETS]
    help_ = "kill this command alone; may be given several times (default: all)"
    parser.add_argument("--only", choices=names, action="append", metavar="COMMAND", help=help_)
    args = parser.parse_args(arguments)
    targets = [target for target in TARGETS if target.name in (args.only or names)]
    print(f"seed {args.seed}")
    begin_run(args.output, f"python -m validation.machine --seed {args.seed}", False)
    with tempfile.TemporaryDirectory(prefix="kills-") as folder:
        rows = run(args.output, Path(folder), targets, args.moments, args.seed, _say)
    print(summary(rows))
    return RIGHT if all(row["right"] for row in rows) else WRONG


def _say(line: str) -> None:
    print(line, flush=True)


if __name__ == "__main__":
    run_and_exit(main, "validation.machine")

"""The command `python -m validation`: it judges results, measures, and writes reports."""

import argparse
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from izo_ref.app.flags import add_scene_flags, with_flags
from izo_ref.app.process import run_and_exit
from izo_ref.base.errors import IzoError
from validation.commands import (
    BAD_INPUT,
    REPORTS,
    run_check,
    run_cuda,
    run_evidence,
    run_guide,
    run_house,
    run_mutants,
    run_readme,
    run_report,
    run_sequences,
    run_shrink,
    run_speed,
    run_stability,
    run_zones,
)
from validation.limits import Limits
from validation.report.catalogue import PROGRAM, STUDIES

if TYPE_CHECKING:
    from argparse import _SubParsersAction

    Subparsers = _SubParsersAction[argparse.ArgumentParser]

# Parts of the study of stability, which the help names without loading them.
STABILITY = (
    *("stiff", "scale", "geometry", "motion", "contact", "precision", "symmetry"),
    *("random-steps", "input", "time", "kills", "bounds", "before"),
)
PAGES_ONLY = "measure nothing; write the pages from the rows"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Words of the command line; None takes those of this process.

    Returns:
        Exit code: 0 passed, 1 failed, 2 bad input, 3 passed except for pairs that were left out.
    """
    args = _parser().parse_args(arguments)
    try:
        return args.run(args)
    except ModuleNotFoundError as error:
        print(f"validation: {error}; run: pip install -e .[validation]", file=sys.stderr)
        return BAD_INPUT
    except IzoError as error:
        print(f"validation: {type(error).__name__}: {with_flags(str(error))}", file=sys.stderr)
        return BAD_INPUT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Judge a result, compare solvers with oracles, test the tests, measure.",
        epilog="Exit codes: 0 passed, 1 failed, 2 bad input.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_check(commands)
    help_ = "compare the solvers of zones with oracles: zones.md"
    _add_report(_add(commands, "zones", run_zones, help_))
    help_ = "check the result of every step file (IZO_DATA, or else data/scenes): evidence/"
    sub = _add(commands, "evidence", run_evidence, help_)
    sub.add_argument("steps", nargs="*", metavar="STEP", help="names of steps; default: all")
    _add_report(sub)
    help_ = "put deliberate faults into copies of the code and run the tests: mutants.md"
    sub = _add(commands, "mutants", run_mutants, help_)
    sub.add_argument("faults", nargs="*", metavar="FAULT", help="names of faults; default: all")
    sub.add_argument("--rows", type=Path, metavar="F", help="write the rows so far to a JSON file")
    help_ = "run the vectors on our own port instead of the tests: vectors.md"
    sub.add_argument("--vectors", action="store_true", help=help_)
    help_ = "draw N faults by operator instead, and try those that have no row: random_mutants.md"
    sub.add_argument("--random", type=int, metavar="N", help=help_)
    sub.add_argument("--seed", type=int, default=21, help="of the draw (default: %(default)s)")
    _add_report(sub)
    _add_shrink(commands)
    _add_studies(commands)
    help_ = "measure error against run time: index.html and its pages"
    sub = _add(commands, "report", run_report, help_)
    sub.add_argument("--quick", action="store_true", help="fewer and smaller cases; minutes")
    sub.add_argument("--only", choices=tuple(report.name for report in STUDIES))
    help_ = "reports, or reports/quick; its rows/ has the rows: delete them to measure again"
    sub.add_argument("--pages-only", action="store_true", help=PAGES_ONLY)
    sub.add_argument("-o", "--output", type=Path, metavar="FOLDER", help=help_)
    help_ = "write the figures of all reports into reports/README.md, borders into docs/limits.md"
    sub = _add(commands, "readme", run_readme, help_)
    sub.add_argument("--check", action="store_true", help="write nothing; fail if they differ")
    _add(commands, "guide", run_guide, "write the tables of the stages into docs/porting-stages.md")
    help_ = "show the floors of the package, by its imports, and the sizes of files and functions"
    sub = _add(commands, "house", run_house, help_)
    sub.add_argument("--write", action="store_true", help="update the floors in README.md")
    return parser


def _add(
    commands: "Subparsers", name: str, run: Callable[[Namespace], int], text: str
) -> argparse.ArgumentParser:
    sub = commands.add_parser(name, help=text, description=text)
    sub.set_defaults(run=run)
    return sub


def _add_report(sub: argparse.ArgumentParser) -> None:
    """Add the options of a command that measures rows and writes a page."""
    sub.add_argument("--pages-only", action="store_true", help=PAGES_ONLY)
    sub.add_argument("-o", "--output", type=Path, default=REPORTS, metavar="FOLDER")


def _add_check(commands: "Subparsers") -> None:
    sub = _add(commands, "check", run_check, "judge a result of a step, from any program")
    sub.add_argument("step", metavar="STEP.npz")
    help_ = "end positions; default: those of izo_ref.resolve"
    sub.add_argument("--result", metavar="OUT.npz", help=help_)
    sub.add_argument("--thickness", type=float, metavar="D", help="[m], for izo_ref.resolve")
    sub.add_argument("--json", metavar="F", help="write the verdict to a JSON file")
    help_ = "write a page that shows the step in 3D, with what is wrong"
    sub.add_argument("--html", metavar="F", help=help_)
    help_ = "other results, whose objectives are compared"
    sub.add_argument("--known", nargs="*", default=(), metavar="OUT.npz", help=help_)
    add_scene_flags(sub)
    limits = Limits()
    sub.add_argument(
        "--seconds",
        type=float,
        default=limits.seconds,
        metavar="S",
        help="time of each judge of others (default: %(default)g)",
    )
    sub.add_argument(
        "--gib",
        type=float,
        default=limits.bytes / 2**30,
        metavar="GIB",
        help="memory of each judge of others (default: %(default)g)",
    )


def _add_shrink(commands: "Subparsers") -> None:
    from validation.shrink.flags import add_flags

    help_ = "cut a failing step or zone down to a few simple numbers"
    add_flags(_add(commands, "shrink", run_shrink, help_))


def _add_studies(commands: "Subparsers") -> None:
    text = "measure speed, stability or animations, and write a page"
    sub = commands.add_parser("study", help=text, description=text)
    studies = sub.add_subparsers(required=True, metavar="STUDY")
    help_ = "detection, whole steps, deep contact, the next step, what rules save, size: speed/"
    sub = _add(studies, "speed", run_speed, help_)
    parts = ("detection", "resolve", "deep", "next", "ablation", "cold", "scale")
    sub.add_argument("--only", choices=parts)
    _add_report(sub)
    help_ = "what kernels need of a GPU; with a GPU, its results and times next to the CPU: cuda/"
    sub = _add(studies, "cuda", run_cuda, help_)
    parts = ("kernels", "launches", "bounds")  # of these three none needs a GPU
    parts += ("check", "detection", "steps", "blocks", "zones", "memory")
    sub.add_argument("--only", choices=parts)
    _add_report(sub)
    help_ = "stiff and extreme cases: how far the method holds, and what it says beyond: stability/"
    sub = _add(studies, "stability", run_stability, help_)
    sub.add_argument("--only", choices=STABILITY)
    _add_report(sub)
    help_ = "animations: every format, tangled starts, frames a second, memory: sequences/"
    sub = _add(studies, "sequences", run_sequences, help_)
    sub.add_argument("--only", choices=("formats", "tangles", "speed", "memory"))
    _add_report(sub)


if __name__ == "__main__":
    run_and_exit(main, "validation")

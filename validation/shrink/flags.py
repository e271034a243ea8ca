"""The arguments of `python -m validation shrink`; this file imports nothing that takes time."""

import argparse
from pathlib import Path

SECONDS = 600.0
JUDGES = ("check", "claims")


def add_flags(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    command.add_argument("input", type=Path, metavar="STEP.npz", help="a step or a zone that fails")
    help_ = (
        "command that fails (exit code other than 0); {} is the path of a candidate, or it is last"
    )
    command.add_argument("--while", dest="command", metavar="COMMAND", help=help_)
    help_ = (
        "without --while, what fails: `python -m validation check`, or a claim of the result that "
        "the study of random steps refutes (default: %(default)s)"
    )
    command.add_argument("--by", choices=JUDGES, default=JUDGES[0], help=help_)
    help_ = "the smaller input (default: STEP-shrunk.npz beside STEP.npz)"
    command.add_argument("-o", "--output", type=Path, metavar="OUT.npz", help=help_)
    help_ = "time of the search; the best input so far is written then (default: %(default)g)"
    command.add_argument("--seconds", type=float, default=SECONDS, metavar="S", help=help_)
    help_ = "time of one run of COMMAND (default: %(default)g)"
    command.add_argument("--seconds-each", type=float, default=60.0, metavar="S", help=help_)

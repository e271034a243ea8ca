"""The command `python -m validation`: the evidence."""

import argparse
import sys
from pathlib import Path

from izo_ref.errors import IzoError
from izo_ref.io import check_writable, replacing, save_json
from validation.check import check_files, verdict_summary

PASSED, FAILED, BAD_INPUT = 0, 1, 2
REPORTS = Path("reports")


def main(arguments=None) -> int:
    """Run a command; returns 0 passed, 1 failed, 2 bad input."""
    args = _parser().parse_args(arguments)
    try:
        return args.run(args)
    except IzoError as error:
        print(f"validation: {type(error).__name__}: {error}", file=sys.stderr)
        return BAD_INPUT


def _check(args):
    for path in (args.json, args.html):
        if path:
            check_writable(path)
    scene, verdict = check_files(
        args.step, args.result, args.thickness, args.initial_intersections, _say, args.known
    )
    if args.json:
        save_json(args.json, verdict_summary(verdict))
    if args.html:
        from validation.report.page import verdict_page

        title = f"{Path(args.result or args.step).name}"
        with replacing(args.html) as file:
            file.write(verdict_page(title, scene, verdict).encode())
    print("passed" if verdict.passed else "failed")
    return PASSED if verdict.passed else FAILED


def _say(fact):
    mark = {True: "passed", False: "FAILED", None: "      "}[fact.passed]
    print(f"{mark}  {fact.question} | {fact.by} | {fact.answer} | {fact.seconds:.2f} s", flush=True)


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m validation",
        description="Evidence: judge a result, compare solvers with oracles, test the tests.",
        epilog="Exit codes: 0 passed, 1 failed, 2 bad input.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    text = "judge a result of a step, ours or anybody's"
    sub = commands.add_parser("check", help=text, description=text)
    sub.set_defaults(run=_check)
    sub.add_argument("step", metavar="STEP.npz")
    sub.add_argument("--result", metavar="OUT.npz", help="end positions; resolved here if none")
    sub.add_argument("--thickness", type=float, metavar="D", help="[m], of our own result")
    sub.add_argument("--json", metavar="F", help="write the verdict")
    sub.add_argument("--html", metavar="F", help="write a page with pictures of what is wrong")
    sub.add_argument(
        "--known",
        nargs="*",
        default=(),
        metavar="OUT.npz",
        help="other results, to compare the objective with",
    )
    sub.add_argument(
        "--initial-intersections",
        choices=("raise", "exclude"),
        default="raise",
        help="what to do with pairs that intersect at the start",
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())

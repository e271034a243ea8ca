"""The command `izo conform`: check a port, stage by stage."""

import argparse
import shlex
from pathlib import Path

from izo_ref.app.files import replacing
from izo_ref.app.standard_output import (
    STANDARD_OUTPUT,
    check_reports,
    json_text,
    save_report,
    say,
)
from izo_ref.app.vectors_command import stage_name
from izo_ref.base.errors import FileFormatError, OptionError
from izo_ref.porting.cases import DTYPES, Case
from izo_ref.porting.conform.divergence import report_record
from izo_ref.porting.conform.folder import REPLIES, REQUESTS, judge_folder, write_requests
from izo_ref.porting.conform.known import Compared, compare, known_text, read_known
from izo_ref.porting.conform.page import page_text
from izo_ref.porting.conform.report import Report
from izo_ref.porting.conform.run import Choice, Run, requests_of, run_program
from izo_ref.porting.conform.terminal import report_text
from izo_ref.porting.files import load_cases, vectors_folder
from izo_ref.porting.stages import STAGE

CONFORMS, DOES_NOT = 0, 1
SECONDS = 10.0  # for one case, if nothing else is asked for

TEXT = "check a port of the method stage by stage, and show the first wrong stage"
EPILOG = (
    "Exit codes: 0 everything that was judged is right, 1 it is not, 2 bad usage. A stage that the "
    "port does not have is not supported, which is no failure."
)


def add_conform(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command to the parser of `izo`."""
    command = commands.add_parser("conform", help=TEXT, description=TEXT, epilog=EPILOG)
    command.set_defaults(command="conform")
    port = command.add_mutually_exclusive_group(required=True)
    port.add_argument("--exec", metavar="CMD", help="the port, with its arguments, in quotes")
    port.add_argument(
        "--folder",
        metavar="DIR",
        help=f"exchange by files, for a port elsewhere: writes DIR/{REQUESTS}; once there is "
        f"DIR/{REPLIES}, judges that",
    )
    port.add_argument(
        "--dump",
        metavar="FOLDER",
        help="judge arrays that a port wrote of its own scene, .npy files or one .npz by the names "
        "of `izo resolve --trace`; of the other flags, only --json belongs to it",
    )
    port.add_argument(
        "--self-test",
        action="store_true",
        help="show that broken replies and misbehaving programs are rejected",
    )
    _add_choice(command)
    _add_reports(command)
    _add_limits(command)


def _add_limits(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--seconds",
        type=_positive,
        default=SECONDS,
        metavar="S",
        help="how long the port may take for one case (default: %(default)g)",
    )
    command.add_argument(
        "--gib",
        type=_positive,
        metavar="G",
        help="largest address space of the port [GiB]; programs for GPUs reserve much more of it "
        "than they use (default: no limit)",
    )
    command.add_argument(
        "--show-errors",
        action="store_true",
        help="show what the port writes to its standard error while it runs",
    )


def _add_choice(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--stage",
        action="append",
        default=[],
        type=stage_name,
        choices=tuple(STAGE),
        metavar="S7",
        help="take the cases of this stage alone, such as S7, s7 or 7; may be given several times",
    )
    command.add_argument(
        "--dtype", choices=DTYPES, help="take this type of floats alone: float64 or float32"
    )
    command.add_argument(
        "--case",
        action="append",
        default=[],
        metavar="ID",
        help="take this case alone; may be given several times",
    )
    command.add_argument(
        "--vectors", metavar="FOLDER", help="folder of the vectors (default: those of izo_ref)"
    )


def _add_reports(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--failures",
        metavar="FILE",
        help="known failures, lines of 'case-id dtype output  # comment': they do not count, but "
        "one that passes now or fails otherwise does; entries of cases that are not judged in this "
        "run say nothing",
    )
    command.add_argument(
        "--write-failures", metavar="FILE", help="write the failures of this run in that format"
    )
    command.add_argument(
        "--json",
        metavar="FILE",
        help="write the report as JSON; - is the standard output, and the text then goes to the "
        "standard error",
    )
    command.add_argument("--html", metavar="FILE", help="write the report as one page; or -")


def _positive(word: str) -> float:
    """Return the positive number that a word is."""
    try:
        number = float(word)
    except ValueError:
        number = -1.0
    if not 0.0 < number < 1e6:
        raise argparse.ArgumentTypeError(f"expected a positive number, got {word!r}")
    return number


def conform(args: argparse.Namespace) -> int:
    """Run `izo conform`.

    Args:
        args: What the parser made of the command line.

    Returns:
        The exit code.

    Raises:
        OptionError: A word of the command line names nothing.
        FileFormatError: A file cannot be read or written, or a dump has an array of another shape.
        IzoError: `Scene` does not accept the scene of a dump.
        VectorsError: The vectors are missing or damaged.
    """
    outputs = {"--json": args.json, "--html": args.html, "--write-failures": args.write_failures}
    check_reports({"--failures": args.failures, "--dump": args.dump}, outputs)
    if args.dump is not None:
        return _judge_dump(args)
    folder = vectors_folder() if args.vectors is None else Path(args.vectors)
    cases = load_cases(folder)
    if args.self_test:
        return _self_test(cases, outputs)
    known = {}
    if args.failures is not None:
        known = read_known(Path(args.failures), {case.id for case in cases})
    run = _run(args, cases)
    if run is None:
        return CONFORMS
    compared = compare(run.rows, known) if known else Compared(frozenset(), ())
    report = Report(run, compared, _again(args), args.vectors)
    _save_reports(args, report)
    text = f"vectors: {folder.resolve()}, {len(run.rows)} requests\n{report_text(report)}"
    say(text, aside=STANDARD_OUTPUT in outputs.values())
    return CONFORMS if report.is_right else DOES_NOT


def _save_reports(args: argparse.Namespace, report: Report) -> None:
    """Write the reports that are asked for."""
    if args.json:
        save_report(args.json, json_text(report_record(report)))
    if args.html:
        save_report(args.html, page_text(report))
    if args.write_failures:
        save_report(args.write_failures, known_text(report.run.rows))


def _again(args: argparse.Namespace) -> tuple[str, ...]:
    """Return the words that run the same port on the same vectors."""
    words = ["--exec", args.exec] if args.exec is not None else ["--folder", args.folder]
    words += ["--vectors", args.vectors] if args.vectors is not None else []
    words += ["--seconds", f"{args.seconds:g}"] if args.seconds != SECONDS else []
    return tuple(words + (["--gib", f"{args.gib:g}"] if args.gib is not None else []))


def _judge_dump(args: argparse.Namespace) -> int:
    """Judge arrays that a port wrote of its own scene; the vectors have no part in it."""
    from izo_ref.porting.dump import judge_dump

    others = {
        "--stage": args.stage,
        "--dtype": args.dtype,
        "--case": args.case,
        "--vectors": args.vectors,
        "--failures": args.failures,
        "--write-failures": args.write_failures,
        "--html": args.html,
    }
    given = [name for name, value in others.items() if value]
    if given:
        raise OptionError(f"{given[0]}: --dump judges no vectors, so it takes --json alone")
    report = judge_dump(args.dump)
    if args.json:
        save_report(args.json, json_text(report.record()))
    say(report.text(), aside=args.json == STANDARD_OUTPUT)
    return CONFORMS if report.agrees else DOES_NOT


def _run(args: argparse.Namespace, cases: list[Case]) -> Run | None:
    """Return the run; None if requests were written to a folder, and nothing is judged yet."""
    unknown = set(args.case) - {case.id for case in cases}
    if unknown:
        raise OptionError(f"--case: there is no case {', '.join(sorted(unknown))}")
    choice = Choice(args.stage, [args.dtype] if args.dtype else [], args.case)
    requests = requests_of(cases, choice)
    if not requests:
        raise OptionError("--stage, --dtype and --case leave no case of the vectors")
    if args.exec is not None:
        return run_program(
            _words(args.exec), requests, args.seconds, args.gib, show_errors=args.show_errors
        )
    folder = Path(args.folder)
    if (folder / REPLIES).exists():
        return judge_folder(folder, cases, choice)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise FileFormatError(f"{folder}: cannot be created: {error.strerror}") from None
    with replacing(folder / REQUESTS) as file:
        write_requests(file, requests)
    say(
        f"{folder / REQUESTS}: {len(requests)} requests behind the greeting. Let the port write "
        f"one line for each to {folder / REPLIES}, then run this command again.\n"
    )
    return None


def _words(text: str) -> list[str]:
    """Return the words of a command."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise OptionError(f"--exec: {text!r} is no command: {error}") from None
    if not words:
        raise OptionError("--exec: expected a command, got nothing")
    return words


def _self_test(cases: list[Case], outputs: dict[str, str | None]) -> int:
    from izo_ref.porting.conform.selftest import self_test

    given = [name for name, path in outputs.items() if path is not None]
    if given:
        raise OptionError(f"{given[0]}: --self-test writes no report")
    result = self_test(cases)
    say(result.text)
    return DOES_NOT if result.problems else CONFORMS

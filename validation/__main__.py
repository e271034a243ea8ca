"""The command `python -m validation`: it judges results, measures, and writes reports."""

import argparse
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from izo_ref.app.files import (
    check_outputs,
    check_writable,
    make_folder,
    replacing,
    save_json,
    save_text,
)
from izo_ref.app.flags import add_scene_flags, scene_modes, with_flags
from izo_ref.app.process import run_and_exit
from izo_ref.base.errors import IzoError
from validation import json_rows
from validation.limits import Limits
from validation.provenance import made_by
from validation.report.catalogue import PROGRAM, STUDIES
from validation.rows import Row, begin_run

if TYPE_CHECKING:
    from argparse import _SubParsersAction

    from validation.judge import Fact

    Subparsers = _SubParsersAction[argparse.ArgumentParser]

PASSED, FAILED, BAD_INPUT, PASSED_EXCEPT_EXCLUDED = 0, 1, 2, 3
REPORTS = Path("reports")
# Parts of the study of stability, which the help names without loading them.
STABILITY = (
    *("stiff", "scale", "geometry", "motion", "contact", "precision", "symmetry"),
    *("random-steps", "input", "time", "bounds"),
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


def _check(args: Namespace) -> int:
    from validation.check import check_files, verdict_line, verdict_summary

    others = {f"--known {path}": path for path in args.known}
    inputs = {"the step": args.step, "--result": args.result, **others}
    check_outputs(inputs, {"--json": args.json, "--html": args.html})
    scene, verdict = check_files(
        args.step,
        args.result,
        args.thickness,
        scene_modes(args),
        _say,
        args.known,
        Limits(args.seconds, int(args.gib * 2**30)),
    )
    if args.json:
        save_json(args.json, verdict_summary(verdict))
    if args.html:
        from validation.report.page import verdict_page

        title = Path(args.result or args.step).name
        with replacing(args.html) as file:
            file.write(verdict_page(title, scene, verdict).encode())
    print(verdict_line(verdict))
    if not verdict.passed:
        return FAILED
    return PASSED_EXCEPT_EXCLUDED if verdict.excluded["count"] else PASSED


def _zones(args: Namespace) -> int:
    from validation.report import zones

    if not args.pages_only:
        made = made_by(f"{PROGRAM} zones")
        json_rows.save(args.output / zones.FILE, made, _zone_rows())
    print(zones.page(args.output, args.output))
    return PASSED


def _zone_rows() -> dict[str, list[Row]]:
    from validation.study import nonlinear, steps, zones

    rows = {
        "random": zones.random_zone_rows(),
        "scaling": zones.scaling_rows(),
        "sizes": zones.size_rows(),
        "steps": [],
        "nonlinear": nonlinear.nonlinear_rows(),
    }
    if steps.available():
        for name in ("armadillo-rollers", "sheets-50k"):
            rows["steps"] += zones.step_zone_rows(name, steps.load_step(name))
        for name in ("zone-armadillo-first", "zone-armadillo-last"):
            rows["steps"] += zones.problem_rows(name, steps.load_zone(name))
    return rows


def _evidence(args: Namespace) -> int:
    from validation.report import evidence as report
    from validation.study import evidence, steps

    folder, passed = args.output / "evidence", True
    if not args.pages_only:
        made = made_by(f"{PROGRAM} evidence")
        for name in args.steps or steps.step_names():
            print(f"-- {name}", flush=True)
            row = evidence.step_row(name, _say)
            json_rows.save(folder / f"{name}.json", made, [row])
            # a blocked result says itself that it is not free, and `check` has to find that
            passed &= "refused" in row or row["verdict"]["passed"] is (row["status"] != "BLOCKED")
        wrong = evidence.wrong_rows(_say)
        json_rows.save(folder / f"{report.WRONG}.json", made, wrong)
        passed &= not any(row["verdict"]["passed"] for row in wrong)
    print(report.page(folder, folder))
    return PASSED if passed else FAILED


def _mutants(args: Namespace) -> int:
    if args.vectors:
        return _mutants_by_vectors(args)
    if args.random:
        return _random_mutants(args)
    from validation.mutants.run import run_mutants
    from validation.report import mutants

    passed = True
    if not args.pages_only:
        # before the run, which takes a snapshot of the sources and tests that for many minutes
        made = made_by(f"{PROGRAM} mutants")
        try:
            rows = run_mutants(args.faults or None, args.rows)
        except ValueError as error:  # an unknown name
            print(f"validation: {error}", file=sys.stderr)
            return BAD_INPUT
        passed = all(row["caught"] for row in rows)
        if args.faults:
            print("only some faults were tried, so no report is written")
            return PASSED if passed else FAILED
        json_rows.save(args.output / mutants.FILE, made, rows)
    print(mutants.page(args.output, args.output))
    return PASSED if passed else FAILED


def _house(args: Namespace) -> int:
    from validation import house

    print(house.picture(), house.summary(), sep="\n\n")
    if args.write:
        readme = house.ROOT / "README.md"
        save_text(readme, house.with_picture(readme.read_text()))
    return PASSED


def _mutants_by_vectors(args: Namespace) -> int:
    from validation.mutants.vectors import run_vectors
    from validation.report import vectors

    passed = True
    if not args.pages_only:
        made = made_by(f"{PROGRAM} mutants --vectors")
        try:
            rows = run_vectors(args.faults or None, args.rows)
        except ValueError as error:  # an unknown name, or one that no vector can notice
            print(f"validation: {error}", file=sys.stderr)
            return BAD_INPUT
        caught = sum(row["caught"] for row in rows)
        passed = caught == len(rows)
        print(f"the vectors notice {caught} of {len(rows)} faults")
        if args.faults:
            return PASSED if passed else FAILED
        json_rows.save(args.output / vectors.FILE, made, rows)
    print(vectors.page(args.output, args.output))
    return PASSED if passed else FAILED


def _random_mutants(args: Namespace) -> int:
    from validation.mutants.random_run import run_random
    from validation.report import random_mutants

    path = args.rows or args.output / random_mutants.FILE
    passed = True
    if not args.pages_only:
        made = made_by(f"{PROGRAM} mutants --random {args.random} --seed {args.seed}")
        rows = run_random(args.random, args.seed, path, made)
        passed = all(row["caught"] or row["reason"] for row in rows)
    if args.rows is None:
        print(random_mutants.page(args.output, args.output))
    return PASSED if passed else FAILED


def _readme(args: Namespace) -> int:
    from validation.report import limits_table, readme

    pages = {readme.README: readme.with_figures, limits_table.PAGE: limits_table.with_borders}
    same = True
    for path, with_rows in pages.items():
        text = path.read_text()
        expected = with_rows(text)
        if args.check and text != expected:
            print(f"{path}: the figures are not those of the rows", file=sys.stderr)
            same = False
        elif not args.check:
            save_text(path, expected)
            print(path)
    return PASSED if same else FAILED


def _guide(args: Namespace) -> int:
    from izo_ref.porting.guide import with_tables
    from validation.provenance import ROOT

    guide = ROOT / "docs" / "porting-stages.md"
    save_text(guide, with_tables(guide.read_text()))
    print(guide)
    return PASSED


def _report(args: Namespace) -> int:
    from validation.report.start import write_report

    words = [f"{PROGRAM} report"]
    words += ["--quick"] if args.quick else []
    words += ["--only", args.only] if args.only else []
    output = args.output or (REPORTS / "quick" if args.quick else REPORTS)
    make_folder(output)
    check_writable(output / "index.html")
    print(write_report(output, " ".join(words), args.quick, args.only, args.pages_only, _say_line))
    return PASSED


def _speed(args: Namespace) -> int:
    from validation.report import speed as report
    from validation.study import speed, steps

    if not args.pages_only and not steps.available():
        return _no_step_files()
    return _study(args, "speed", speed.PARTS, report.page)


def _cuda(args: Namespace) -> int:
    from validation.report import cuda as report
    from validation.study import cuda

    return _study(args, "cuda", cuda.PARTS, report.page)


def _stability(args: Namespace) -> int:
    from validation.report import stability as report
    from validation.study import stability

    return _study(args, "stability", stability.PARTS, report.page)


def _study(
    args: Namespace,
    name: str,
    parts: dict[str, Callable[..., None]],
    page: Callable[[Path, Path], Path],
) -> int:
    """Measure the rows of the parts of a study that are missing; write its page."""
    from validation.study.parts import run_parts

    folder = args.output / name
    if not args.pages_only:
        begin_run(folder / "rows", f"{PROGRAM} study {name}", False)
        run_parts(parts, folder / "rows", args.only, _say_line)
    print(page(folder / "rows", folder))
    return PASSED


def _no_step_files() -> int:
    print("validation: no step files in the folder that IZO_DATA names", file=sys.stderr)
    return BAD_INPUT


def _shrink(args: Namespace) -> int:
    from validation.shrink import command

    return command.run(args, _say_line)


def _say_line(line: str) -> None:
    print(line, flush=True)


def _say(fact: "Fact") -> None:
    mark = {True: "passed", False: "FAILED", None: "      "}[fact.passed]
    print(f"{mark}  {fact.question} | {fact.by} | {fact.answer} | {fact.seconds:.2f} s", flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Judge a result, compare solvers with oracles, test the tests, measure.",
        epilog="Exit codes: 0 passed, 1 failed, 2 bad input.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_check(commands)
    help_ = "compare the solvers of zones with oracles: zones.md"
    _add_report(_add(commands, "zones", _zones, help_))
    help_ = "check the result of every step file (IZO_DATA, or else data/scenes): evidence/"
    sub = _add(commands, "evidence", _evidence, help_)
    sub.add_argument("steps", nargs="*", metavar="STEP", help="names of steps; default: all")
    _add_report(sub)
    help_ = "put deliberate faults into copies of the code and run the tests: mutants.md"
    sub = _add(commands, "mutants", _mutants, help_)
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
    sub = _add(commands, "report", _report, help_)
    sub.add_argument("--quick", action="store_true", help="fewer and smaller cases; minutes")
    sub.add_argument("--only", choices=tuple(report.name for report in STUDIES))
    help_ = "reports, or reports/quick; its rows/ has the rows: delete them to measure again"
    sub.add_argument("--pages-only", action="store_true", help=PAGES_ONLY)
    sub.add_argument("-o", "--output", type=Path, metavar="FOLDER", help=help_)
    help_ = "write the figures of all reports into reports/README.md, borders into docs/limits.md"
    sub = _add(commands, "readme", _readme, help_)
    sub.add_argument("--check", action="store_true", help="write nothing; fail if they differ")
    _add(commands, "guide", _guide, "write the tables of the stages into docs/porting-stages.md")
    help_ = "show the floors of the package, by its imports, and the sizes of files and functions"
    sub = _add(commands, "house", _house, help_)
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
    sub = _add(commands, "check", _check, "judge a result of a step, from any program")
    sub.add_argument("step", metavar="STEP.npz")
    help_ = "end positions; default: those of izo_ref.resolve"
    sub.add_argument("--result", metavar="OUT.npz", help=help_)
    sub.add_argument("--thickness", type=float, metavar="D", help="[m], for izo_ref.resolve")
    sub.add_argument("--json", metavar="F", help="write the verdict to a JSON file")
    help_ = "write a page with pictures of what is wrong"
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
    add_flags(_add(commands, "shrink", _shrink, help_))


def _add_studies(commands: "Subparsers") -> None:
    text = "measure speed on the CPU or on a GPU, and write a page"
    sub = commands.add_parser("study", help=text, description=text)
    studies = sub.add_subparsers(required=True, metavar="STUDY")
    help_ = "detection, whole steps, deep contact, the next step, what rules save, size: speed/"
    sub = _add(studies, "speed", _speed, help_)
    parts = ("detection", "resolve", "deep", "next", "ablation", "cold", "scale")
    sub.add_argument("--only", choices=parts)
    _add_report(sub)
    help_ = "what kernels need of a GPU; with a GPU, its results and times next to the CPU: cuda/"
    sub = _add(studies, "cuda", _cuda, help_)
    parts = ("kernels", "detection", "zones", "steps", "launches", "memory")
    sub.add_argument("--only", choices=parts)
    _add_report(sub)
    help_ = "stiff and extreme cases: how far the method holds, and what it says beyond: stability/"
    sub = _add(studies, "stability", _stability, help_)
    sub.add_argument("--only", choices=STABILITY)
    _add_report(sub)


if __name__ == "__main__":
    run_and_exit(main, "validation")

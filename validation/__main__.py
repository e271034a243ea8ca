"""The command `python -m validation`: the evidence."""

import argparse
import sys
from pathlib import Path

from izo_ref.app.files import check_writable, replacing, save_json
from izo_ref.base.errors import IzoError

PASSED, FAILED, BAD_INPUT = 0, 1, 2
REPORTS = Path("reports")


def main(arguments=None) -> int:
    """Run a command; returns 0 passed, 1 failed, 2 bad input."""
    args = _parser().parse_args(arguments)
    try:
        return args.run(args)
    except ModuleNotFoundError as error:
        print(f"validation: {error}; pip install -e .[validation]", file=sys.stderr)
        return BAD_INPUT
    except IzoError as error:
        print(f"validation: {type(error).__name__}: {error}", file=sys.stderr)
        return BAD_INPUT


def _check(args):
    from validation.check import check_files, verdict_summary

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


def _zones(args):
    from validation.report.zones import zones_report
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
    zones_report(args.output / "zones.md", "python -m validation zones", rows)
    print(args.output / "zones.md")
    return PASSED


def _evidence(args):
    from validation.report.evidence import evidence_report
    from validation.study import evidence, steps

    rows = []
    for name in args.steps or steps.step_names():
        print(f"-- {name}", flush=True)
        rows.append(evidence.step_row(name, _say))
    wrong = evidence.wrong_rows(_say)
    evidence_report(args.output / "evidence", "python -m validation evidence", rows, wrong)
    print(args.output / "evidence" / "README.md")
    # a blocked result says itself that it is not free; that has to be what check finds
    passed = all(
        row["verdict"]["passed"] is (row["status"] != "BLOCKED")
        for row in rows
        if "refused" not in row
    )
    missed = any(row["verdict"]["passed"] for row in wrong)
    return PASSED if passed and not missed else FAILED


def _mutants(args):
    from validation.mutants.run import run_mutants
    from validation.report.mutants import mutants_report
    from validation.report.tables import header

    # of what is tested: a run takes a snapshot first, and a quarter of an hour after that
    title = header("Does the suite notice?", "python -m validation mutants")
    try:
        rows = run_mutants(args.faults or None, args.rows)
    except ValueError as error:  # an unknown name
        print(f"validation: {error}", file=sys.stderr)
        return BAD_INPUT
    if args.faults:
        print("some faults only: no report")
    else:
        mutants_report(args.output / "mutants.md", title, rows)
        print(args.output / "mutants.md")
    return PASSED if all(row["caught"] for row in rows) else FAILED


def _house(args):
    from validation import house

    print(house.picture(), house.summary(), sep="\n\n")
    if args.write:
        readme = house.ROOT / "README.md"
        readme.write_text(house.with_picture(readme.read_text()))
    return PASSED


def _report(args):
    from validation.report.start import write_report

    words = ["python -m validation report"]
    words += ["--quick"] if args.quick else []
    words += ["--only", args.only] if args.only else []
    output = args.output or (REPORTS / "quick" if args.quick else REPORTS)
    output.mkdir(parents=True, exist_ok=True)
    check_writable(output / "index.html")

    def say(line):
        print(line, flush=True)

    print(write_report(output, " ".join(words), args.quick, args.only, args.pages_only, say))
    return PASSED


def _speed(args):
    from validation.report.speed import speed_report
    from validation.study import speed, steps

    if not steps.available():
        print("validation: no step files (IZO_DATA)", file=sys.stderr)
        return BAD_INPUT
    return _study(args, "speed", speed.PARTS, speed_report)


def _cuda(args):
    from validation.report.cuda import cuda_report
    from validation.study import cuda

    return _study(args, "cuda", cuda.PARTS, cuda_report)


def _study(args, name, parts, report):
    """Rows of the parts, then the page."""
    from validation.rows import begin_run
    from validation.study.parts import run_parts

    folder, command = args.output / name, f"python -m validation study {name}"
    if not args.pages_only:
        begin_run(folder / "rows", command, False)
        run_parts(parts, folder / "rows", args.only, lambda line: print(line, flush=True))
    report(folder, command)
    print(folder / "README.md")
    return PASSED


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

    text = "solvers of zones against oracles: writes zones.md"
    sub = commands.add_parser("zones", help=text, description=text)
    sub.set_defaults(run=_zones)
    sub.add_argument("-o", "--output", type=Path, default=REPORTS, metavar="FOLDER")

    text = "check every step file (IZO_DATA, or else data/scenes): writes evidence/"
    sub = commands.add_parser("evidence", help=text, description=text)
    sub.set_defaults(run=_evidence)
    sub.add_argument("steps", nargs="*", metavar="STEP", help="names; all if none")
    sub.add_argument("-o", "--output", type=Path, default=REPORTS, metavar="FOLDER")

    text = "deliberate faults, and whether the tests notice: writes mutants.md"
    sub = commands.add_parser("mutants", help=text, description=text)
    sub.set_defaults(run=_mutants)
    sub.add_argument("faults", nargs="*", metavar="FAULT", help="names; all if none")
    sub.add_argument("--rows", type=Path, metavar="F", help="JSON of the rows so far")
    sub.add_argument("-o", "--output", type=Path, default=REPORTS, metavar="FOLDER")

    text = "how fast: measures what is missing, writes a page"
    sub = commands.add_parser("study", help=text, description=text)
    studies = sub.add_subparsers(required=True, metavar="STUDY")
    text = "detection, whole steps, what each rule of the plan saves, cold start, size: speed/"
    sub = studies.add_parser("speed", help=text, description=text)
    sub.set_defaults(run=_speed)
    sub.add_argument("--only", choices=("detection", "resolve", "ablation", "cold", "scale"))
    sub.add_argument("--pages-only", action="store_true", help="measure nothing")
    sub.add_argument("-o", "--output", type=Path, default=REPORTS, metavar="FOLDER")
    text = "what kernels need of a GPU; with one, whether it finds the same, and how fast: cuda/"
    sub = studies.add_parser("cuda", help=text, description=text)
    sub.set_defaults(run=_cuda)
    parts = ("kernels", "detection", "zones", "steps", "launches", "memory")
    sub.add_argument("--only", choices=parts)
    sub.add_argument("--pages-only", action="store_true", help="measure nothing")
    sub.add_argument("-o", "--output", type=Path, default=REPORTS, metavar="FOLDER")

    text = "the floors of the package, from its imports, and the sizes of its files and functions"
    sub = commands.add_parser("house", help=text, description=text)
    sub.set_defaults(run=_house)
    sub.add_argument("--write", action="store_true", help="draw the floors in README.md again")

    text = "error against run time: measures what is missing, writes index.html and its pages"
    sub = commands.add_parser("report", help=text, description=text)
    sub.set_defaults(run=_report)
    sub.add_argument("--quick", action="store_true", help="fewer and smaller cases; minutes")
    sub.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="reports, or reports/quick; rows are in rows/ there, delete them to measure again",
    )
    sub.add_argument("--only", choices=("inner", "outer", "convergence", "scaling"))
    sub.add_argument("--pages-only", action="store_true", help="measure nothing")
    return parser


if __name__ == "__main__":
    sys.exit(main())

"""What the commands of `python -m validation` do; `__main__.py` has their words and options."""

import sys
from argparse import Namespace
from collections.abc import Callable
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
from izo_ref.app.flags import scene_modes
from validation import json_rows
from validation.limits import Limits
from validation.provenance import made_by
from validation.report.catalogue import PROGRAM
from validation.rows import Row, begin_run

if TYPE_CHECKING:
    from validation.judge import Fact

PASSED, FAILED, BAD_INPUT, PASSED_EXCEPT_EXCLUDED = 0, 1, 2, 3
REPORTS = Path("reports")


def run_check(args: Namespace) -> int:
    """Judge a result; the exit code says how."""
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


def run_zones(args: Namespace) -> int:
    """Compare the solvers of zones with oracles."""
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


def run_evidence(args: Namespace) -> int:
    """Check the result of every step file."""
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


def run_mutants(args: Namespace) -> int:
    """Put deliberate faults into copies of the code, and run the tests."""
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


def run_house(args: Namespace) -> int:
    """Show the floors of the package, or write them into the README."""
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


def run_readme(args: Namespace) -> int:
    """Write the figures of all reports, or compare them with the rows."""
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


def run_guide(args: Namespace) -> int:
    """Write the tables of the stages into the guide for porters."""
    from izo_ref.porting.guide import with_tables
    from validation.provenance import ROOT

    guide = ROOT / "docs" / "porting-stages.md"
    save_text(guide, with_tables(guide.read_text()))
    print(guide)
    return PASSED


def run_report(args: Namespace) -> int:
    """Measure error against run time, and write the pages."""
    from validation.report.start import write_report

    words = [f"{PROGRAM} report"]
    words += ["--quick"] if args.quick else []
    words += ["--only", args.only] if args.only else []
    output = args.output or (REPORTS / "quick" if args.quick else REPORTS)
    make_folder(output)
    check_writable(output / "index.html")
    print(write_report(output, " ".join(words), args.quick, args.only, args.pages_only, _say_line))
    return PASSED


def run_speed(args: Namespace) -> int:
    """Measure speed."""
    from validation.report import speed as report
    from validation.study import speed, steps

    if not args.pages_only and not steps.available():
        return _no_step_files()
    return _study(args, "speed", speed.PARTS, report.page)


def run_cuda(args: Namespace) -> int:
    """Measure what kernels need, and what they do on a GPU; it fails if a GPU differs."""
    from validation.report import cuda as report
    from validation.study import cuda

    folder, failed = args.output / "cuda", None
    if not args.pages_only:
        begin_run(folder / "rows", f"{PROGRAM} study cuda", False)
        failed = cuda.run(folder / "rows", args.only, _say_line, cuda.started)
    print(report.page(folder / "rows", folder))
    if failed is not None:
        print(f"validation: study cuda: {failed}", file=sys.stderr)
    return PASSED if failed is None else FAILED


def run_stability(args: Namespace) -> int:
    """Measure how far the method holds."""
    from validation.report import stability as report
    from validation.study import stability

    return _study(args, "stability", stability.PARTS, report.page)


def run_sequences(args: Namespace) -> int:
    """Measure what `izo sequence` and `resolve_sequence` do with animations."""
    from validation.report import sequences as report
    from validation.study import sequences

    return _study(args, "sequences", sequences.PARTS, report.page)


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


def run_shrink(args: Namespace) -> int:
    """Cut a failing step or zone down."""
    from validation.shrink import command

    return command.run(args, _say_line)


def _say_line(line: str) -> None:
    print(line, flush=True)


def _say(fact: "Fact") -> None:
    mark = {True: "passed", False: "FAILED", None: "      "}[fact.passed]
    print(f"{mark}  {fact.question} | {fact.by} | {fact.answer} | {fact.seconds:.2f} s", flush=True)

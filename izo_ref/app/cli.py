"""The command `izo`."""

import argparse
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

from izo_ref.app.cache import TASKS, clear, compile_everything, compiling_beside, fill, folders
from izo_ref.app.conform_command import conform
from izo_ref.app.files import check_outputs, load_result, load_scene, save_json, save_result
from izo_ref.app.flags import scene_modes, with_flags
from izo_ref.app.parser import command_parser
from izo_ref.app.process import run_and_exit
from izo_ref.app.summary import (
    certificate_summary,
    excluded_line,
    impacts_summary,
    n_copies,
    result_summary,
)
from izo_ref.app.vectors_command import list_cases, make_vectors, show_case, verify_vectors
from izo_ref.base.compile import CACHE_FOLDER, anything_compiled, why_not_kept
from izo_ref.base.errors import IzoError
from izo_ref.base.options import Options
from izo_ref.base.records import Status
from izo_ref.certificate.certify import PathCertificate, certify_path
from izo_ref.detection.find import find_impacts
from izo_ref.loop.plan import plan
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene

FREE, NOT_FREE, BAD_INPUT, FREE_EXCEPT_EXCLUDED = 0, 1, 2, 3

Arguments: TypeAlias = argparse.Namespace
Run: TypeAlias = Callable[[Arguments], int]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        arguments: The words behind `izo`; those of the command line if None.

    Returns:
        The exit code: 0 for a free path, 1 for a path that is not free, 2 for bad input, 3 for a
        path that is free except for pairs that were left out.
    """
    options = command_parser().parse_args(arguments)
    try:
        return _RUNS[options.command](options)
    except IzoError as error:
        print(f"izo: {type(error).__name__}: {with_flags(str(error))}", file=sys.stderr)
        return BAD_INPUT


def _load_step(args: Arguments) -> Scene:
    return load_scene(args.step, **scene_modes(args))


def _exit_code(certificate: PathCertificate) -> int:
    if not certificate.free:
        return NOT_FREE
    return FREE if certificate.excluded is None else FREE_EXCEPT_EXCLUDED


def _say_copies(scene: Scene) -> None:
    """Say how many vertices are welded, if that was asked for."""
    if scene.weld is not None:
        n, n_all = n_copies(scene.copies), len(scene.pinned)
        _say(f"{n} of {n_all} vertices are copies, which start and end where their vertices do")


def _resolve(args: Arguments) -> int:
    outputs = {"-o": args.output, "--json": args.json}
    check_outputs({"the step": args.step}, outputs)
    run = resolve if args.trace is None else _tracing(args.trace)
    named = {name: getattr(args, name) for name in ("selection", "relinearize", "max_seconds")}
    options = Options(**named)
    with _progress() as tick:
        with compiling_beside("small-zones"):
            scene = _load_step(args)
        result = run(
            scene,
            args.thickness,
            args.device,
            options,
            on_iteration=lambda row: tick(f"{row.found} impacts, {row.zones} zones"),
        )
    save_result(args.output, result)
    summary = result_summary(result)
    if args.json:
        save_json(args.json, summary)
    _say(
        f"{result.status.name}: {result.status.value}",
        *filter(None, [result.reason]),
        f"objective {result.objective:.6e} m^2 at thickness {result.thickness:g} m",
        f"{len(result.impacts.toi)} impacts in {len(result.zones)} zones, "
        f"{len(result.history)} iterations, {result.timings['total']:.2f} s",
    )
    _say_copies(scene)
    certificate = summary["certificate"]
    if result.status is Status.BLOCKED:
        if result.certificate.finished:
            _say(f"the path is free until t = {result.time_free:.6g}; these pairs meet first:")
            _say_pairs(certificate["meeting"])
        blocked = result.zone_statuses.count(Status.BLOCKED)
        _say(f"{blocked} of {len(result.zones)} zones are blocked; the others are resolved")
    if result.certificate.excluded is not None:
        _say(excluded_line(certificate["excluded"]))
        _say_pairs(certificate["excluded"])
    return _exit_code(result.certificate)


def _tracing(folder: str) -> Callable[..., Result]:
    """Return a `resolve` that writes a trace, after a check of its folder."""
    from izo_ref.porting.trace import trace_resolve
    from izo_ref.porting.trace_files import check_folder

    check_folder(folder)
    return lambda scene, *rest, **more: trace_resolve(scene, folder, *rest, **more)


def _detect(args: Arguments) -> int:
    check_outputs({"the step": args.step}, {"--json": args.json})
    scene = _load_step(args)
    impacts = find_impacts(scene)
    summary = impacts_summary(impacts)
    if args.json:
        save_json(args.json, summary)
    _say(f"{summary['vertex_face']} vertex-face and {summary['edge_edge']} edge-edge impacts")
    _say_copies(scene)
    _say_pairs(summary)
    return NOT_FREE if len(impacts.toi) else FREE


def _certify(args: Arguments) -> int:
    inputs = {"the step": args.step, "--positions": args.positions}
    check_outputs(inputs, {"--json": args.json})
    scene = _load_step(args)
    is_step_itself = args.positions is None
    positions = scene.positions_t1 if is_step_itself else load_result(args.positions).positions
    certificate = certify_path(scene, positions)
    summary = certificate_summary(certificate)
    if args.json:
        save_json(args.json, summary)
    _say(
        f"{'free' if certificate.free else 'not free'}: {certificate.candidates} candidate pairs, "
        f"{len(certificate.meeting_toi)} of them meet; {certificate.exact} were decided in exact "
        f"arithmetic; the path is free until t = {certificate.time_free:.6g}"
    )
    _say_copies(scene)
    _say_pairs(summary["meeting"])
    if certificate.excluded is not None:
        _say(excluded_line(summary["excluded"]))
        _say_pairs(summary["excluded"])
    return _exit_code(certificate)


def _plan(args: Arguments) -> int:
    check_outputs({"the step": args.step}, {"--json": args.json})
    needed = plan(_load_step(args))
    if args.json:
        save_json(args.json, {"plan": [line._asdict() for line in needed.lines]})
    _say(str(needed))
    return FREE


def _show_cache(args: Arguments) -> int:
    for folder in folders():
        kind = "in use" if folder.current else "of other sources or versions"
        _say(f"{folder.path}: {folder.files} files, {folder.bytes / 1e6:.1f} MB, {kind}")
    reason = why_not_kept()
    if reason is not None:
        _say(f"{CACHE_FOLDER}: not used: {reason}")
    elif not anything_compiled():
        _say(f"{CACHE_FOLDER}: nothing is compiled yet; `izo cache fill` compiles what is needed")
    return FREE


def _clear_cache(args: Arguments) -> int:
    for folder in clear(args.old):
        _say(f"{folder.path}: deleted, {folder.bytes / 1e6:.1f} MB")
    return FREE


def _fill_cache(args: Arguments) -> int:
    begin = time.perf_counter()
    fill(args.tasks or TASKS, _say)
    _say(f"{CACHE_FOLDER}: filled in {time.perf_counter() - begin:.1f} s")
    return FREE


def _demo(args: Arguments) -> int:
    from izo_ref.app.demo import write_demo

    with _progress() as tick:
        compile_everything()
        result, page = write_demo(
            args.output, lambda row: tick(f"{row.found} impacts, {row.zones} zones")
        )
    _say(f"{result.status.name}: {result.status.value}", f"page: {page}")
    return _exit_code(result.certificate)


def _sequence(args: Arguments) -> int:
    if len(args.animation) > 1:
        from izo_ref.app.sequence_jobs import sequences

        return sequences(args)
    from izo_ref.app.sequence_command import sequence

    (args.animation,) = args.animation
    return sequence(args)


def _say(*lines: str) -> None:
    for line in lines:
        print(line)


def _say_pairs(summary: dict[str, Any]) -> None:
    for row in summary["first"]:
        text = f"  {row['kind']} {row['nodes']}"
        if "toi" in row:
            text += f" at t = {row['toi']:.6g}"
        if row.get("prescribed"):
            text += ", between pinned points"
        if "reason" in row:
            text += f": {row['reason']}, {row['at_end']} at the end"
        print(text)


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Yield a function that shows one more iteration on a terminal, and nothing in a pipe."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from tqdm import tqdm

    first = "resolving" if anything_compiled() else "compiling, only the first time"
    with tqdm(unit=" iterations", leave=False, desc=first) as bar:

        def tick(text: str) -> None:
            bar.set_description_str("resolving", refresh=False)
            bar.set_postfix_str(text, refresh=False)
            bar.update()

        yield tick


# What each command of the parser runs.
_RUNS: dict[str, Run] = {
    "resolve": _resolve,
    "detect": _detect,
    "plan": _plan,
    "certify": _certify,
    "demo": _demo,
    "sequence": _sequence,
    "conform": conform,
    "cache show": _show_cache,
    "cache clear": _clear_cache,
    "cache fill": _fill_cache,
    "vectors list": list_cases,
    "vectors show": show_case,
    "vectors make": make_vectors,
    "vectors verify": verify_vectors,
}


def entry() -> None:
    """Run the command, and end the process with its exit code."""
    run_and_exit(main)


if __name__ == "__main__":
    entry()

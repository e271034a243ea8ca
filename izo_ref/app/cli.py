"""The command `izo`."""

import argparse
import sys
import time
from contextlib import contextmanager

from izo_ref.app.cache import TASKS, clear, compiling_beside, fill, folders
from izo_ref.app.files import check_writable, load_result, load_scene, save_json, save_result
from izo_ref.app.summary import certificate_summary, impacts_summary, result_summary
from izo_ref.base.compile import CACHE_FOLDER, anything_compiled
from izo_ref.base.errors import IzoError
from izo_ref.base.options import CHOICES, Options
from izo_ref.base.records import Status
from izo_ref.certificate.certify import certify_path
from izo_ref.detection.find import find_impacts
from izo_ref.loop.plan import plan
from izo_ref.loop.resolve import resolve
from izo_ref.version import __version__

FREE, NOT_FREE, BAD_INPUT = 0, 1, 2


def main(arguments=None) -> int:
    """Run the command; returns 0 free, 1 not free, 2 bad input."""
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except IzoError as error:
        print(f"izo: {type(error).__name__}: {error}", file=sys.stderr)
        return BAD_INPUT


def _resolve(args):
    check_writable(args.output)
    if args.json:
        check_writable(args.json)
    with _progress() as tick:
        with compiling_beside():
            scene = load_scene(args.step, args.initial_intersections)
        result = resolve(
            scene,
            args.thickness,
            args.device,
            Options(selection=args.selection, relinearize=args.relinearize),
            on_iteration=lambda row: tick(f"{row.found} impacts, {row.zones} zones"),
        )
    save_result(args.output, result)
    summary = result_summary(result)
    if args.json:
        save_json(args.json, summary)
    _say(
        f"{result.status.name}: {result.status.value}",
        f"objective {result.objective:.6e} m^2 at thickness {result.thickness:g} m",
        f"{len(result.impacts.toi)} impacts in {len(result.zones)} zones, "
        f"{len(result.history)} iterations, {result.timings['total']:.2f} s",
    )
    if result.status is Status.BLOCKED:
        _say(f"free until t = {result.time_free:.6g}")
        _say_pairs(summary["certificate"]["meeting"])
    return FREE if result.certificate.free else NOT_FREE


def _detect(args):
    impacts = find_impacts(load_scene(args.step, args.initial_intersections))
    summary = impacts_summary(impacts)
    if args.json:
        save_json(args.json, summary)
    _say(f"{summary['vertex_face']} vertex-face and {summary['edge_edge']} edge-edge impacts")
    _say_pairs(summary)
    return NOT_FREE if len(impacts.toi) else FREE


def _certify(args):
    scene = load_scene(args.step, args.initial_intersections)
    proposed = args.positions is None
    positions = scene.positions_t1 if proposed else load_result(args.positions).positions
    certificate = certify_path(scene, positions)
    summary = certificate_summary(certificate)
    if args.json:
        save_json(args.json, summary)
    _say(
        f"{'free' if certificate.free else 'not free'}: {certificate.candidates} candidate pairs, "
        f"{len(certificate.meeting_toi)} meet, {certificate.exact} decided in exact arithmetic; "
        f"free until t = {certificate.time_free:.6g}"
    )
    if certificate.excluded is not None:
        _say(f"{len(certificate.excluded.nodes)} pairs left out: they intersect at the start")
    _say_pairs(summary["meeting"])
    return FREE if certificate.free else NOT_FREE


def _plan(args):
    needed = plan(load_scene(args.step, args.initial_intersections))
    if args.json:
        save_json(args.json, {"plan": [line._asdict() for line in needed.lines]})
    _say(str(needed))
    return FREE


def _show_cache(args):
    for folder in folders():
        kind = "in use" if folder.current else "of other sources or versions"
        _say(f"{folder.path}: {folder.files} files, {folder.bytes / 1e6:.1f} MB, {kind}")
    if not anything_compiled():
        _say(f"{CACHE_FOLDER}: nothing compiled yet; izo cache fill")
    return FREE


def _clear_cache(args):
    for folder in clear(args.old):
        _say(f"{folder.path}: deleted, {folder.bytes / 1e6:.1f} MB")
    return FREE


def _fill_cache(args):
    begin = time.perf_counter()
    fill(args.tasks or TASKS, _say)
    _say(f"{CACHE_FOLDER}: filled in {time.perf_counter() - begin:.1f} s")
    return FREE


def _demo(args):
    from izo_ref.app.demo import write_demo

    with _progress() as tick:
        result, page = write_demo(
            args.output, lambda row: tick(f"{row.found} impacts, {row.zones} zones")
        )
    _say(f"{result.status.name}: {result.status.value}", f"page: {page}")
    return FREE if result.certificate.free else NOT_FREE


def _say(*lines):
    for line in lines:
        print(line)


def _say_pairs(summary):
    for row in summary["first"]:
        print(f"  {row['kind']} {row['nodes']} at t = {row['toi']:.6g}")


@contextmanager
def _progress():
    """A function that shows one more iteration, on a terminal; nothing when piped."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from tqdm import tqdm

    first = "resolving" if anything_compiled() else "compiling, the first time only"
    with tqdm(unit=" iterations", leave=False, desc=first) as bar:

        def tick(text):
            bar.set_description_str("resolving", refresh=False)
            bar.set_postfix_str(text, refresh=False)
            bar.update()

        yield tick


def _parser():
    parser = argparse.ArgumentParser(
        prog="izo",
        description="Reference and verification toolkit for impact zone optimization.",
        epilog="Exit codes: 0 free, 1 not free, 2 bad input.",
    )
    parser.add_argument("--version", action="version", version=f"izo {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name, run, text, step=True):
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(run=run)
        if step:
            sub.add_argument("step", metavar="STEP.npz")
            sub.add_argument("--json", metavar="REPORT.json", help="write all but the arrays")
            sub.add_argument(
                "--initial-intersections",
                choices=("raise", "exclude"),
                default="raise",
                help="what to do with pairs that intersect at the start",
            )
        return sub

    sub = command("resolve", _resolve, "find free end positions close to the proposed ones")
    sub.add_argument("-o", "--output", required=True, metavar="OUT.npz")
    sub.add_argument("--thickness", type=float, metavar="D", help="[m], see Options")
    sub.add_argument("--device", default="cpu", choices=("cpu", "cuda", "auto"))
    defaults = Options()
    sub.add_argument("--selection", default=defaults.selection, choices=CHOICES["selection"])
    sub.add_argument("--relinearize", type=int, default=defaults.relinearize, metavar="ROUNDS")
    command("detect", _detect, "list the pairs that meet on the path")
    command("plan", _plan, "say what resolving a step needs, what is left out, and why")
    sub = command("certify", _certify, "prove each pair of a path apart, or that it meets")
    sub.add_argument("--positions", metavar="OUT.npz", help="end positions; the step's own if none")
    sub = command("cache", None, "show, clear or fill the folder of compiled code", step=False)
    actions = sub.add_subparsers(required=True, metavar="ACTION")
    action = actions.add_parser("show", help="where it is, and how much")
    action.set_defaults(run=_show_cache)
    action = actions.add_parser("clear", help="delete it")
    action.add_argument("--old", action="store_true", help="only that of other sources or versions")
    action.set_defaults(run=_clear_cache)
    action = actions.add_parser("fill", help="compile what resolving takes, side by side")
    action.add_argument(
        "tasks", nargs="*", metavar="TASK", help=f"of {', '.join(TASKS)}; all if none"
    )
    action.set_defaults(run=_fill_cache)
    sub = command("demo", _demo, "resolve a scene of our own and write a page", step=False)
    sub.add_argument("-o", "--output", default="reports/demo", metavar="FOLDER")
    return parser


def entry():
    sys.exit(main())


if __name__ == "__main__":
    entry()

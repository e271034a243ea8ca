"""The command `izo view`: a page that shows a step or an animation, before and after."""

from __future__ import annotations

import argparse
import dataclasses
import webbrowser
from collections.abc import Callable
from pathlib import Path

from izo_ref.app.files import check_outputs, load_result, load_scene, save_text
from izo_ref.app.flags import add_scene_flags, scene_modes
from izo_ref.app.view.model import View
from izo_ref.app.view.of_sequence import sequence_view
from izo_ref.app.view.of_step import step_view
from izo_ref.app.view.page import view_page
from izo_ref.base.archives import names_in
from izo_ref.base.errors import FileFormatError, OptionError
from izo_ref.formats.animation import Animation, open_animation

DONE = 0  # exit code
STEP_ARRAY = "positions_t0"  # what an archive of a step has, and that of an animation has not


def add_view(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to those of a parser."""
    text = "write a page that shows a step or an animation in 3D, before and after"
    command = commands.add_parser("view", help=text, description=text)
    command.set_defaults(command="view")
    command.add_argument(
        "proposed",
        metavar="PROPOSED",
        help="step (.npz), or animation: a file, or a folder of OBJ or PLY files",
    )
    command.add_argument(
        "resolved",
        metavar="RESOLVED",
        nargs="?",
        help="what `izo resolve` or `izo sequence` made of it; only PROPOSED is shown without it",
    )
    command.add_argument(
        "-o",
        "--output",
        metavar="PAGE.html",
        help="where to write the page (default: NAME-view.html in this folder)",
    )
    command.add_argument(
        "--obstacle",
        metavar="FILE",
        help="animation or mesh that is shown with both, as for `izo sequence`",
    )
    command.add_argument(
        "--topology",
        metavar="MESH",
        help="for point caches: OBJ or PLY file with their polygons (default: the file beside)",
    )
    command.add_argument(
        "--up",
        choices=("y", "z"),
        help="axis that points up (default: as a USD file says, z in .npz and PLY, else y)",
    )
    command.add_argument(
        "--open", action="store_true", help="open the page in the browser when it is written"
    )
    command.add_argument(
        "--live", action="store_true", help="show it in a window of polyscope and write no page"
    )
    add_scene_flags(command)
    command.set_defaults(initial_intersections="ratchet")


def view(args: argparse.Namespace, tick: Callable[[str], object]) -> int:
    """Run the command.

    Args:
        args: What the parser found.
        tick: Is called with a line for each frame that was read.

    Returns:
        The exit code.
    """
    output = args.output or f"{Path(args.proposed).resolve().stem}-view.html"
    if not args.live:
        inputs = {"PROPOSED": args.proposed, "RESOLVED": args.resolved}
        inputs |= {"--obstacle": args.obstacle, "--topology": args.topology}
        check_outputs(inputs, {"-o": output})
    shown = load_view(args, tick)
    if args.live:
        from izo_ref.app.view.live import show_live

        show_live(shown)
        return DONE
    page = view_page(shown)
    save_text(output, page)
    print(shown.verdict, *shown.notes, f"page: {output}, {len(page) / 1e6:.1f} MB", sep="\n")
    if args.open:
        webbrowser.open(Path(output).resolve().as_uri())
    return DONE


def load_view(args: argparse.Namespace, tick: Callable[[str], object]) -> View:
    """Return the view of the files that the command names.

    Args:
        args: What the parser found.
        tick: Is called with a line for each frame that was read.

    Raises:
        FileFormatError: A file cannot be read, or the two do not fit each other.
        IzoError: The step, the result or the animation is not valid.
    """
    names = [path for path in (args.proposed, args.resolved) if path is not None]
    title = " and ".join(Path(name).name for name in names)
    if _is_step(args.proposed):
        if args.obstacle is not None:
            raise OptionError("--obstacle: expected an animation beside it; a step has no obstacle")
        result = None if args.resolved is None else load_result(args.resolved)
        shown = step_view(title, load_scene(args.proposed, **scene_modes(args)), result)
    else:
        animations = [_animation(name, args.topology) for name in names]
        obstacle = None if args.obstacle is None else _animation(args.obstacle, None)
        shown = sequence_view(title, animations, tick, obstacle)
    return shown if args.up is None else dataclasses.replace(shown, up=args.up)


def _is_step(path: str) -> bool:
    """Return whether a path names a step; raise an error if it names a result alone."""
    if Path(path).suffix.lower() != ".npz" or Path(path).is_dir():
        return False
    names = names_in(path)
    if STEP_ARRAY not in names and "positions" in names and "faces" not in names:
        raise FileFormatError(
            f"{path}: this result has no faces; name the step first: izo view STEP.npz {path}"
        )
    return STEP_ARRAY in names


def _animation(path: str, topology: str | None) -> Animation:
    if Path(path).suffix.lower() == ".npz" and _is_step(path):
        raise FileFormatError(f"{path}: expected an animation, as PROPOSED is; found a step")
    return open_animation(path, topology)

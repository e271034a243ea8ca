"""The command `izo inspect`: say of each frame what crosses, since when, and what to do."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.app.flags import add_animation_flags, add_weld
from izo_ref.app.inspect_report import Worst, inspect_report
from izo_ref.app.inspect_text import report_text
from izo_ref.app.inspected import Inspected
from izo_ref.app.standard_output import (
    STANDARD_OUTPUT,
    check_reports,
    json_text,
    save_report,
    say,
)
from izo_ref.base import checks
from izo_ref.base.compile import anything_compiled
from izo_ref.base.errors import OptionError
from izo_ref.sequence.mesh_faults import find_faults

NOTHING, SOMETHING, PINNED_ALONE = 0, 1, 3  # exit codes
MANY = 1000  # coincident vertices that are said before the work: all their pairs touch
PICTURES = (".png", ".svg")

TEXT = "say of each frame what crosses, since when, in which parts, how deep, and what to do"
EPILOG = (
    "Exit codes: 0 nothing crosses, touches, or passes through on the way between frames; 1 "
    "something does, or the mesh has faces that are refused; 2 bad input; 3 what does has pinned "
    "vertices alone, so that nothing else can prevent it."
)


def add_inspect(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser of `izo`."""
    command = commands.add_parser("inspect", help=TEXT, description=TEXT, epilog=EPILOG)
    command.set_defaults(command="inspect")
    command.add_argument(
        "input",
        metavar="IN",
        help="a step, or an animation or mesh of any format: a file, or a folder of OBJ or PLY "
        "files",
    )
    command.add_argument(
        "--start", type=int, metavar="A", help="first frame that is inspected, from 0"
    )
    command.add_argument("--stop", type=int, metavar="B", help="last frame that is inspected")
    command.add_argument(
        "--obstacle",
        metavar="FILE",
        help="animation or mesh that moves as it is; one frame, or as many as IN",
    )
    add_animation_flags(command)
    command.add_argument(
        "--thickness",
        type=float,
        metavar="D",
        help="the thickness that you mean to resolve with, in the unit of IN: says whether the "
        "floats of the file can hold it",
    )
    add_weld(
        command,
        "treat vertices as one vertex that coincide in the first frame, as exporters write them "
        "along seams; with a number, vertices that are at most so far apart",
    )
    command.add_argument(
        "--json", metavar="REPORT.json", help="write the report as JSON; - is the standard output"
    )
    command.add_argument(
        "--picture",
        metavar="FILE",
        help="draw the frames, and the worst one of them with what crosses in it; .png or .svg",
    )


def inspect(args: argparse.Namespace) -> int:
    """Run the command.

    Args:
        args: What the parser found.

    Returns:
        The exit code.
    """
    _check_picture(args.picture)
    inputs = {"IN": args.input, "--obstacle": args.obstacle, "--topology": args.topology}
    check_reports(inputs, {"--json": args.json, "--picture": args.picture})
    if args.thickness is not None:
        checks.thickness(args.thickness)
    was_compiled = anything_compiled()  # before reading, which compiles a little
    inspected = Inspected(args)
    faults = find_faults(inspected.frame(inspected.first), inspected.faces)
    if args.weld is None and len(faults.coincident) > MANY:
        say(
            f"{len(faults.coincident):,} vertices are at the place of others; if they are one "
            "vertex, as along seams, --weld joins them, and is faster\n",
            aside=True,
        )
    with _Progress(inspected.last - inspected.first + 1, was_compiled) as progress:
        report, worst = inspect_report(inspected, args, faults, progress.tick)
    if args.picture is not None:
        _draw(args.picture, inspected, report, worst)
    if args.json is not None:
        save_report(args.json, json_text(report))
    say(report_text(report), aside=args.json == STANDARD_OUTPUT)
    return _exit_code(report)


def _check_picture(path: str | None) -> None:
    """Raise an error if a picture cannot be drawn, before the work begins."""
    if path is None:
        return
    if Path(path).suffix.lower() not in PICTURES:
        raise OptionError(f"--picture: expected a file {' or '.join(PICTURES)}, found {path}")
    if find_spec("matplotlib") is None:
        raise OptionError(
            "--picture needs matplotlib, which is not installed: pip install 'izo-ref[pictures]'"
        )


def _draw(path: str, inspected: Inspected, report: dict[str, Any], worst: Worst | None) -> None:
    """Draw the report, with the worst frame if something crosses."""
    from izo_ref.app.inspect_picture import draw_report

    positions = np.empty((0, 3)) if worst is None else inspected.frame(worst.number)
    draw_report(path, report, inspected.faces, inspected.part_of, positions, worst)


def _exit_code(report: dict[str, Any]) -> int:
    if report["faults"]["repeated"]["count"]:
        return SOMETHING
    pairs = [pair for frame in report["frames"] for pair in frame["pairs"]]
    if not pairs:
        return NOTHING
    free = any(
        pair["crossings"] + pair["touching"] + pair["passing"] > pair["pinned"] for pair in pairs
    )
    return SOMETHING if free else PINNED_ALONE


class _Progress:
    """Shows on a terminal how many frames are done and how long the others take.

    Args:
        total: Number of frames.
        was_compiled: Whether compiled code was there before the command.
    """

    def __init__(self, total: int, was_compiled: bool) -> None:
        from tqdm import tqdm

        first = "inspecting" if was_compiled else "compiling, only the first time"
        # With `disable=None`, nothing is shown in a pipe.
        self._bar = tqdm(total=total, unit=" frames", leave=False, desc=first, disable=None)

    def __enter__(self) -> _Progress:
        """Return the progress."""
        return self

    def __exit__(self, *_: object) -> None:
        """Take the line off the terminal."""
        self._bar.close()

    def tick(self, frame: dict[str, Any]) -> None:
        """Count a frame."""
        self._bar.set_description_str("inspecting", refresh=False)
        self._bar.set_postfix_str(f"{frame['crossings']} crossings", refresh=False)
        self._bar.update()

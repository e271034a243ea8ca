"""Flags that several commands have, and the messages that name them."""

import argparse
import re
from typing import Any

from izo_ref.scene import INITIAL_INTERSECTIONS, PRESCRIBED


def add_scene_flags(command: argparse.ArgumentParser) -> None:
    """Add the flags that say how a step is taken: those of `scene_modes`."""
    command.add_argument(
        "--initial-intersections",
        choices=INITIAL_INTERSECTIONS,
        default="raise",
        help="stop if pairs touch or cross at the start; or go on (ratchet, exclude): pairs that "
        "touch keep to the side that the mesh tells, and the others are left out; the two differ "
        "in the next step of a sequence only (default: %(default)s)",
    )
    command.add_argument(
        "--prescribed",
        choices=PRESCRIBED,
        default="exclude",
        help="pairs that meet between pinned points are left out and everything else is resolved "
        "(exclude), or they block the step (default: %(default)s)",
    )
    add_weld(
        command,
        "treat vertices as one vertex that coincide at the start and at the end, as exporters "
        "write them along seams; with a number, vertices that are at most so far apart. The result "
        "still has all vertices (default: no vertices are one)",
    )


def add_weld(command: argparse.ArgumentParser, text: str) -> None:
    """Add the flag that joins vertices, with its help."""
    command.add_argument("--weld", nargs="?", type=metres, const=0.0, metavar="METRES", help=text)


def add_animation_flags(command: argparse.ArgumentParser) -> None:
    """Add the flags that say what of an animation is pinned, and where its polygons are."""
    command.add_argument(
        "--pin",
        action="append",
        default=[],
        metavar="NAME",
        help="mesh of IN that moves as it is; may be given several times",
    )
    command.add_argument(
        "--topology",
        metavar="MESH",
        help="for a point cache: OBJ or PLY file with its polygons (default: the file beside it)",
    )


def scene_modes(args: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword arguments of a `Scene` that the flags say."""
    return {name: getattr(args, name) for name in ("initial_intersections", "prescribed", "weld")}


def metres(word: str) -> float:
    """Return the number that a word of the command line is."""
    try:
        return float(word)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected a number of metres or nothing, got {word!r}; put --weld behind the files"
        ) from None


_ARGUMENTS = ("thickness", "device", "selection", "relinearize", "max_seconds", "weld", "pull")


def with_flags(message: str) -> str:
    """Return a message with the flags of the command in place of the arguments of Python."""
    name, colon, rest = message.partition(":")
    if colon and name in _ARGUMENTS:
        message = f"--{name.replace('_', '-')}:{rest}"
    message = message.replace("weld=0", "--weld")
    flags = r"\b(initial_intersections|prescribed)='(\w+)'"
    return re.sub(flags, lambda m: f"--{m[1].replace('_', '-')} {m[2]}", message)

"""The parser of the command `izo`: its commands, their flags, and the help that they print."""

import argparse
from typing import TypeAlias

from izo_ref.app.cache import TASKS
from izo_ref.app.conform_command import add_conform
from izo_ref.app.flags import add_animation_flags, add_scene_flags
from izo_ref.app.inspect_command import add_inspect
from izo_ref.app.vectors_command import stage_name
from izo_ref.app.view_command import add_view
from izo_ref.base.options import CHOICES, Options
from izo_ref.porting.cases import GRADES
from izo_ref.porting.stages import STAGES
from izo_ref.version import __version__

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def command_parser() -> argparse.ArgumentParser:
    """Return the parser of the command `izo`; `command` of what it parses says what to run."""
    parser = argparse.ArgumentParser(
        prog="izo",
        description="Reference and verification toolkit for impact zone optimization.",
        epilog="Exit codes: 0 the path is free, 1 it is not free, 2 bad input, 3 the path is free "
        "except for pairs that were left out (see --initial-intersections and --prescribed).",
    )
    parser.add_argument("--version", action="version", version=f"izo {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_resolve(commands)
    _add_step_command(commands, "detect", "list the pairs that meet on the path")
    text = "say what resolving a step needs, what is left out, and why"
    _add_step_command(commands, "plan", text)
    text = "prove for each pair of a path that it is apart, or that it meets"
    certify = _add_step_command(commands, "certify", text)
    certify.add_argument(
        "--positions",
        metavar="OUT.npz",
        help="result whose end positions are certified; the proposed positions if it is left out",
    )
    add_inspect(commands)
    _add_sequence(commands)
    add_view(commands)
    add_conform(commands)
    _add_cache(commands)
    _add_vectors(commands)
    text = "resolve a scene of our own, and write a page with the result"
    demo = commands.add_parser("demo", help=text, description=text)
    demo.set_defaults(command="demo")
    demo.add_argument(
        "-o",
        "--output",
        default="reports/demo",
        metavar="FOLDER",
        help="folder of the page (default: %(default)s)",
    )
    return parser


def _add_step_command(commands: Commands, name: str, text: str) -> argparse.ArgumentParser:
    """Add a command that reads a step."""
    command = commands.add_parser(name, help=text, description=text)
    command.set_defaults(command=name)
    command.add_argument("step", metavar="STEP.npz", help="the step to read")
    command.add_argument(
        "--json", metavar="REPORT.json", help="write a report of everything except the arrays"
    )
    add_scene_flags(command)
    return command


def _add_resolve(commands: Commands) -> None:
    text = "find free end positions close to the proposed ones"
    command = _add_step_command(commands, "resolve", text)
    defaults = Options()
    command.add_argument(
        "-o", "--output", required=True, metavar="OUT.npz", help="where to write the result"
    )
    command.add_argument(
        "--thickness",
        type=float,
        metavar="D",
        help="distance that impacts keep at the end [m] (default: "
        f"{defaults.thickness_fraction:g} of the median edge length)",
    )
    command.add_argument(
        "--device",
        default="cpu",
        choices=("cpu", "cuda", "auto"),
        help="where the loop runs (default: %(default)s)",
    )
    command.add_argument(
        "--selection",
        default=defaults.selection,
        choices=CHOICES["selection"],
        help="which of the impacts found enter the zones (default: %(default)s)",
    )
    command.add_argument(
        "--relinearize",
        type=int,
        default=defaults.relinearize,
        metavar="ROUNDS",
        help="largest number of rounds that take the normals again at the answer "
        "(default: %(default)s)",
    )
    command.add_argument(
        "--max-seconds",
        type=float,
        metavar="S",
        help="return a certified result after S seconds, even if it is not the best one "
        "(default: no limit)",
    )
    command.add_argument(
        "--trace",
        metavar="FOLDER",
        help="write every intermediate of the run, as .npy files and an index, to a new folder",
    )


def _add_sequence(commands: Commands) -> None:
    text = "resolve an animation frame by frame, and write it in the format in which it was read"
    command = commands.add_parser("sequence", help=text, description=text)
    command.set_defaults(command="sequence")
    command.add_argument(
        "animation",
        nargs="+",
        metavar="IN",
        help="animation to read: a file, or a folder of OBJ or PLY files. Several are resolved "
        "independently, each in a process of its own",
    )
    command.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help="where to write; same suffix as IN. For several, a folder, in which each has the name "
        "that it was read by",
    )
    command.add_argument(
        "--jobs",
        type=_count,
        default=1,
        metavar="N",
        help="how many of several animations are resolved at a time (default: %(default)s)",
    )
    command.add_argument(
        "--progress",
        action="store_true",
        help="write a line for each frame on the standard error: number, impacts so far, time "
        "left; without it, there is a bar if that is a terminal",
    )
    command.add_argument(
        "--thickness",
        type=float,
        metavar="D",
        help="distance that impacts keep at the end of a frame, in the unit of IN (default: "
        f"{Options().thickness_fraction:g} of the median edge length of the first frame)",
    )
    command.add_argument(
        "--start",
        type=int,
        metavar="A",
        help="frame where the sequence starts, from 0; those before are written as they are",
    )
    command.add_argument(
        "--stop", type=int, metavar="B", help="last frame that is resolved and written"
    )
    command.add_argument(
        "--obstacle",
        metavar="FILE",
        help="animation or mesh that moves as it is and is not written; one frame, or as many as "
        "IN",
    )
    add_animation_flags(command)
    command.add_argument(
        "--max-substeps",
        type=int,
        default=16,
        metavar="N",
        help="largest number of steps into which a blocked frame is cut (default: %(default)s)",
    )
    command.add_argument(
        "--pull",
        type=float,
        default=0.0,
        metavar="D",
        help="take what is tangled apart, frame by frame, by at most this distance a frame, in the "
        "unit of IN; about half the length of an edge is usual (default: 0, nothing is pulled)",
    )
    command.add_argument(
        "--device",
        default="cpu",
        choices=("cpu", "cuda", "auto"),
        help="where the loop runs (default: %(default)s)",
    )
    command.add_argument("--json", metavar="REPORT.json", help="write a report of each frame")
    add_scene_flags(command)
    command.set_defaults(initial_intersections="ratchet")


def _count(word: str) -> int:
    """Return the positive number that a word of the command line is."""
    if not word.isdecimal() or int(word) == 0:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 on, got {word!r}")
    return int(word)


def _add_cache(commands: Commands) -> None:
    text = "show, clear or fill the folder of compiled code"
    command = commands.add_parser("cache", help=text, description=text)
    actions = command.add_subparsers(required=True, metavar="ACTION")
    show = actions.add_parser("show", help="show where compiled code is, and how much")
    show.set_defaults(command="cache show")
    remove = actions.add_parser("clear", help="delete compiled code")
    remove.add_argument(
        "--old", action="store_true", help="delete only the code of other sources or versions"
    )
    remove.set_defaults(command="cache clear")
    action = actions.add_parser("fill", help="compile what resolving needs, with several processes")
    action.add_argument(
        "tasks",
        nargs="*",
        metavar="TASK",
        help=f"what to compile: {', '.join(TASKS)}; all of them if none is named",
    )
    action.set_defaults(command="cache fill")


def _add_vectors(commands: Commands) -> None:
    text = "list, show, make or verify the vectors, small cases with known answers for ports"
    command = commands.add_parser("vectors", help=text, description=text)
    actions = command.add_subparsers(required=True, metavar="ACTION")
    listing = _add_vectors_action(actions, "list", "list the cases, one a line")
    stages = [stage.name for stage in STAGES]
    listing.add_argument(
        "--stage",
        type=stage_name,
        choices=stages,
        metavar="STAGE",
        help=f"only those of one stage, {stages[0]} to {stages[-1]}",
    )
    listing.add_argument(
        "--flag", metavar="FLAG", help="only those that catch one mistake, such as zone-transitive"
    )
    listing.add_argument("--grade", choices=GRADES, help="only those of one grade")
    text = "show a case: its mistakes, its arrays, its answer, and where to read"
    show = _add_vectors_action(actions, "show", text)
    show.add_argument("id", metavar="ID", help="the id of the case, as `list` prints it")
    show.add_argument("--all", action="store_true", help="show all rows of long arrays")
    show.add_argument(
        "--picture", metavar="FILE.svg", help="write a picture of the pair, the zone or the mesh"
    )
    text = "make all vectors anew, and write them whole or not at all"
    make = actions.add_parser("make", help=text, description=text)
    make.add_argument("-o", "--output", required=True, metavar="FOLDER", help="where to write them")
    make.set_defaults(command="vectors make")
    text = (
        "compare the vectors with their sums, and with what the generators make; 1 if they differ"
    )
    _add_vectors_action(actions, "verify", text)


def _add_vectors_action(actions: Commands, name: str, text: str) -> argparse.ArgumentParser:
    """Add a command that reads the vectors."""
    action = actions.add_parser(name, help=text, description=text)
    action.set_defaults(command=f"vectors {name}")
    action.add_argument(
        "--folder", metavar="FOLDER", help="a folder of vectors (default: those of izo_ref)"
    )
    return action

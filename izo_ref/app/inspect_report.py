"""The report of `izo inspect` as plain data: what was found in each frame, and what to do next."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from izo_ref.app.inspected import Inspected, Part
from izo_ref.base.arrays import AnyArray, Edges, Faces, Indices, Positions
from izo_ref.base.options import DEFAULTS
from izo_ref.detection.mesh import edges_of, median_length
from izo_ref.sequence.inspect import inspect_sequence
from izo_ref.sequence.inspection import ORDER, Inspection, Verdict
from izo_ref.sequence.mesh_faults import MeshFaults
from izo_ref.version import __version__

NAMED = 5  # crossings of a frame that the report writes out


class Worst(NamedTuple):
    """The frame with the most crossings.

    Attributes:
        number: Number of the frame.
        edges: (n, 2) i4, edges that go through faces.
        faces: (n, 3) i4, these faces.
        contour_of: (n,) i8, the contour that each of them is a point of.
    """

    number: int
    edges: Edges
    faces: Faces
    contour_of: Indices


def inspect_report(
    inspected: Inspected,
    args: argparse.Namespace,
    faults: MeshFaults,
    tick: Callable[[dict[str, Any]], None],
) -> tuple[dict[str, Any], Worst | None]:
    """Inspect all frames.

    Args:
        inspected: What is inspected.
        args: What the parser found.
        faults: The faults of the mesh in the first frame.
        tick: Is called with what is said of each frame.

    Returns:
        The report, and the frame with the most crossings; None if nothing crosses.
    """
    first = inspected.frame(inspected.first)
    faces = np.delete(inspected.faces, faults.repeated, axis=0)
    worst, frames = None, []
    for found in inspect_sequence(
        inspected.frames(),
        faces,
        inspected.pinned,
        inspected.part_of,
        first=inspected.first,
        weld=args.weld,
    ):
        frames.append(_frame_record(found, inspected.parts))
        if found.crossings > (0 if worst is None else len(worst.edges)):
            worst = Worst(found.number, found.edges, found.faces, found.contour_of)
        tick(frames[-1])
    verdict = max((frame["verdict"] for frame in frames), key=_rank)
    report = {
        "izo_ref": __version__,
        "input": str(inspected.path),
        "is_step": inspected.is_step,
        "obstacle": args.obstacle,
        "first": inspected.first,
        "last": inspected.last,
        "verdict": verdict,
        "sentence": Verdict[verdict].value,
        "parts": [part._asdict() for part in inspected.parts],
        "faults": _faults_record(faults, inspected.faces),
        "floats": _floats_record(first, faces, inspected.precision, args.thickness),
        "size": float(np.ptp(first, axis=0).max(initial=0.0)) if len(first) else 0.0,
        "welded": args.weld is not None,
    }
    report["next"] = next_command(inspected, args, frames, report)
    report["frames"] = frames
    return report, worst


def _rank(name: str) -> int:
    return ORDER.index(Verdict[name])


def _frame_record(found: Inspection, parts: tuple[Part, ...]) -> dict[str, Any]:
    """Return what is said of a frame, as JSON."""
    names = ("crossings", "new", "gone", "kept", "touching", "met", "passing", "contours")
    pair_names = ("crossings", "touching", "passing", "pinned", "since", "kept", "depth", "reach")
    rows = zip(found.edges[:NAMED].tolist(), found.faces[:NAMED].tolist(), strict=True)
    return {
        "frame": found.number,
        "verdict": found.verdict.name,
        **{name: getattr(found, name) for name in (*names, "depth", "reach", "width", "move")},
        "pairs": [
            {
                "parts": [parts[part].name for part in pair.parts],
                **{name: getattr(pair, name) for name in pair_names},
                "verdict": pair.verdict.name,
            }
            for pair in found.pairs
        ],
        "first": [{"edge": edge, "face": face} for edge, face in rows],
    }


def _faults_record(faults: MeshFaults, faces: Faces) -> dict[str, Any]:
    """Return how many faults of each kind the mesh has, and the vertices of the first one."""

    def named(rows: AnyArray) -> dict[str, Any]:
        return {"count": len(rows), "first": rows[0].tolist() if len(rows) else None}

    return {
        "repeated": named(faces[faults.repeated]),
        "flat": named(faces[faults.flat]),
        "coincident": named(faults.coincident),
    }


def _floats_record(
    positions: Positions, faces: Faces, precision: str, thickness: float | None
) -> dict[str, Any]:
    """Return the thickness, and how far apart the floats of the file are where it is coarsest."""
    if thickness is None:
        thickness = DEFAULTS.thickness_fraction * median_length(positions, edges_of(faces))
    largest = float(np.abs(positions).max(initial=0.0))
    with np.errstate(over="ignore", invalid="ignore"):
        spacing = float(np.spacing(np.array(largest, precision)))
    return {
        "precision": precision,
        "thickness": thickness,
        "largest": largest,
        "spacing": spacing if np.isfinite(spacing) else None,
    }


def next_command(
    inspected: Inspected,
    args: argparse.Namespace,
    frames: list[dict[str, Any]],
    report: dict[str, Any],
) -> str | None:
    """Return the command to type next; None if there is nothing to resolve, or no command does it.

    Args:
        inspected: What is inspected.
        args: What the parser found.
        frames: What is said of each frame.
        report: The verdict and the faults.
    """
    wrong = report["verdict"] != Verdict.CLEAN.name
    if not wrong or len(frames) == 1 or report["faults"]["repeated"]["count"]:
        return None
    path = inspected.path
    output = path.with_name(f"{path.stem}-resolved{path.suffix}")
    crosses = frames[0]["crossings"] or frames[0]["touching"]
    words = ["izo", "sequence", str(path), "-o", str(output)]
    if inspected.is_step:
        if args.obstacle or args.pin:
            return None
        words[1] = "resolve"
        if crosses:
            words += ["--initial-intersections", "ratchet"]
    else:
        words += _range_words(inspected, args, frames)
        if all(frame["crossings"] for frame in frames):
            words += ["--pull", f"{_half_an_edge(inspected):.2g}"]
        words += [word for name in args.pin for word in ("--pin", name)]
        for name in ("obstacle", "topology"):
            if getattr(args, name) is not None:
                words += [f"--{name}", getattr(args, name)]
    if args.thickness is not None:
        words += ["--thickness", f"{args.thickness!r}"]
    if args.weld is not None:
        words += ["--weld", *([f"{args.weld!r}"] if args.weld else [])]
    return shlex.join(words)


def _half_an_edge(inspected: Inspected) -> float:
    """Return half the median length of the edges in the first frame [m]."""
    return 0.5 * median_length(inspected.frame(inspected.first), edges_of(inspected.faces))


def _range_words(
    inspected: Inspected, args: argparse.Namespace, frames: list[dict[str, Any]]
) -> list[str]:
    """Return the frames to resolve, from the first one without crossings on."""
    clean = [frame["frame"] for frame in frames if not frame["crossings"]]
    start = clean[0] if clean and clean[0] < inspected.last else inspected.first
    words = ["--start", str(start)] if start or args.start is not None else []
    return words + (["--stop", str(inspected.last)] if args.stop is not None else [])

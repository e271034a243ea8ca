"""Traces: every intermediate of a run of `resolve`, written to a folder.

`trace_files.py` has the layout of the folder, and `recorder.py` writes the stages. All arrays are
in the numbering of the caller and in the units of the caller. The rows of `found` are in the order
in which the loop has them, which decides between impacts at equal times.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from izo_ref.base import checks
from izo_ref.base.options import Options
from izo_ref.loop.iterate import Iteration
from izo_ref.loop.resolve import Result, resolve
from izo_ref.porting.recorder import Recorder, columns, zone_of_impact
from izo_ref.porting.trace_files import TraceFolder
from izo_ref.scene import Scene
from izo_ref.version import __version__


def trace_resolve(
    scene: Scene,
    folder: str | os.PathLike[str],
    thickness: float | None = None,
    device: str = "cpu",
    options: Options | None = None,
    *,
    on_iteration: Callable[[Iteration], object] | None = None,
) -> Result:
    """Resolve a step, and write every intermediate of the run to a folder.

    The result has the same bits as that of `resolve` without a trace.

    Args:
        scene: The step to resolve.
        folder: An empty folder, or the name of a new one. Its `index.json` is written last, so a
            folder without one is of a run that did not end.
        thickness: As for `resolve`.
        device: As for `resolve`. The arrays of a GPU are copied to the CPU after each stage.
        options: As for `resolve`.
        on_iteration: As for `resolve`.

    Returns:
        The result.

    Raises:
        FileFormatError: The folder is not empty, or cannot be written.
        IzoError: As for `resolve`.
    """
    checks.scene(scene)
    options = checks.options(options)
    files = TraceFolder(folder)
    recorder = Recorder(scene, files, options.selection)
    result = resolve(
        scene, thickness, device, options, on_iteration=on_iteration, wrap_step=recorder.wrap
    )
    _write_scene(files, scene, result.thickness)
    _write_result(files, result)
    files.finish(
        {
            "izo_ref": __version__,
            "device": device,
            "scene": _modes(scene),
            "options": asdict(options),
            "iterations": recorder.iterations,
            "result": _facts(result),
        }
    )
    return result


def _write_scene(files: TraceFolder, scene: Scene, thickness: float) -> None:
    """Write the arguments of the scene, and what welding made of them."""
    names = ("positions_t0", "positions_t1", "faces", "masses", "pinned")
    own = {name: getattr(scene, name) for name in names}
    welded = {f"welded_{name}": own[name] for name in scene.unwelded}
    if scene.copies is not None:
        welded["copies"] = scene.copies
    files.write("scene", **(own | scene.unwelded), **welded, thickness=thickness)


def _write_result(files: TraceFolder, result: Result) -> None:
    """Write the end positions, the impacts in zones, and the pairs that meet."""
    certificate = result.certificate
    zones = zone_of_impact(result.zones, len(result.impacts.toi))
    files.write(
        "result",
        positions=result.positions,
        free=certificate.free,
        objective=result.objective,
        multipliers=result.multipliers,
        zone_of_impact=zones,
        **columns(result.impacts),
    )
    pairs = certificate.meeting
    own = {"nodes": pairs.nodes, "edge_edge_impacts": pairs.is_edge_edge}
    files.write("result/meeting", **own, toi=certificate.meeting_toi)


def _modes(scene: Scene) -> dict[str, Any]:
    return {name: getattr(scene, name) for name in ("initial_intersections", "prescribed", "weld")}


def _facts(result: Result) -> dict[str, Any]:
    """Return what `index.json` says of a result; its numbers are finite."""
    certificate = result.certificate
    excluded = certificate.excluded
    return {
        "status": result.status.name,
        "status_text": result.status.value,
        "converged": result.converged,
        "feasible": result.feasible,
        "scaled_back": sum(len(part.vertices) for part in result.scaled_back),
        "certificate": {
            "free": certificate.free,
            "time_free": certificate.time_free,
            "candidates": certificate.candidates,
            "meeting": len(certificate.meeting_toi),
            "exact": certificate.exact,
            "excluded": 0 if excluded is None else len(excluded.reasons),
        },
    }

"""Resolve a step: the end positions closest to the proposed ones, on a free path."""

import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.devices import choose_device, implementation
from izo_ref.base.mesh import median_length
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts, Status
from izo_ref.certificate.certify import PathCertificate, certify_path
from izo_ref.detection.detector import Detector
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.iterate import Iteration, Loop
from izo_ref.loop.numbering import geometric_order, impacts_back, renumbered
from izo_ref.loop.plan import Plan, plan
from izo_ref.loop.scale_back import ScaledBack, scale_back
from izo_ref.loop.step import Step
from izo_ref.scene import Scene
from izo_ref.zones.grouping import Zones, build_zones
from izo_ref.zones.objective import objective
from izo_ref.zones.problem import Residuals, residuals
from izo_ref.zones.system import zone_problem


@dataclass(frozen=True, kw_only=True)
class Result:
    """What `resolve` returns. Converged, feasible and free are three separate facts.

    Attributes:
        positions: (n, 3) f8 [m], end of the path; pinned vertices, and all that nothing
            pushes, are at their proposed positions bit for bit.
        positions_on_gpu: the same as an array of the GPU (`__cuda_array_interface__`), where one
            ran the loop; else None.
        status: `Status`.
        objective: [m^2], sum m |x - y|^2 / sum m over the unpinned vertices.
        thickness: [m], the one used.
        converged: every zone is solved to tolerance.
        feasible: every zone satisfies its constraints to tolerance. Neither is claimed of
            a result that was scaled back or is blocked.
        impacts: `Impacts` that entered the zones, by kind and nodes. Times are those at
            which a pair was first met; normals and weights those last used.
        multipliers: (n_impacts,) f8 [kg].
        zones: `Zones` of these impacts.
        residuals: one `Residuals` a zone.
        certificate: `PathCertificate` of the path that is returned.
        scaled_back: list of `ScaledBack`, empty unless the status is FREE_BY_FALLBACK.
        time_free: until when the path is certified free; 1 if it is. A blocked result is
            the path that was free for the longest time, of all that were tried.
        history: list of `Iteration`.
        left_to_processor: zones that a GPU did not solve, so that the processor did, counted
            each time; none of those of the processor alone.
        timings: seconds by stage.
        plan: `Plan`, what was needed of the pipeline.
        options: `Options` used.
    """

    positions: np.ndarray
    positions_on_gpu: Any
    status: Status
    objective: float
    thickness: float
    converged: bool
    feasible: bool
    impacts: Impacts
    multipliers: np.ndarray
    zones: Zones
    residuals: list[Residuals]
    certificate: PathCertificate
    scaled_back: list[ScaledBack]
    time_free: float
    history: list[Iteration]
    left_to_processor: int
    timings: dict[str, float]
    plan: Plan
    options: Options


def resolve(
    scene: Scene,
    thickness: float | None = None,
    device: str = "cpu",
    options: Options | None = None,
    *,
    on_iteration=None,
) -> Result:
    """Find end positions close to the proposed ones whose straight path touches nothing.

    Args:
        scene: `Scene`.
        thickness: [m], distance that impacts keep at the end, positive. None takes
            `options.thickness_fraction` of the median edge length at the start.
        device: `cpu`; `cuda`, where a GPU runs the loop and the filter of the certificate, and
            the processor solves the zones that it leaves, scales back, and judges; `auto`,
            which is `cuda` if there is a GPU and the scene is large enough (`plan`), else `cpu`.
        options: `Options`.
        on_iteration: called with each `Iteration` as it ends.

    Returns:
        `Result`. It is free, or says that it is not.

    Raises:
        ThicknessError, OptionError, DeviceUnavailableError.

    Source: SPEC sections 6 and 7.
    """
    options = options or Options()
    device = choose_device(device, scene)
    make_step = implementation(device, _make_cpu_step, "izo_ref.loop.gpu_step:GpuStep")
    thickness = _thickness(scene, thickness, options)
    times = {"start": time.perf_counter()}

    needed = plan(scene, options)
    times["plan"] = time.perf_counter()
    order = geometric_order(scene)
    sorted_scene = renumbered(scene, order)
    loop = Loop(make_step(sorted_scene, thickness, options), options.max_iterations, on_iteration)
    free = loop.run(0)
    times["main"] = time.perf_counter()
    if free and loop.step.n_active:
        _relinearize(loop, options)
    times["relinearize"] = time.perf_counter()
    looped, scaled_back = loop.step, []
    step = loop.step = looped.to_cpu()
    if not free:
        scaled_back = scale_back(loop)
        detected = step.detect()
        if detected.found or detected.blocked:
            step.positions, scaled_back = step.longest[0], []
    times["scale_back"] = time.perf_counter()

    positions = np.empty_like(scene.positions_t1)
    positions[order] = step.positions
    positions_on_gpu = looped.positions_on_gpu(positions, order if free else None)
    certificate = certify_path(scene, positions, options.rules, device)
    times["certify"] = time.perf_counter()
    scaled_back = [ScaledBack(np.sort(order[s.vertices]), s.scale) for s in scaled_back]

    impacts, index = impacts_back(step.impacts, order, scene.faces)
    multipliers = step.multipliers[index]
    zones = build_zones(scene, impacts)
    judged = [
        _judge(scene, impacts, multipliers, zones, zone, thickness, positions)
        for zone in range(len(zones))
    ]
    times["judge"] = time.perf_counter()
    return Result(
        positions=positions,
        positions_on_gpu=positions_on_gpu,
        objective=objective(scene, positions),
        thickness=thickness,
        **_verdict(certificate, scaled_back, judged, options),
        impacts=impacts,
        multipliers=multipliers,
        zones=zones,
        residuals=judged,
        certificate=certificate,
        scaled_back=scaled_back,
        time_free=certificate.time_free,
        history=loop.history,
        left_to_processor=step.n_left,
        timings=_durations(times),
        plan=needed,
        options=options,
    )


def _verdict(certificate, scaled_back, judged, options):
    """Status, converged and feasible, from what was certified and judged."""
    valid = certificate.free and not scaled_back
    converged = valid and all(
        r.solved(options.gap_tolerance, options.violation_tolerance) for r in judged
    )
    if not certificate.free:
        status = Status.BLOCKED
    else:
        status = Status.FREE if converged else Status.FREE_BY_FALLBACK
    feasible = valid and all(r.feasible(options.violation_tolerance) for r in judged)
    return {"status": status, "converged": converged, "feasible": feasible}


def _relinearize(loop: Loop, options: Options):
    """Take the normals again at the answer, as often as it pays (SPEC section 6)."""
    best = loop.step.objective()
    for number in range(1, options.relinearize + 1):
        saved = loop.step.save()
        loop.step.relinearize()
        if not loop.run(number, limit=best):
            loop.step.restore(saved)
            return
        value = loop.step.objective()
        paid = value <= best * (1.0 - options.relinearize_gain)
        best = value
        if not paid:
            return


def _judge(scene, impacts, multipliers, zones, zone, thickness, positions):
    """Residuals of one zone, from the positions and multipliers that are returned."""
    rows = zones.impacts_of(zone)
    vertices = np.unique(impacts.nodes[rows])
    problem = zone_problem(scene, impacts, zones, zone, thickness)
    return residuals(problem, positions[vertices], multipliers[rows])


def _thickness(scene, thickness, options):
    if thickness is not None:
        return checks.thickness(thickness)
    if len(scene.edges) == 0:
        return 1.0  # no edges, no faces: nothing can meet, any will do
    length = median_length(scene.positions_t0, scene.edges)
    return checks.thickness(options.thickness_fraction * length)


def _make_cpu_step(scene: Scene, thickness: float, options: Options) -> Step:
    start, edges, faces = scene.positions_t0, scene.edges, scene.faces
    detector = Detector(start, edges, faces, scene.excluded, options.rules)
    return CpuStep(scene, thickness, options, detector)


def _durations(times):
    names = list(times)
    durations = {b: times[b] - times[a] for a, b in pairwise(names)}
    durations["total"] = times[names[-1]] - times[names[0]]
    return durations

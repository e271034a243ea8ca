"""Resolve a step: find the end positions closest to the proposed ones on a free path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Flags, GpuArray, Indices, Multipliers, Positions
from izo_ref.base.deadline import Deadline, OutOfTimeError
from izo_ref.base.devices import choose_device, implementation
from izo_ref.base.errors import ThicknessError
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts, SceneArrays, Status, join_impacts
from izo_ref.base.sizes import scene_in_range, thickness_in_range
from izo_ref.certificate.certify import PathCertificate
from izo_ref.detection.detector import Detector
from izo_ref.detection.mesh import median_length
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.ending import certified_ending, start_is_nearer
from izo_ref.loop.iterate import Iteration, Loop
from izo_ref.loop.less_thickness import find_with_less_thickness
from izo_ref.loop.numbering import geometric_order, renumber_scene, restore_numbering
from izo_ref.loop.plan import Plan, plan
from izo_ref.loop.result_back import iterations_back, result_back
from izo_ref.loop.rounds import relinearize
from izo_ref.loop.scale_back import ScaledBack, scale_back
from izo_ref.loop.step import Step
from izo_ref.loop.stopwatch import Stopwatch
from izo_ref.loop.time_plan import TimePlan
from izo_ref.loop.verdict import judge_zones, statuses_of_zones, verdict
from izo_ref.scene import Scene
from izo_ref.zones.grouping import Zones, build_zones
from izo_ref.zones.objective import objective
from izo_ref.zones.problem import Residuals

# `wrap_step` of `resolve`: takes a step, the order of its vertices and the thickness.
WrapStep: TypeAlias = Callable[[Step, Indices, float], Step]


@dataclass(frozen=True, kw_only=True)
class Result:
    """What `resolve` returns.

    Whether the zones converged, whether they are feasible and whether the path is free are three
    separate facts.

    Attributes:
        positions: (n, 3) f8 [m], end of the path. Pinned vertices, and vertices that nothing
            pushes, are exactly at their proposed positions, bit for bit.
        positions_on_gpu: The same positions as an array of the GPU (`__cuda_array_interface__`) if
            a GPU ran the loop; else None.
        status: How the step ended; its value is a sentence for the user.
        reason: What the time limit ended, and what is returned instead, as sentences for the user;
            empty if it ended nothing. It is always empty without `Options(max_seconds=...)`.
        objective: sum m |x - y|^2 / sum m over the unpinned vertices [m^2].
        thickness: The thickness that was used [m].
        converged: Whether every zone is solved to tolerance. False if the result was scaled back
            or is blocked.
        feasible: Whether every zone satisfies its constraints to tolerance. False if the result
            was scaled back or is blocked.
        impacts: The impacts that entered the zones, sorted by kind and nodes. Each time of impact
            is the one at which the pair was first met; normals and weights are those that were
            used last.
        multipliers: (n_impacts,) f8 [kg], one for each impact.
        zones: The zones of these impacts.
        residuals: The residuals of each zone.
        zone_statuses: How each zone ended: FREE, FREE_BY_FALLBACK or BLOCKED.
        certificate: Certificate of the path that is returned.
        scaled_back: Vertices that were scaled back toward the start, and how far.
        time_free: Time until which the path is certified free, except for excluded pairs; 1 if the
            whole path is. A vertex that is blocked ends where it was on the path that was free for
            the longest time, of all that were tried; everything else is resolved.
        history: One record for each iteration.
        left_to_cpu: Number of zones that a GPU did not solve and left to the CPU. A zone counts
            each time it is left. 0 if the loop ran on the CPU.
        timings: Seconds that each stage took, and `total` [s].
        options: The options that were used.
    """

    positions: Positions
    positions_on_gpu: GpuArray
    status: Status
    reason: str
    objective: float
    thickness: float
    converged: bool
    feasible: bool
    impacts: Impacts
    multipliers: Multipliers
    zones: Zones
    residuals: list[Residuals]
    zone_statuses: list[Status]
    certificate: PathCertificate
    scaled_back: list[ScaledBack]
    time_free: float
    history: list[Iteration]
    left_to_cpu: int
    timings: dict[str, float]
    options: Options

    @cached_property
    def plan(self) -> Plan:
        """What the step needed of the pipeline, and why."""
        return plan(self.certificate.scene, self.options)


def resolve(
    scene: Scene,
    thickness: float | None = None,
    device: str = "cpu",
    options: Options | None = None,
    *,
    on_iteration: Callable[[Iteration], object] | None = None,
    wrap_step: Callable[..., Any] | None = None,
) -> Result:
    """Find end positions close to the proposed ones whose straight path touches nothing.

    Args:
        scene: The step to resolve.
        thickness: Distance that impacts keep at the end [m], positive. None takes
            `options.thickness_fraction` of the median edge length at the start.
        device: `cpu`, `cuda` or `auto`. With `cuda`, a GPU runs the loop and the filter of the
            certificate; the CPU solves the zones that the GPU leaves to it, scales zones back,
            and judges the result. `auto` is `cuda` if there is a GPU and the scene is large
            enough (see `plan`), else `cpu`.
        options: Choices and tolerances; the defaults if None.
        on_iteration: Function that is called with the record of each iteration as it ends.
        wrap_step: Function that takes the step of the loop, its order of the vertices (`order[i]`
            is the caller's vertex at place i) and its thickness, and returns the step to run in
            its place. It is for recorders of the loop, such as `porting/trace.py`.

    Returns:
        The result. Its path is certified free, or its status says that it is not. If
        `options.max_seconds` ended the run early, `reason` says what was ended.

    Raises:
        ThicknessError: The thickness is not a positive, finite number, or it is too large or too
            small beside the coordinates.
        SizeError: A coordinate is too large or too small to compute with, in the scene or in the
            answer.
        OptionError: `device` is not offered, or an argument is of another type.
        DeviceUnavailableError: `device` is `cuda`, and no GPU can be used.
        DeviceMemoryError: The GPU has less free memory than the step needs.

    Source: docs/method sections 6 and 7.
    """
    checks.scene(scene)
    options = checks.options(options)
    checks.function("on_iteration", on_iteration)
    checks.function("wrap_step", wrap_step)
    device = choose_device(device, scene)
    deadline = Deadline(options.max_seconds)
    twin, units = scene_in_range(scene)
    if thickness is not None:
        thickness = thickness_in_range(checks.thickness(thickness), twin, units)
    times, more = TimePlan(deadline, 1 if twin is scene else 2), (options, on_iteration, wrap_step)
    try:
        if twin is scene:
            return _resolve_in_range(scene, thickness, device, *more, times)
        more = options, iterations_back(on_iteration, units), wrap_step
        result = _resolve_in_range(twin, thickness, device, *more, times)
        return result_back(result, scene, twin, units, device, times)
    finally:
        times.end()


def _resolve_in_range(
    scene: Scene,
    thickness: float | None,
    device: str,
    options: Options,
    on_iteration: Callable[[Iteration], object] | None,
    wrap_step: WrapStep | None,
    times: TimePlan,
) -> Result:
    """Resolve a scene of ordinary size (`base/units.py`)."""
    make_step = implementation(device, _make_cpu_step, "izo_ref.loop.gpu_step:GpuStep")
    thickness = choose_thickness(scene, thickness, options)
    watch = Stopwatch()
    order = geometric_order(scene)
    step = make_step(renumber_scene(scene, order), thickness, options, times.deadline)
    if wrap_step is not None:
        step = wrap_step(step, order, thickness)
    loop = Loop(step, options.max_iterations, on_iteration, times)
    free = _run_main(loop)
    watch.lap("main")
    if free and step.n_active:
        relinearize(loop, options)
    watch.lap("relinearize")
    loop.step = step.to_cpu()
    scaled_back = [] if free else _scale_back_in_time(loop, order, thickness, options)
    watch.lap("scale_back")

    positions = np.empty_like(scene.positions_t1)
    positions[order] = loop.step.positions
    if scene.copies is not None:
        positions = positions[scene.copies]
    whole = free and scene.copies is None  # the positions of the step are all positions
    path = scene, positions, scaled_back, options.rules, device, times
    positions, certificate, scaled_back = certified_ending(*path)
    whole = whole and not times.stays
    positions_on_gpu = step.positions_on_gpu(positions, order if whole else None)
    times.end()
    watch.lap("certify")
    impacts, index = restore_numbering(loop.step.impacts, order, scene.faces)
    multipliers = loop.step.multipliers[index]
    zones = build_zones(scene, impacts)
    judged = judge_zones(scene, impacts, multipliers, zones, thickness, positions)
    watch.lap("judge")
    facts = certificate, scaled_back, judged, options
    status, converged, feasible = verdict(*facts, times.reason)
    return Result(
        positions=positions,
        positions_on_gpu=positions_on_gpu,
        status=status,
        reason=times.reason,
        objective=objective(scene, positions),
        thickness=thickness,
        converged=converged,
        feasible=feasible,
        impacts=impacts,
        multipliers=multipliers,
        zones=zones,
        residuals=judged,
        zone_statuses=statuses_of_zones(zones, *facts),
        certificate=certificate,
        scaled_back=scaled_back,
        time_free=certificate.time_free,
        history=loop.history,
        left_to_cpu=loop.step.n_left,
        timings=watch.timings(),
        options=options,
    )


def choose_thickness(scene: SceneArrays, thickness: float | None, options: Options) -> float:
    """Return the thickness [m]: the one that is passed, or the default of the options."""
    if thickness is not None:
        return thickness
    if len(scene.edges) == 0:
        return 1.0  # without edges and faces nothing can meet, so any thickness will do
    chosen = options.thickness_fraction * median_length(scene.positions_t0, scene.edges)
    if not 0.0 < chosen < np.inf:
        raise ThicknessError(
            f"thickness: the default is {options.thickness_fraction:g} of the median edge length "
            f"at the start, which is {chosen:g} m here; pass a thickness [m]"
        )
    return chosen


def _make_cpu_step(
    scene: SceneArrays, thickness: float, options: Options, deadline: Deadline
) -> Step:
    detector = Detector.of_scene(scene, options.rules, deadline)
    return CpuStep(scene, thickness, options, detector, deadline)


def _run_main(loop: Loop) -> bool:
    """Run the main loop; return whether the path is free."""
    loop.times.begin_first_detection()
    try:
        return loop.run(0)
    except OutOfTimeError:
        loop.times.note("The fail-safe took over.")
        return False


def _scale_back_in_time(
    loop: Loop, order: Indices, thickness: float, options: Options
) -> list[ScaledBack]:
    """Scale zones back, unless that takes too long or everything unpinned had better stay put."""
    times, step = loop.times, loop.step
    times.begin_scaling_back()
    try:
        scaled_back = _scale_back(loop, order, thickness, options)
    except OutOfTimeError:
        times.stay()
        return []
    if times.reason and start_is_nearer(step.scene, step.positions):
        times.stays = True
    return scaled_back


def _scale_back(loop: Loop, order: Indices, thickness: float, options: Options) -> list[ScaledBack]:
    """Scale zones back until the path is free, or as far as it can be.

    A group that stays at the start and still meets pinned vertices gets less than the thickness.
    If it does not fit either, then no positions were found for it. Its vertices end where they
    were on the path that was free for the longest time, of all that were tried. Everything else
    keeps its positions.

    Args:
        loop: The loop, whose step is on the CPU.
        order: (n_vertices,) i8, the caller's vertex at each place.
        thickness: Distance that impacts keep at the end [m].
        options: Choices and tolerances.

    Returns:
        What was scaled back, in the caller's numbering.
    """
    step, blocks = loop.step, loop.step.scene.prescribed == "block"
    scaled_back = scale_back(loop)
    detected = step.detect()
    if detected.blocked and blocks:
        step.positions = step.longest[0]
        return []
    if detected.found:
        blocked = np.zeros(len(order), bool)
        groups = build_zones(step.scene, join_impacts((step.impacts, step.found)))
        for group in range(len(groups)):
            vertices = groups.vertices_of(group)
            blocked[vertices] = np.isin(vertices, step.found.nodes).any()
        ends = _with_less_thickness(loop, blocked, thickness, options)
        if ends is None:
            ends = np.where(blocked[:, None], step.longest[0], step.positions)
        step.positions = ends
        scaled_back = [s._replace(vertices=s.vertices[~blocked[s.vertices]]) for s in scaled_back]
    return [ScaledBack(np.sort(order[s.vertices]), s.scale) for s in scaled_back if len(s.vertices)]


def _with_less_thickness(
    loop: Loop, blocked: Flags, thickness: float, options: Options
) -> Positions | None:
    """Return ends with less than the thickness, or None if there are none, or no time is left."""
    times = loop.times
    try:
        return find_with_less_thickness(loop.step, blocked, thickness, options, times.deadline)
    except OutOfTimeError:
        times.note("What has too little room for the thickness was not resolved again with less.")
        return None

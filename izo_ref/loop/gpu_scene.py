"""A scene that stays on a GPU from step to step; `keep_on_gpu.py` is its door.

A step sends the proposed positions to the GPU, or takes them where they are, and leaves the end
positions there. It begins where the last one ended, or at other positions, which the GPU checks.
The mesh, its trees and all buffers are made once. Nothing that grows with the scene is copied to
the CPU, unless a step needs the CPU.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import GpuArray, Positions
from izo_ref.base.deadline import UNLIMITED, Deadline, OutOfTimeError
from izo_ref.base.devices import detach, is_on_gpu, require_gpu
from izo_ref.base.errors import OptionError, ShapeError, UncertifiedStartError
from izo_ref.base.gpu_arrays import full, to_cpu, to_gpu
from izo_ref.base.gpu_interop import own_array
from izo_ref.base.options import Options
from izo_ref.base.records import Status
from izo_ref.base.sizes import scene_in_range, thickness_in_range
from izo_ref.detection.gpu_start import StartCheck
from izo_ref.detection.trees import box_frame
from izo_ref.loop.cuda import step as kernels
from izo_ref.loop.gpu_step import GpuStep
from izo_ref.loop.iterate import Loop
from izo_ref.loop.numbering import geometric_order, renumber_scene
from izo_ref.loop.resolve import choose_thickness, resolve
from izo_ref.loop.rounds import relinearize
from izo_ref.loop.simulation import GpuResult, GpuScene
from izo_ref.loop.time_plan import TimePlan
from izo_ref.scene import Scene

# After this many steps the vertices are numbered and the trees are sorted anew, because the mesh
# has moved. `Scene.after` does the same for the CPU.
KEPT_STEPS = 32
# Largest proposed position, along an axis, in the coordinates of boxes. The start reaches to 1 at
# most in them, so float32 positions lose no more than two of their 24 bits.
FAR = 4.0
FAILED = "the last step of this GpuScene ended with an error"  # a reason why no step can follow


class ResidentScene(GpuScene):
    """A scene that stays on a GPU; `keep_on_gpu` makes it.

    Args:
        scene: The first step.
        thickness: Distance that impacts keep at the end [m]; None as for `resolve`.
        options: Choices and tolerances; the defaults if None.
    """

    def __init__(
        self, scene: Scene, thickness: float | None = None, options: Options | None = None
    ) -> None:
        """Copy the scene to the GPU, and make all buffers."""
        checks.scene(scene)
        self._options = checks.options(options)
        require_gpu()
        _require_plain(scene)
        if thickness is not None:
            own = checks.thickness(thickness), *scene_in_range(scene)
            thickness = thickness_in_range(*own)
        self.thickness = choose_thickness(scene, thickness, self._options)
        self._stopped = ""  # why no step can follow
        self._make(scene, UNLIMITED)

    def _make(self, scene: Scene, deadline: Deadline) -> None:
        """Make the step and its buffers for a scene."""
        for name in ("_step", "_start_check"):
            self.__dict__.pop(name, None)  # the driver can have its memory first
        order = geometric_order(scene)
        own = renumber_scene(scene, order), self.thickness, self._options, deadline
        origin, scale = box_frame(scene.positions_t0, scene.edges)
        self._scene, self._order, self._n_steps = scene, to_gpu(order), 0
        self._centre, self._radius = to_gpu(origin), FAR / scale
        self._step = GpuStep(*own)
        self._start_check = StartCheck(self._step.detector)

    def resolve(self, positions_t1: Any, positions_t0: Any = None) -> GpuResult:
        """Resolve the next step; `GpuScene.resolve` has the contract."""
        if self._stopped and positions_t0 is None:
            raise UncertifiedStartError(
                f"{self._stopped}; pass positions_t0, or make a new GpuScene from a Scene: both "
                "check the start in full"
            )
        deadline = Deadline(self._options.max_seconds)
        if self._stopped == FAILED:
            self._make(self._scene, deadline)  # an error may have left buffers half made
        scene = self._next_on_cpu(positions_t1, positions_t0)
        self._stopped = FAILED  # what stops in the middle leaves no free start
        if scene is not None:
            self._make(scene, deadline)
        elif positions_t0 is not None:
            self._step.go_on(self._start_check.start, deadline)
        elif self._n_steps:
            self._step.go_on(self._step.positions, deadline)
        else:
            self._step.begin_again(deadline)
        self._n_steps += 1
        result, self._stopped = self._resolved(deadline)
        return result

    def _next_on_cpu(self, positions_t1: Any, positions_t0: Any) -> Scene | None:
        """Take the positions of the next step, and check where it begins.

        Nothing keeps the arrays of this step in use afterwards, so that others can be made.

        Returns:
            The next step on the CPU, if the buffers have to be made anew for it; else None.
        """
        step, check, has_start = self._step, self._start_check, positions_t0 is not None
        to_take = {"positions_t1": (positions_t1, step.proposed)}
        if has_start:
            to_take["positions_t0"] = positions_t0, check.start
        far = self._take(to_take)
        if has_start and ("positions_t0" in far or not check.is_free()):
            return self._checked_on_cpu()
        if not far and self._n_steps < KEPT_STEPS:
            return None
        return self._on_cpu(check.start if has_start else step.positions if self._n_steps else None)

    def _take(self, to_take: dict[str, tuple[Any, GpuArray]]) -> set[str]:
        """Copy positions; return the names of those of which some are far outside, or no numbers.

        Args:
            to_take: `{name: (positions, array)}`, positions of the caller, and where they go.
        """
        n_outside = full(len(to_take), 0, np.int64)
        for i, (name, (positions, positions_out)) in enumerate(to_take.items()):
            own = self._rows(name, detach(positions)), self._order, self._centre, self._radius
            out = positions_out, n_outside[i : i + 1]
            kernels.take_positions[len(self._scene.pinned)](*own, *out)
        return {name for name, n in zip(to_take, to_cpu(n_outside), strict=True) if n}

    def _rows(self, name: str, positions: Any) -> GpuArray:
        """Return positions of the caller on the GPU, in the numbering of the caller."""
        shape = len(self._scene.pinned), 3
        if not is_on_gpu(positions):
            return to_gpu(checks.floats(name, positions, shape))
        rows = own_array(positions)
        if rows.shape != shape or rows.dtype != np.float64:
            raise ShapeError(
                f"{name}: expected float64 of shape {shape}, got {rows.dtype} of shape {rows.shape}"
            )
        return rows

    def _checked_on_cpu(self) -> Scene:
        """Return the step as a new scene on the CPU, whose start, a new one, is checked in full."""
        own = self._scene
        start, proposed = (
            self._in_order_of_caller(to_cpu(positions))
            for positions in (self._start_check.start, self._step.proposed)
        )
        scene = Scene(
            start,
            proposed,
            own.faces,
            own.masses,
            own.pinned,
            initial_intersections=own.initial_intersections,
            prescribed=own.prescribed,
            weld=own.weld,
        )
        _require_plain(scene, "positions_t0")
        return scene

    def _on_cpu(self, start: GpuArray | None) -> Scene:
        """Return the step as a scene on the CPU; its start was checked on the GPU, or before."""
        scene = copy.copy(self._scene)
        if start is not None:
            scene.positions_t0 = self._in_order_of_caller(to_cpu(start))
        proposed = self._in_order_of_caller(to_cpu(self._step.proposed))
        scene.positions_t1 = checks.floats("positions_t1", proposed, proposed.shape)
        scene.on_gpu = {}
        _require_plain(scene)
        return scene

    def _in_order_of_caller(self, positions: Positions) -> Positions:
        """Return positions of the step in the numbering of the caller."""
        result = np.empty_like(positions)
        result[to_cpu(self._order)] = positions
        return result

    def _resolved(self, deadline: Deadline) -> tuple[GpuResult, str]:
        """Run the loop; if it finds no free path, let `resolve` do the step.

        Returns:
            How the step ended, and why no step can follow; empty if one can.
        """
        step, options = self._step, self._options
        loop = Loop(step, options.max_iterations, None, TimePlan(deadline))
        loop.times.begin_first_detection()
        try:
            # impacts between pinned points are no failure of the loop, but no free path either
            free = loop.run(0) and step.n_blocked == 0 and not step.has_failed
            if free and step.n_active:
                relinearize(loop, options)
        except OutOfTimeError:
            free = False
        finally:
            loop.times.end()
        return (self._ended(loop), "") if free else self._ended_by_resolve()

    def _ended(self, loop: Loop) -> GpuResult:
        """Return how a free step ended."""
        step = self._step
        return GpuResult(
            positions=step.positions_back(self._order),
            status=Status.FREE,
            objective=step.objective(),
            n_impacts=step.n_impacts,
            history=loop.history,
            left_to_cpu=step.n_left,
            full=None,
        )

    def _ended_by_resolve(self) -> tuple[GpuResult, str]:
        """Resolve the step with the fail-safe, and go on from its end; return as `_resolved`."""
        own = self._step.current_scene()
        scene = copy.copy(self._scene)
        scene.positions_t0, scene.positions_t1 = (
            self._in_order_of_caller(positions)
            for positions in (own.positions_t0, own.positions_t1)
        )
        scene.on_gpu = {}
        result = resolve(scene, self.thickness, "cuda", self._options)
        stopped = "the last step of this GpuScene was blocked, so its end is no free start"
        if result.certificate.free:
            following = scene.after(result, result.positions)
            reason = _why_not_plain(following)
            stopped = f"the next step of this GpuScene begins with {reason}" if reason else ""
            if not stopped:
                self._make(following, UNLIMITED)
        ended = GpuResult(
            positions=result.positions_on_gpu,
            status=result.status,
            objective=result.objective,
            n_impacts=len(result.impacts.toi),
            history=result.history,
            left_to_cpu=result.left_to_cpu,
            full=result,
        )
        return ended, stopped


def _why_not_plain(scene: Scene) -> str:
    """Return what a scene has that a scene on a GPU cannot have; empty if it has nothing of it."""
    reasons = {
        "pairs that are left out": scene.excluded is not None,
        "pairs that touch at the start": scene.touching is not None,
        "welded vertices": scene.copies is not None,
        "an extraordinary size or masses": scene_in_range(scene)[0] is not scene,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def _require_plain(scene: Scene, name: str = "scene") -> None:
    """Raise an error that begins with a name if a scene is not of the kind that stays on a GPU."""
    reason = _why_not_plain(scene)
    if reason:
        raise OptionError(
            f"{name}: a GpuScene takes none with {reason}; resolve it step by step: "
            'resolve(scene, device="cuda"), then scene.after(result, positions_t1)'
        )

"""A scene that stays on a GPU from step to step; `keep_on_gpu.py` is its door.

A step sends the proposed positions to the GPU, or takes them where they are, and leaves the end
positions there. The mesh, its trees and all buffers are made once. Nothing that grows with the
scene is copied to the CPU, unless a step needs the CPU.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import GpuArray, Positions
from izo_ref.base.deadline import Deadline, OutOfTimeError
from izo_ref.base.devices import detach, is_on_gpu, require_gpu
from izo_ref.base.errors import OptionError, ShapeError, UncertifiedStartError
from izo_ref.base.gpu_arrays import empty, full, to_cpu, to_gpu
from izo_ref.base.gpu_interop import own_array, shared_array
from izo_ref.base.options import Options
from izo_ref.base.records import Status
from izo_ref.base.sizes import scene_in_range, thickness_in_range
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
# Positions may be this many times farther from the centre of the start than the mesh is wide. The
# coordinates of boxes then keep 22 of 24 bits.
FAR = 4.0


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
        twin, units = scene_in_range(scene)
        if thickness is not None:
            thickness = thickness_in_range(checks.thickness(thickness), twin, units)
        _require_plain(scene, twin)
        self.thickness = choose_thickness(scene, thickness, self._options)
        self._can_go_on = True
        self._make(scene)

    def _make(self, scene: Scene) -> None:
        """Make the step and its buffers for a scene."""
        order = geometric_order(scene)
        self._scene, self._order, self._n_steps = scene, to_gpu(order), 0
        self._step = GpuStep(renumber_scene(scene, order), self.thickness, self._options)
        origin, scale = box_frame(scene.positions_t0, scene.edges)
        self._centre, self._radius = to_gpu(origin), FAR / scale

    def resolve(self, positions_t1: Any) -> GpuResult:
        """Resolve the next step; `GpuScene.resolve` has the contract."""
        if not self._can_go_on:
            raise UncertifiedStartError(
                "the last step of this GpuScene was blocked, so its end is no free start; make a "
                "new GpuScene from a Scene, which checks its start in full"
            )
        positions_t1 = detach(positions_t1)
        start = self._step.positions if self._n_steps else None
        deadline = Deadline(self._options.max_seconds)
        if self._take(positions_t1) or self._n_steps >= KEPT_STEPS:
            self._make(self._on_cpu(start, positions_t1))
        elif start is not None:
            self._step.go_on(deadline)
        else:
            self._step.begin_again(deadline)
        self._n_steps += 1
        return self._resolved(deadline)

    def _take(self, positions_t1: Any) -> bool:
        """Copy proposed positions; return whether some are far outside, or are no numbers."""
        n = len(self._scene.pinned)
        if is_on_gpu(positions_t1):
            rows = own_array(positions_t1)
            if rows.shape != (n, 3) or rows.dtype != np.float64:
                raise ShapeError(
                    f"positions_t1: expected float64 of shape {(n, 3)}, got {rows.dtype} of shape "
                    f"{rows.shape}"
                )
        else:
            rows = to_gpu(checks.floats("positions_t1", positions_t1, (n, 3)))
        outside = full(1, 0, np.int64)
        own = rows, self._order, self._centre, self._radius
        kernels.take_proposed[n](*own, self._step.proposed, outside)
        return bool(to_cpu(outside)[0])

    def _on_cpu(self, start: GpuArray | None, positions_t1: Any) -> Scene:
        """Return the step as a scene on the CPU; its start is not checked again."""
        scene = copy.copy(self._scene)
        if start is not None:
            scene.positions_t0 = self._in_order_of_caller(to_cpu(start))
        if is_on_gpu(positions_t1):
            positions_t1 = to_cpu(own_array(positions_t1))
        n = len(scene.pinned)
        scene.positions_t1 = checks.floats("positions_t1", positions_t1, (n, 3))
        scene.on_gpu = {}
        twin, _ = scene_in_range(scene)
        _require_plain(scene, twin)
        return scene

    def _in_order_of_caller(self, positions: Positions) -> Positions:
        """Return positions of the step in the numbering of the caller."""
        result = np.empty_like(positions)
        result[to_cpu(self._order)] = positions
        return result

    def _resolved(self, deadline: Deadline) -> GpuResult:
        """Run the loop; if it finds no free path, let `resolve` do the step."""
        step, options = self._step, self._options
        loop = Loop(step, options.max_iterations, None, TimePlan(deadline))
        loop.times.begin_first_detection()
        try:
            free = loop.run(0) and not step.has_failed
        except OutOfTimeError:
            free = False
        if free and step.n_active:
            relinearize(loop, options)
        loop.times.end()
        return self._ended(loop) if free else self._ended_by_resolve()

    def _ended(self, loop: Loop) -> GpuResult:
        """Return how a free step ended."""
        step, n = self._step, len(self._scene.pinned)
        positions = empty((n, 3), np.float64)
        kernels.put_rows[n](self._order, step.positions, positions)
        return GpuResult(
            positions=shared_array(positions),
            status=Status.FREE,
            objective=step.objective(),
            n_impacts=step.n_impacts,
            history=loop.history,
            left_to_cpu=step.n_left,
            full=None,
        )

    def _ended_by_resolve(self) -> GpuResult:
        """Resolve the step with the fail-safe, and go on from its end."""
        own = self._step.current_scene()
        scene = copy.copy(self._scene)
        scene.positions_t0, scene.positions_t1 = (
            self._in_order_of_caller(positions)
            for positions in (own.positions_t0, own.positions_t1)
        )
        scene.on_gpu = {}
        result = resolve(scene, self.thickness, "cuda", self._options)
        self._can_go_on = result.certificate.free
        if self._can_go_on:
            self._make(scene.after(result, result.positions))
        return GpuResult(
            positions=result.positions_on_gpu,
            status=result.status,
            objective=result.objective,
            n_impacts=len(result.impacts.toi),
            history=result.history,
            left_to_cpu=result.left_to_cpu,
            full=result,
        )


def _require_plain(scene: Scene, twin: Scene) -> None:
    """Raise an error if a scene is not of the kind that stays on a GPU."""
    reasons = {
        "pairs that are left out": scene.excluded is not None,
        "pairs that touch at the start": scene.touching is not None,
        "welded vertices": scene.copies is not None,
        "an extraordinary size or masses": twin is not scene,
    }
    found = [reason for reason, holds in reasons.items() if holds]
    if found:
        raise OptionError(
            f"scene: a GpuScene takes none with {found[0]}; resolve it step by step: "
            'resolve(scene, device="cuda"), then scene.after(result, positions_t1)'
        )

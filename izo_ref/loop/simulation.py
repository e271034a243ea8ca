"""What a simulation on a GPU gives to its caller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from izo_ref.base.arrays import GpuArray
from izo_ref.base.records import Status
from izo_ref.loop.iterate import Iteration
from izo_ref.loop.resolve import Result


@dataclass(frozen=True, kw_only=True)
class GpuResult:
    """How a step of a `GpuScene` ended.

    Attributes:
        positions: (n, 3) f8 [m], end of the path, in the numbering of the caller: an array of the
            GPU (`__cuda_array_interface__`), which no later step changes.
        status: How the step ended; its value is a sentence for the user.
        objective: sum m |x - y|^2 / sum m over the unpinned vertices [m^2].
        n_impacts: Number of impacts in zones.
        history: One record for each iteration.
        left_to_cpu: Number of zones that the GPU left to the CPU.
        full: What `resolve` returned, if the step had to be resolved by it; else None.
    """

    positions: GpuArray
    status: Status
    objective: float
    n_impacts: int
    history: list[Iteration]
    left_to_cpu: int
    full: Result | None


class GpuScene(Protocol):
    """A scene on a GPU, whose steps are resolved one after the other.

    Each step begins where the last one ended, or at other positions. The last detection of a step
    proves each pair of its path apart, which is what the filter of the path certificate does. So
    the start of the next step needs no check. Other positions are checked on the GPU, and by
    `Scene` if floats cannot tell that they are free of intersections. A step for which the loop
    finds no free path is resolved by `resolve`, with its fail-safe; so is one that has to stop at a
    time limit.

    Attributes:
        thickness: The thickness that is used [m].
    """

    thickness: float

    def resolve(self, positions_t1: Any, positions_t0: Any = None) -> GpuResult:
        """Resolve the next step.

        Args:
            positions_t1: (n, 3) [m], proposed positions, on the CPU or on the GPU.
            positions_t0: (n, 3) [m], positions at the start of the step, on the CPU or on the GPU,
                free of intersections: where a simulator moved the vertices after the last step, or
                a reset. None for the end of the last step, whose path was free.

        Returns:
            How it ended. If `status` is BLOCKED, the next step needs `positions_t0`.

        Raises:
            ShapeError: An array has the wrong shape or type.
            NonFiniteError: A position is NaN or infinite.
            SizeError: A coordinate is too large to compute with.
            InitialIntersectionError: The mesh intersects itself at `positions_t0`. The error holds
                the pairs.
            OptionError: The positions make a scene of extraordinary size, or pairs are left out or
                touch at `positions_t0`.
            WeldError: Vertices are welded at `positions_t0` by a chain that is too long.
            UncertifiedStartError: The last step was blocked, or ended with an error, and there is
                no `positions_t0`.

        After each of these errors the scene is as it was, and the next call may go on.
        """
        ...

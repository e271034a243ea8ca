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

    Each step begins where the last one ended. The last detection of a step proves each pair of its
    path apart, which is what the filter of the path certificate does. So the start of the next step
    needs no check. A step for which the loop finds no free path is resolved by `resolve`, with its
    fail-safe; so is one that has to stop at a time limit.

    Attributes:
        thickness: The thickness that is used [m].
    """

    thickness: float

    def resolve(self, positions_t1: Any) -> GpuResult:
        """Resolve the next step.

        Args:
            positions_t1: (n, 3) [m], proposed positions, on the CPU or on the GPU.

        Returns:
            How it ended. If `status` is BLOCKED, no step can follow.

        Raises:
            ShapeError: `positions_t1` has the wrong shape or type.
            NonFiniteError: A position is NaN or infinite; the scene stays as it was.
            SizeError: A coordinate is too large to compute with; the scene stays as it was.
            OptionError: The positions make a scene of extraordinary size; it stays as it was.
            UncertifiedStartError: The last step was blocked.
        """
        ...

"""What the loop needs of a step.

`cpu_step.py` and `gpu_step.py` implement the protocol; the loop and the fail-safe know no more of
them than this.
"""

from __future__ import annotations

from typing import Any, Protocol

from izo_ref.base.arrays import Flags, Indices, Ints, Multipliers, Positions
from izo_ref.base.records import DetectionCounts, Impacts, SceneArrays


class Step(Protocol):
    """A step of the outer loop: the positions, the impacts in zones, and their multipliers.

    The arrays are on the CPU or on a GPU, as the implementation says.

    Attributes:
        scene: The scene, in the numbering of the loop; `current_scene` has its positions.
        positions: (n_vertices, 3) f8 [m], end positions of the current path.
        impacts: All impacts that entered the zones.
        multipliers: (n_impacts,) f8 [kg].
        active: (n_impacts,) b1, impacts that hold the positions.
        stuck: (n_vertices,) b1, vertices of zones that no positions satisfy.
        known_depths: (n_vertices,) i4, whether each vertex was in a deep zone, in another one, or
            in none (`zones/serial/deep_selection.py`).
        found: Impacts of the last detection, without those that have pinned vertices only.
        longest: The end positions whose path was free for the longest time, and that time.
        n_left: Number of zones that a GPU left to the CPU.
    """

    scene: SceneArrays
    positions: Positions
    impacts: Impacts
    multipliers: Multipliers
    active: Flags
    stuck: Flags
    known_depths: Ints
    found: Impacts
    longest: tuple[Positions, float]
    n_left: int

    @property
    def n_impacts(self) -> int:
        """Number of impacts in zones."""
        ...

    @property
    def n_active(self) -> int:
        """Number of active impacts."""
        ...

    def relinearize(self) -> None:
        """Go back to the proposed positions, and linearize the tight impacts anew.

        They are those whose gap is no more than the thickness: impacts that push, and impacts that
        push nothing because another one at the same points does. Which one of two such impacts
        pushes is a matter of rounding. Their normals and weights are taken anew from the closest
        points at the current positions. The other impacts stay as they are.
        """
        ...

    def save(self) -> tuple[Any, ...]:
        """Return the state that `restore` takes."""
        ...

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Return to a saved state."""
        ...

    def objective(self) -> float:
        """Return the objective at the current positions [m^2]."""
        ...

    def detect(self) -> DetectionCounts:
        """Find the impacts of the path to the current positions."""
        ...

    def first_found(self, count: int) -> Impacts:
        """Return the first impacts of `found`, at most this many, on the CPU."""
        ...

    def one_meets(self, count: int) -> bool:
        """Return whether one of the first impacts of `found`, at most this many, certainly meets.

        Floats decide near the times of impact, so False says nothing.
        """
        ...

    def current_scene(self) -> SceneArrays:
        """Return `scene` with the positions on the CPU; on a GPU, those of `scene` may be old."""
        ...

    def select(self) -> int:
        """Let impacts of the last detection enter the zones, and return how many did."""
        ...

    def solve(self, first_new: int) -> tuple[int, int]:
        """Solve the zones that have an impact with this index or a higher one.

        Args:
            first_new: Index of the first impact that is new.

        Returns:
            The number of zones, and how many of them were solved now.
        """
        ...

    def to_cpu(self) -> Step:
        """Return the same step on the CPU."""
        ...

    def positions_on_gpu(self, positions: Positions, order: Indices | None = None) -> Any:
        """Return end positions as an array of the GPU, or None if the step is on the CPU.

        Args:
            positions: (n_vertices, 3) f8 [m], on the CPU.
            order: (n_vertices,) i8, the caller's vertex at each place, if `positions` are the
                positions of this step in the caller's order; else None.
        """
        ...

"""Select which of the impacts found enter the zones, on a GPU."""

from __future__ import annotations

from typing import Any

from izo_ref.base.arrays import GpuArray, Indices
from izo_ref.base.gpu_arrays import empty, overwrite, zeros
from izo_ref.base.gpu_launch import by_grid
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import selection as kernels
from izo_ref.zones.gpu_grouping import FEW
from izo_ref.zones.group_buffers import selection_work, vertex_labels, zone_impacts
from izo_ref.zones.serial.group_counts import NEEDED_IMPACTS
from izo_ref.zones.serial.group_records import (
    ALL,
    FIRST_OF_ANY,
    INDEPENDENT,
    SelectionRule,
    StepArrays,
    ZoneImpacts,
)

# Values of `Options.selection`, and of `SelectionRule.selection`.
SELECTIONS = {"independent": INDEPENDENT, "first-of-any": FIRST_OF_ANY, "all": ALL}


class SelectionStage:
    """The selection of a step, which is one launch.

    Its arrays are made once; they have room for all impacts that `found` has room for.

    Args:
        found: The impacts found, with room for more.
        n_found: (1,) i8, number of impacts found.
        step: Arrays of the step.
        rule: Which impacts are selected.
        impacts: The impacts in zones, with room for more.
        counts: (N_COUNTS,) i8 of `zones/serial/group_counts.py`; IMPACTS is valid.
        few: Most impacts that one block selects among.

    Attributes:
        impacts: The impacts in zones, with room for more; `grow` replaces them.
    """

    def __init__(
        self,
        found: Impacts,
        n_found: GpuArray,
        step: StepArrays,
        rule: SelectionRule,
        impacts: ZoneImpacts,
        counts: GpuArray,
        few: int = FEW,
    ) -> None:
        """Make the arrays; nothing runs yet."""
        self.impacts, self._found, self._n_found = impacts, found, n_found
        self._step, self._rule, self._counts, self._few = step, rule, counts, few
        room, n_vertices = found.toi.shape[0], step.pinned.shape[0]
        self._vertices = vertex_labels(room, n_vertices, empty, zeros)
        self._work = selection_work(found, n_vertices, empty)

    def launches(self) -> list[Any]:
        """Return the launch that lets impacts enter the zones, with the present arrays."""
        own = self._found, self._n_found, self._rule, self._step, self.impacts
        work = self._vertices, self._work, self._counts
        return [by_grid(kernels.select_impacts, self._few, *own, *work)]

    def grow(self, counts: Indices) -> bool:
        """Make more room for the impacts in zones if the last selection did not fit.

        Args:
            counts: (N_COUNTS,) i8, a copy on the CPU.

        Returns:
            Whether the launches have to be made anew, and run again.
        """
        room, needed = self.impacts.toi.shape[0], int(counts[NEEDED_IMPACTS])
        if needed > room:
            larger = zone_impacts(max(needed, 2 * room), empty)
            for column, values in zip(larger, self.impacts, strict=True):
                overwrite(column[:room], values)
            self.impacts = larger
        return needed > room

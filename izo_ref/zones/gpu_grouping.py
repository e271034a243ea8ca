"""Zones on a GPU: impacts that share an unpinned vertex, in contiguous blocks."""

from __future__ import annotations

from typing import Any

from izo_ref.base.arrays import GpuArray
from izo_ref.base.gpu_arrays import empty, zeros
from izo_ref.base.gpu_launch import THREADS, by_grid
from izo_ref.zones.cuda import grouping as kernels
from izo_ref.zones.group_buffers import group_work, vertex_labels, zone_lists
from izo_ref.zones.serial.group_records import ZoneRule

# Most impacts that one block selects among or groups: one a thread. A wait of all blocks takes
# longer than a wait of one block, but one block has fewer threads for the work. From how many
# impacts on all blocks are faster was not measured.
FEW = THREADS


class GroupingStage:
    """The zones of a step, and which of them have to be solved; they take one launch.

    Its arrays are made once; they have room for all zones that the impacts can have.

    Args:
        nodes: (room, 4) i4, of the impacts in zones, with room for more.
        pinned: (n_vertices,) b1.
        stuck: (n_vertices,) b1; becomes true for all vertices of zones that have a stuck vertex.
        rule: Which zones are solved.
        counts: (N_COUNTS,) i8 of `zones/serial/group_counts.py`; FIRST_NEW and IMPACTS are valid.
        few: Most impacts that one block groups.

    Attributes:
        lists: The zones, and those that have to be solved.
    """

    def __init__(
        self,
        nodes: GpuArray,
        pinned: GpuArray,
        stuck: GpuArray,
        rule: ZoneRule,
        counts: GpuArray,
        few: int = FEW,
    ) -> None:
        """Make the arrays; nothing runs yet."""
        room, n_vertices = nodes.shape[0], pinned.shape[0]
        self._own = few, nodes, pinned, rule, stuck
        self._vertices = vertex_labels(room, n_vertices, empty, zeros)
        self._work, self._counts = group_work(room, n_vertices, empty), counts
        self.lists = zone_lists(room, n_vertices, empty)

    def launches(self) -> list[Any]:
        """Return the launch that builds the zones and lists those that have to be solved."""
        own = *self._own, self.lists, self._vertices, self._work, self._counts
        return [by_grid(kernels.group_impacts, *own)]

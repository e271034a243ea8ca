"""Connected components of a mesh, and the boxes in which they move."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Indices, Positions
from izo_ref.base.serial.components import impact_components
from izo_ref.detection.serial.reach import moving_vertices

# Up to this many moving components are compared one by one. If there are more, the box about all
# of them is compared.
FEW = 1000


class MeshComponents:
    """Connected components of a mesh; a vertex in no face is a component of its own.

    They are found when they are first needed, and belong to the mesh: the steps of a simulation
    share them.

    Args:
        n_vertices: Number of vertices of the mesh.
        faces: (m, 3) i4.
    """

    def __init__(self, n_vertices: int, faces: Faces) -> None:
        """Keep the mesh; nothing is searched yet."""
        self._n_vertices, self._faces = n_vertices, faces

    @cached_property
    def _parts(self) -> tuple[Indices, Indices, Indices]:
        """The component of each vertex, the vertices sorted by it, and where each one begins."""
        n, faces = self._n_vertices, self._faces
        roots, face_roots = np.arange(n), np.empty(len(faces), np.int64)
        corners = np.column_stack((faces, faces[:, 0]))
        impact_components(corners, np.zeros(n, bool), np.empty(n, np.int64), face_roots)
        roots[faces] = face_roots[:, None]
        smallest, component = np.unique(roots, return_inverse=True)
        order = np.argsort(component, kind="stable")
        return component, order, np.searchsorted(component[order], np.arange(len(smallest)))

    @property
    def component(self) -> Indices:
        """(n_vertices,) i8, the component that each vertex is in."""
        return self._parts[0]

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self._parts[2])

    def renumbered(self, order: Indices) -> MeshComponents:
        """Return the same components of a mesh with vertex `order[i]` as number i.

        Args:
            order: (n_vertices,) i8.
        """
        return _Renumbered(self, order)

    def boxes(self, positions: Positions) -> tuple[Positions, Positions]:
        """Return the minima and the maxima of each component, (count, 3) f8 [m] each."""
        _, order, starts = self._parts
        sorted_positions = positions[order]
        return (
            np.minimum.reduceat(sorted_positions, starts),
            np.maximum.reduceat(sorted_positions, starts),
        )

    def moving(self, positions_t0: Positions, positions_t1: Positions) -> Flags:
        """Return which components have a vertex that moves, (count,) b1."""
        moving = np.zeros(self.count, bool)
        moving[self.component[moving_vertices(positions_t0, positions_t1)]] = True
        return moving

    def out_of_reach(self, positions_t0: Positions, positions_t1: Positions) -> Flags:
        """Return which components are at rest and meet the box of no moving component.

        The box of a moving component holds its start and its end, hence its path.

        Args:
            positions_t0: (n_vertices, 3) f8 [m].
            positions_t1: (n_vertices, 3) f8 [m].

        Returns:
            (count,) b1.
        """
        moving = self.moving(positions_t0, positions_t1)
        far = ~moving
        if not moving.any() or moving.all():
            return far
        low_t0, high_t0 = self.boxes(positions_t0)
        low_t1, high_t1 = self.boxes(positions_t1)
        low, high = np.minimum(low_t0, low_t1), np.maximum(high_t0, high_t1)
        lows, highs = low[moving], high[moving]
        if len(lows) > FEW:
            lows, highs = lows.min(axis=0)[None], highs.max(axis=0)[None]
        for a, b in zip(lows, highs, strict=True):
            far &= ~((low <= b) & (a <= high)).all(axis=1)
        return far


class _Renumbered(MeshComponents):
    """Components that are found in another numbering of the vertices."""

    def __init__(self, found: MeshComponents, order: Indices) -> None:
        self._found, self._order = found, order

    @cached_property
    def _parts(self) -> tuple[Indices, Indices, Indices]:
        component, order, starts = self._found._parts
        place = np.empty(len(self._order), np.int64)
        place[self._order] = np.arange(len(place))
        return component[self._order], place[order], starts

"""Connected components of a mesh, and the boxes in which they move."""

from __future__ import annotations

from functools import cached_property

from izo_ref.base.arrays import Faces, Flags, Indices, Positions
from izo_ref.detection.serial.components import number_components, paths_of_components

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
    def _parts(self) -> tuple[Indices, int]:
        """The component of each vertex, and the number of components."""
        return number_components(self._n_vertices, self._faces)

    @property
    def component(self) -> Indices:
        """(n_vertices,) i8, the component that each vertex is in."""
        return self._parts[0]

    @property
    def count(self) -> int:
        """Number of components."""
        return self._parts[1]

    def renumbered(self, order: Indices) -> MeshComponents:
        """Return the same components of a mesh with vertex `order[i]` as number i.

        Args:
            order: (n_vertices,) i8.
        """
        return _Renumbered(self, order)

    def out_of_reach(self, positions_t0: Positions, positions_t1: Positions) -> Flags:
        """Return which components are at rest and meet the box of no moving component.

        The box of a moving component holds its start and its end, hence its path.

        Args:
            positions_t0: (n_vertices, 3) f8 [m].
            positions_t1: (n_vertices, 3) f8 [m].

        Returns:
            (count,) b1.
        """
        moving, low, high = paths_of_components(*self._parts, positions_t0, positions_t1)
        far = ~moving
        if not far.any():
            return far
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
    def _parts(self) -> tuple[Indices, int]:
        component, count = self._found._parts
        return component.take(self._order), count

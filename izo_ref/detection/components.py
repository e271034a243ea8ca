"""Connected components of a mesh, and the boxes in which they move."""

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Positions
from izo_ref.base.serial.components import impact_components

# Up to this many moving components are compared one by one. If there are more, the box about all
# of them is compared.
FEW = 1000


class MeshComponents:
    """Connected components of a mesh; a vertex in no face is a component of its own.

    Args:
        n_vertices: Number of vertices of the mesh.
        faces: (m, 3) i4.

    Attributes:
        component: (n_vertices,) i8, the component that each vertex is in.
        count: Number of components.
    """

    def __init__(self, n_vertices: int, faces: Faces) -> None:
        """Find the components; the class says what the arguments are."""
        roots, face_roots = np.arange(n_vertices), np.empty(len(faces), np.int64)
        corners = np.column_stack((faces, faces[:, 0]))
        unpinned = np.zeros(n_vertices, bool)
        impact_components(corners, unpinned, np.empty(n_vertices, np.int64), face_roots)
        roots[faces] = face_roots[:, None]
        _, self.component = np.unique(roots, return_inverse=True)
        self.count = int(self.component.max(initial=-1)) + 1
        self._order = np.argsort(self.component, kind="stable")
        self._starts = np.searchsorted(self.component[self._order], np.arange(self.count))

    def boxes(self, positions: Positions) -> tuple[Positions, Positions]:
        """Return the minima and the maxima of each component, (count, 3) f8 [m] each."""
        sorted_positions = positions[self._order]
        return (
            np.minimum.reduceat(sorted_positions, self._starts),
            np.maximum.reduceat(sorted_positions, self._starts),
        )

    def moving(self, positions_t0: Positions, positions_t1: Positions) -> Flags:
        """Return which components have a vertex that moves, (count,) b1."""
        moving_vertices = (positions_t0 != positions_t1).any(axis=1)
        return np.isin(np.arange(self.count), self.component[moving_vertices])

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

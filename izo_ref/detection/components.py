"""Parts of a mesh that are connected, and the boxes they move in."""

import numpy as np

from izo_ref.base.serial.components import impact_components

# Boxes of moving parts that are compared one by one; of more, only the box about all.
FEW = 1000


class MeshComponents:
    """Connected parts of a mesh; a vertex in no face is a part.

    Args:
        n_vertices: of the mesh.
        faces: (m, 3) i4.

    Attributes:
        part: (n_vertices,) i8, the part that each vertex is in.
        count: of parts.
    """

    def __init__(self, n_vertices, faces):
        roots, component = np.arange(n_vertices), np.empty(len(faces), np.int64)
        corners = np.column_stack((faces, faces[:, 0]))
        nobody = np.zeros(n_vertices, bool)
        impact_components(corners, nobody, np.empty(n_vertices, np.int64), component)
        roots[faces] = component[:, None]
        _, self.part = np.unique(roots, return_inverse=True)
        self.count = int(self.part.max(initial=-1)) + 1
        self._order = np.argsort(self.part, kind="stable")
        self._starts = np.searchsorted(self.part[self._order], np.arange(self.count))

    def boxes(self, positions):
        """(count, 3) f8 [m] each, minima and maxima."""
        sorted_positions = positions[self._order]
        return (
            np.minimum.reduceat(sorted_positions, self._starts),
            np.maximum.reduceat(sorted_positions, self._starts),
        )

    def moving(self, positions_t0, positions_t1):
        """(count,) b1, whether a vertex of each moves."""
        return np.isin(np.arange(self.count), self.part[(positions_t0 != positions_t1).any(axis=1)])

    def out_of_reach(self, positions_t0, positions_t1):
        """(count,) b1, parts at rest whose box is met by none that moves."""
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

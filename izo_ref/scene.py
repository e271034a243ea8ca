"""The door: arrays of a step come in here and are checked once."""

import numpy as np

from izo_ref.base import checks
from izo_ref.base.devices import copy_to_cpu, detach, is_on_gpu
from izo_ref.base.errors import DegenerateFaceError, InitialIntersectionError, OptionError
from izo_ref.base.mesh import edges_of
from izo_ref.detection.intersections import intersecting_pairs

SHOWN = 5  # offenders named in a message


class Scene:
    """One time step of a triangle mesh: where it starts and where it is proposed to end.

    Arrays may be on a GPU (`__cuda_array_interface__` or DLPack). What the processor checks is
    copied to it; of positions a GPU then reads the array that came in, which is not to change
    before the step is resolved.

    Args:
        positions_t0: (n, 3) [m], start of the step, free of intersections (Q0).
        positions_t1: (n, 3) [m], proposed end (Q1).
        faces: (m, 3) vertex indices. Vertices in no face take part as points.
        masses: (n,) [kg], positive; 1 if None. Those of pinned vertices are not used.
        pinned: (n,) bool, vertices that follow their path exactly; none if None.
        initial_intersections: `raise`, or `exclude`: leave out the pairs that intersect
            at the start and list them in `excluded`.

    Attributes:
        positions_t0, positions_t1: (n, 3) f8 [m].
        faces: (m, 3) i4.
        edges: (k, 2) i4, each edge once, lower index first, sorted.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
        excluded: `Pairs` left out, or None.
        on_gpu: those of the positions that came from a GPU: the array and None, or (n,) i8, which
            of its rows each vertex has.

    Raises:
        ShapeError, NonFiniteError, IndexRangeError, DegenerateFaceError, MassError,
        InitialIntersectionError: with what was expected, what was found, and the first
        offenders.
    """

    def __init__(
        self,
        positions_t0,
        positions_t1,
        faces,
        masses=None,
        pinned=None,
        *,
        initial_intersections="raise",
    ):
        if initial_intersections not in ("raise", "exclude"):
            raise OptionError(
                "initial_intersections: expected 'raise' or 'exclude', "
                f"got {initial_intersections!r}"
            )
        arrays = {
            "positions_t0": detach(positions_t0),
            "positions_t1": detach(positions_t1),
            "faces": faces,
            "masses": detach(masses),
            "pinned": pinned,
        }
        points = ("positions_t0", "positions_t1")
        self.on_gpu = {k: (arrays[k], None) for k in points if is_on_gpu(arrays[k])}
        positions_t0, positions_t1, faces, masses, pinned = (
            copy_to_cpu(name, array) for name, array in arrays.items()
        )
        self.positions_t0 = checks.floats("positions_t0", positions_t0, (None, 3))
        n = len(self.positions_t0)
        self.positions_t1 = checks.floats("positions_t1", positions_t1, (n, 3))
        self.faces = _distinct_corners(checks.indices("faces", faces, 3, n))
        self.masses = np.ones(n) if masses is None else checks.masses(masses, n)
        self.pinned = np.zeros(n, bool) if pinned is None else checks.flags("pinned", pinned, n)
        self.edges = edges_of(self.faces)
        self.excluded = self._initial_intersections(initial_intersections == "exclude")

    def _initial_intersections(self, exclude):
        crossing, pairs = intersecting_pairs(self.positions_t0, self.edges, self.faces)
        if len(pairs.nodes) == 0:
            return None
        if exclude:
            return pairs
        shown = "; ".join(f"{a} and {b}" for a, b in crossing[:SHOWN])
        raise InitialIntersectionError(
            "positions_t0: expected a mesh without intersections, found "
            f"{len(crossing)}, the first: {shown}. Pass initial_intersections='exclude' to "
            "leave these pairs out.",
            pairs,
        )


def _distinct_corners(faces):
    a, b, c = faces.T
    bad = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(bad):
        raise DegenerateFaceError(
            f"faces: expected three different vertices each, found {len(bad)} with a repeated "
            f"one, the first face {bad[0]}: {faces[bad[0]].tolist()}"
        )
    return faces

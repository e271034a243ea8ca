"""The scene: checks the arrays of a time step once, where they come in.

Everything below this module takes a scene as valid and does not check it again.
"""

from typing import Any

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Edges, Faces, Flags, Indices, Masses, Positions
from izo_ref.base.devices import copy_to_cpu, detach, is_on_gpu
from izo_ref.base.errors import DegenerateFaceError, InitialIntersectionError, OptionError
from izo_ref.base.mesh import edges_of
from izo_ref.base.records import Pairs
from izo_ref.detection.intersections import find_intersections

SHOWN = 5  # intersections that the message of an error names


class Scene:
    """One time step of a triangle mesh: where it starts and where it is proposed to end.

    Every array may be on a GPU (`__cuda_array_interface__` or DLPack). The CPU checks a copy. A
    step on a GPU reads the positions from the array that was passed in, so that array must not
    change before the step is resolved.

    The message of each error says what was expected and what was found, and names the first
    offenders.

    Args:
        positions_t0: (n, 3) [m], positions at the start of the step (Q0), free of intersections.
        positions_t1: (n, 3) [m], proposed positions at its end (Q1).
        faces: (m, 3), indices of vertices. A vertex in no face takes part as a point.
        masses: (n,) [kg], positive; 1 for every vertex if None. The masses of pinned vertices are
            not used.
        pinned: (n,) bool, True for vertices that follow their path exactly; if None, no vertex is
            pinned.
        initial_intersections: What to do if the mesh intersects itself at the start: `raise` an
            error, or `exclude` the pairs that intersect. Detection then ignores these pairs, and
            `excluded` lists them.

    Attributes:
        positions_t0: (n, 3) f8 [m], start of the step.
        positions_t1: (n, 3) f8 [m], proposed end of the step.
        faces: (m, 3) i4.
        edges: (k, 2) i4, each edge once, the lower vertex first, sorted.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
        excluded: `Pairs` that detection ignores, or None.
        on_gpu: `{name: (array, order)}` for positions that came from a GPU. `order` is (n,) i8 and
            maps vertices to rows of the array; None means that vertex i is row i.

    Raises:
        ShapeError: An array has the wrong shape or type.
        NonFiniteError: A position or a mass is NaN or infinite.
        IndexRangeError: A face has an index of no vertex.
        DegenerateFaceError: A face has the same vertex twice.
        MassError: A mass is zero or negative.
        OptionError: `initial_intersections` has another value.
        InitialIntersectionError: The mesh intersects itself at the start. The error holds the
            pairs.
        DeviceUnavailableError: An array is on a GPU that cannot be used.
    """

    def __init__(
        self,
        positions_t0: Any,
        positions_t1: Any,
        faces: Any,
        masses: Any = None,
        pinned: Any = None,
        *,
        initial_intersections: str = "raise",
    ) -> None:
        """Check and copy the arrays of a step; the class says what they are."""
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
        self.on_gpu: dict[str, tuple[Any, Indices | None]] = {
            name: (arrays[name], None)
            for name in ("positions_t0", "positions_t1")
            if is_on_gpu(arrays[name])
        }
        positions_t0, positions_t1, faces, masses, pinned = (
            copy_to_cpu(name, array) for name, array in arrays.items()
        )
        self.positions_t0: Positions = checks.floats("positions_t0", positions_t0, (None, 3))
        n = len(self.positions_t0)
        self.positions_t1: Positions = checks.floats("positions_t1", positions_t1, (n, 3))
        self.faces: Faces = checks.indices("faces", faces, 3, n)
        _require_distinct_corners(self.faces)
        self.masses: Masses = np.ones(n) if masses is None else checks.masses(masses, n)
        self.pinned: Flags = (
            np.zeros(n, bool) if pinned is None else checks.flags("pinned", pinned, n)
        )
        self.edges: Edges = edges_of(self.faces)
        self.excluded: Pairs | None = self._initial_intersections(
            initial_intersections == "exclude"
        )

    def _initial_intersections(self, exclude: bool) -> Pairs | None:
        """Return the pairs that intersect at the start, None if there are none, or raise."""
        found = find_intersections(self.positions_t0, self.edges, self.faces)
        if found.n_found == 0:
            return None
        if exclude:
            return found.pairs()
        shown = "; ".join(f"{a} and {b}" for a, b in found.describe(SHOWN))
        raise InitialIntersectionError(
            "positions_t0: expected a mesh without intersections, found "
            f"{found.n_found}, the first: {shown}. Pass initial_intersections='exclude' to "
            "leave these pairs out.",
            found.pairs(),
        )


def _require_distinct_corners(faces: Faces) -> None:
    a, b, c = faces.T
    repeated = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(repeated):
        first = repeated[0]
        raise DegenerateFaceError(
            f"faces: expected three different vertices each, found {len(repeated)} with a "
            f"repeated one, the first face {first}: {faces[first].tolist()}"
        )

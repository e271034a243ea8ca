"""The path certificate: every candidate pair proved apart, or named."""

from typing import NamedTuple

import numpy as np

from izo_ref import checks
from izo_ref.detect import Detector
from izo_ref.options import Options
from izo_ref.types import Pairs


class PathCertificate(NamedTuple):
    """What was proved about the straight path from the start to some end positions.

    The path is free if no pair is undecided. A pair is undecided if it meets, or comes
    closer than rounding can tell from meeting.
    """

    free: bool  # every pair but the excluded ones is proved apart
    candidates: int  # pairs with swept boxes that meet; all others are apart by that
    vertex_face: int  # of these, by kind
    edge_edge: int
    proofs: int  # steps of all proofs; a pair apart at first sight takes one
    most_proofs: int  # for one pair
    undecided: Pairs  # not proved apart
    undecided_toi: np.ndarray  # (n,) f8, until when each was
    time_free: float  # until when every pair was; 1 if free
    excluded: Pairs | None  # left out, because they intersect at the start


def certify_path(scene, positions, options: Options | None = None) -> PathCertificate:
    """Prove each pair of a path apart, or name it.

    A detection of its own, from new trees of boxes and over all pairs, whatever the path
    was made by. A pair is proved apart on [0, 1] piece by piece, by a direction that
    separates its sides or by a cubic without root; both with a bound of the rounding,
    derived in `scalar/advance.py` and `scalar/coplanar.py`.

    Args:
        scene: `Scene`, gives the start, the mesh and the pairs left out.
        positions: (n, 3) [m], end of the path.
        options: `Options`; `batch_pairs` is used.

    Raises:
        ShapeError, NonFiniteError: of `positions`.

    Source: SPEC section 8.
    """
    options = options or Options()
    positions = checks.floats("positions", positions, scene.positions_t0.shape)
    detector = Detector(
        scene.positions_t0, scene.edges, scene.faces, scene.excluded, options.batch_pairs
    )
    found = detector.find(positions)
    tally = detector.tally
    return PathCertificate(
        free=len(found.toi) == 0,
        candidates=sum(tally.pairs.values()),
        vertex_face=tally.pairs["vertex_face"],
        edge_edge=tally.pairs["edge_edge"],
        proofs=tally.steps,
        most_proofs=tally.most_steps,
        undecided=Pairs(found.nodes, found.is_edge_edge),
        undecided_toi=found.toi,
        time_free=float(found.toi.min(initial=1.0)),
        excluded=scene.excluded,
    )

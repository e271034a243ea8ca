"""The path certificate: every candidate pair proved apart, or shown to meet."""

from typing import NamedTuple

import numpy as np

from izo_ref.base import checks
from izo_ref.base.devices import choose_device, copy_to_cpu, detach, implementation
from izo_ref.base.options import RULES
from izo_ref.base.records import Impacts, Pairs
from izo_ref.certificate.cpu import meetings as kernels
from izo_ref.certificate.exact_path import first_meeting
from izo_ref.detection.detector import Detector


class PathCertificate(NamedTuple):
    """What was proved about the straight path from the start to some end positions.

    No pair is left open: each is proved apart, or proved to meet.
    """

    free: bool  # every pair but the excluded ones is apart
    candidates: int  # pairs with moving boxes that meet; all others are apart by that, or rest
    vertex_face: int  # of these, by kind
    edge_edge: int
    proofs: int  # steps of all proofs; a pair apart along an axis or a diagonal takes none
    most_proofs: int  # for one pair
    exact: int  # pairs that floats could not decide, so exact arithmetic did
    meeting: Pairs  # what meets
    meeting_toi: np.ndarray  # (n,) f8, when; at most the rounding of the proof too early
    time_free: float  # until when every pair is apart; 1 if the path is free
    excluded: Pairs | None  # left out, because they intersect at the start


def certify_path(scene, positions, rules=frozenset(RULES), device: str = "cpu") -> PathCertificate:
    """Prove each pair of a path apart, or that it meets.

    A detection of its own, from new trees of boxes and over all pairs, whatever the path
    was made by. A pair is proved apart on [0, 1] piece by piece, by a direction that
    separates its sides or by a cubic without root; or to meet, by a change of sign of that
    cubic while the contact is inside. All with a bound of the rounding, derived in
    `detection/formulas/advance.py`, `detection/formulas/coplanar.py` and
    `certificate/formulas/meeting.py`. The few pairs left, those that touch or nearly do, are
    decided in exact arithmetic, `certificate/exact_path.py`.

    Args:
        scene: `Scene`, gives the start, the mesh and the pairs left out.
        positions: (n, 3) [m], end of the path; may be on a GPU.
        rules: names of `options.RULES` that are applied.
        device: `cpu`; `cuda`, where a GPU proves and the processor decides the pairs left; or
            `auto`, as of `resolve`.

    Raises:
        ShapeError, NonFiniteError: of `positions`.
        OptionError, DeviceUnavailableError: of `device`.

    Source: SPEC section 8.
    """
    positions = copy_to_cpu("positions", detach(positions))
    positions = checks.floats("positions", positions, scene.positions_t0.shape)
    filter_path = implementation(
        choose_device(device, scene), _filter_path, "izo_ref.certificate.gpu_filter:filter_path"
    )
    found, certain, counts = filter_path(scene, positions, rules)
    if "float-verdicts" not in rules:
        certain[:] = False
    meeting, exact = _meeting(scene.positions_t0, positions, found, certain)
    return PathCertificate(
        free=len(meeting.toi) == 0,
        candidates=sum(counts.pairs.values()),
        vertex_face=counts.pairs["vertex_face"],
        edge_edge=counts.pairs["edge_edge"],
        proofs=counts.steps,
        most_proofs=counts.most_steps,
        exact=exact,
        meeting=Pairs(meeting.nodes, meeting.is_edge_edge),
        meeting_toi=meeting.toi,
        time_free=float(meeting.toi.min(initial=1.0)),
        excluded=scene.excluded,
    )


def _filter_path(scene, positions, rules):
    """Pairs not proved apart, which of them certainly meet, and a counts."""
    start = scene.positions_t0
    detector = Detector(start, scene.edges, scene.faces, scene.excluded, rules)
    found = detector.find(positions)
    meets = np.empty(len(found.toi), bool)
    kernels.decide_meetings(start, positions, found.nodes, found.is_edge_edge, found.toi, meets)
    return found, meets, detector.counts


def _meeting(positions_t0, positions_t1, found: Impacts, certain):
    """Those of the pairs found that meet, and how many took exact arithmetic."""
    meets, toi = certain.copy(), found.toi.copy()
    open_pairs = np.flatnonzero(~meets)
    for i in open_pairs:
        nodes = found.nodes[i]
        time = first_meeting(found.is_edge_edge[i], positions_t0[nodes], positions_t1[nodes])
        meets[i] = time is not None
        toi[i] = 1.0 if time is None else time
    return found._replace(toi=toi).take(meets), len(open_pairs)

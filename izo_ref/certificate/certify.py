"""The path certificate: prove every candidate pair of a path apart, or prove that it meets."""

from collections.abc import Set
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base import checks
from izo_ref.base.arrays import Codes, Flags, Positions, Times
from izo_ref.base.deadline import UNLIMITED, Deadline, OutOfTimeError
from izo_ref.base.devices import choose_device, copy_to_cpu, detach, implementation
from izo_ref.base.exact_path import first_meeting
from izo_ref.base.options import RULES
from izo_ref.base.records import (
    ExcludedPairs,
    Exclusion,
    Impacts,
    PairCounts,
    Pairs,
    PairState,
    SceneArrays,
    TouchingPairs,
    no_impacts,
)
from izo_ref.base.sizes import path_in_range
from izo_ref.certificate.cpu import meetings as kernels
from izo_ref.detection.detector import Detector
from izo_ref.detection.intersections import states_of_pairs
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.detection.serial.prescribed import prescribed_impacts
from izo_ref.detection.weld import require_together


class PathCertificate(NamedTuple):
    """What was proved about the straight path from the start to some end positions.

    No pair is left undecided: each is proved apart, or proved to meet. Only the time limit of
    `resolve` can end a certificate before that; it then proves nothing.

    Attributes:
        free: True if every pair is apart, except the excluded pairs. Pairs that touch at the start
            (`Scene.touching`) are apart from then on, and no edge goes through a face with which
            it touched.
        candidates: Number of candidate pairs, whose moving boxes meet. All other pairs are apart
            because their boxes are, or because they are at rest.
        vertex_face: Number of vertex-face pairs among the candidates.
        edge_edge: Number of edge-edge pairs among the candidates.
        proofs: Number of steps of all proofs in float64. A pair that an axis or a diagonal
            separates takes no step. Neither does one that a GPU proves apart in float32, so this
            number is smaller on a GPU.
        most_proofs: Number of steps of the longest proof of a pair.
        exact: Number of pairs that floats could not decide, so that exact arithmetic did.
        meeting: The `Pairs` that meet, in the order of their times: the first one sets `time_free`.
        meeting_toi: (n,) f8, time at which each of them meets, never too late. It is early by at
            most the rounding of the proof.
        meeting_prescribed: (n,) b1, pairs that meet between pinned points. There are some only with
            `prescribed="block"`.
        time_free: Time until which every pair is apart, except the excluded pairs; 1 if the path is
            free.
        excluded: The `ExcludedPairs`, or None: pairs of `Scene.excluded`, and pairs that meet
            between pinned points with `prescribed="exclude"`. Nothing is proved about them.
        excluded_ends: (n,) i1, where each excluded pair is at the end of the path, values of
            `PairState`.
        scene: The scene whose mesh and start the path has.
        positions: (n, 3) f8 [m], the end of the path; read-only, because the proof holds for these
            bits.
        finished: False if the time limit of `resolve` ended the certificate. Then `free` is False,
            `time_free` is 0, all counts are 0 and `excluded_ends` is `UNKNOWN`.
    """

    free: bool
    candidates: int
    vertex_face: int
    edge_edge: int
    proofs: int
    most_proofs: int
    exact: int
    meeting: Pairs
    meeting_toi: Times
    meeting_prescribed: Flags
    time_free: float
    excluded: ExcludedPairs | None
    excluded_ends: Codes
    scene: SceneArrays
    positions: Positions
    finished: bool = True


def certify_path(
    scene: SceneArrays,
    positions: Any,
    rules: Set[str] = frozenset(RULES),
    device: str = "cpu",
) -> PathCertificate:
    """Prove for each pair of a path that it is apart, or that it meets.

    The certificate does not depend on how the path was made. It runs a detection of its own, with
    new trees of boxes, over all pairs. Then it decides each candidate pair in one of three ways:

    * The pair is apart on [0, 1]. This is proved interval by interval, by a direction that
      separates its sides or by a cubic without root (`detection/formulas/advance.py`,
      `detection/formulas/coplanar.py`).
    * The pair meets, because that cubic changes its sign while the contact is inside the pair
      (`certificate/formulas/meeting.py`).
    * Exact arithmetic decides the few pairs that are left. They touch, or nearly do
      (`base/exact_path.py`).

    The first two ways use floats, with bounds of their rounding that are derived in these files.

    Args:
        scene: The `Scene`, which gives the start, the mesh and the pairs to ignore.
        positions: (n, 3) [m], end of the path; may be on a GPU.
        rules: Names of the rules of `options.RULES` to apply.
        device: `cpu`, `cuda` or `auto`. With `cuda`, a GPU runs the first two ways, and the CPU
            decides the pairs that are left. `auto` takes a GPU for large scenes if there is one.

    Returns:
        The `PathCertificate`.

    Raises:
        ShapeError: `positions` has the wrong shape or type.
        NonFiniteError: `positions` has numbers that are NaN or infinite.
        WeldError: A copy of a vertex is at another place than the vertex.
        SizeError: A coordinate is too large or too small to compute with.
        OptionError: `device` has another value, `rules` has another name, or `scene` is no scene.
        DeviceUnavailableError: A GPU is asked for, and none can be used.

    Source: docs/method section 8.
    """
    return certify_in_time(scene, positions, rules, device, UNLIMITED)


def certify_in_time(
    scene: SceneArrays, positions: Any, rules: Set[str], device: str, deadline: Deadline
) -> PathCertificate:
    """Do what `certify_path` does, until the deadline.

    On a path at rest there is nothing to prove, so it is certified however late it is. Where the
    excluded pairs are at the end is left `UNKNOWN` if there is no time for that.

    Raises:
        OutOfTimeError: The deadline has passed.
    """
    checks.scene(scene)
    checks.rules(rules)
    positions = copy_to_cpu("positions", detach(positions))
    positions = checks.floats("positions", positions, scene.positions_t0.shape)
    if scene.copies is not None:
        require_together("positions", positions, scene.copies, 0.0)
    filter_path = implementation(
        choose_device(device, scene), _filter_path, "izo_ref.certificate.gpu_filter:filter_path"
    )
    path, ends = path_in_range(scene, positions)
    in_time = deadline
    if deadline.is_limited and "still" in rules and (positions == scene.positions_t0).all():
        in_time = UNLIMITED
    found, certain, counts = filter_path(path, ends, rules, in_time)
    if "float-verdicts" not in rules:
        certain[:] = False
    if scene.touching is not None:
        # exact arithmetic has decided about these pairs, which come last
        certain |= _among(found, scene.touching)
    meeting, exact = _meeting(path.positions_t0, ends, found, certain, in_time)
    prescribed = np.zeros(len(meeting.toi), bool)
    if scene.pinned.any():
        prescribed_impacts(meeting.nodes, meeting.weights, scene.pinned, prescribed)
    excluded = scene.excluded
    if scene.prescribed == "exclude" and prescribed.any():
        excluded = _joined(excluded, meeting.take(prescribed))
        meeting, prescribed = meeting.take(~prescribed), prescribed[~prescribed]
    states = _states_at_end(scene, ends, excluded, deadline)
    positions.setflags(write=False)  # only now, because numba compiles anew for such arrays
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
        meeting_prescribed=prescribed,
        time_free=float(meeting.toi.min(initial=1.0)),
        excluded=excluded,
        excluded_ends=states,
        scene=scene,
        positions=positions,
    )


def _states_at_end(
    scene: SceneArrays, ends: Positions, excluded: ExcludedPairs | None, deadline: Deadline
) -> Codes:
    """Return where excluded pairs are at the end, (n,) i1, or UNKNOWN if there is no time."""
    if excluded is None:
        return np.empty(0, np.int8)
    try:
        mesh = scene.edges, scene.faces, scene.tree_orders
        return states_of_pairs(excluded, ends, *mesh, deadline)
    except OutOfTimeError:
        return np.full(len(excluded.reasons), PairState.UNKNOWN, np.int8)


def unfinished_certificate(scene: SceneArrays, positions: Positions) -> PathCertificate:
    """Return the certificate of a path about which nothing was proved in time.

    Args:
        scene: The `Scene`.
        positions: (n, 3) f8 [m], end of the path; it becomes read-only.
    """
    excluded, nothing = scene.excluded, no_impacts()
    n_excluded = 0 if excluded is None else len(excluded.reasons)
    positions.setflags(write=False)
    return PathCertificate(
        free=False,
        candidates=0,
        vertex_face=0,
        edge_edge=0,
        proofs=0,
        most_proofs=0,
        exact=0,
        meeting=Pairs(nothing.nodes, nothing.is_edge_edge),
        meeting_toi=nothing.toi,
        meeting_prescribed=np.empty(0, bool),
        time_free=0.0,
        excluded=excluded,
        excluded_ends=np.full(n_excluded, PairState.UNKNOWN, np.int8),
        scene=scene,
        positions=positions,
        finished=False,
    )


def _among(found: Impacts, touching: TouchingPairs) -> Flags:
    """Return which impacts are of pairs that touch at the start, (n,) b1."""
    keys = set(pair_keys(touching))
    own = pair_keys(found)
    return np.array([key in keys for key in own], bool)


def _joined(excluded: ExcludedPairs | None, prescribed: Impacts) -> ExcludedPairs:
    """Return excluded pairs, and behind them those that meet between pinned points."""
    reasons = np.full(len(prescribed.toi), Exclusion.PRESCRIBED, np.int8)
    own = ExcludedPairs(prescribed.nodes, prescribed.is_edge_edge, reasons)
    if excluded is None:
        return own
    return ExcludedPairs._make([np.concatenate(parts) for parts in zip(excluded, own, strict=True)])


def _filter_path(
    scene: SceneArrays, positions: Positions, rules: Set[str], deadline: Deadline
) -> tuple[Impacts, Flags, PairCounts]:
    """Return the pairs not proved apart, which of them certainly meet, and the counts."""
    start = scene.positions_t0
    detector = Detector.of_scene(scene, rules, deadline)
    found = detector.find(positions)
    meets = np.empty(len(found.toi), bool)
    kernels.decide_meetings(start, positions, found.nodes, found.is_edge_edge, found.toi, meets)
    return found, meets, detector.counts


def _meeting(
    positions_t0: Positions,
    positions_t1: Positions,
    found: Impacts,
    certain: Flags,
    deadline: Deadline,
) -> tuple[Impacts, int]:
    """Return the pairs that meet, by time, and how many pairs exact arithmetic decided."""
    meets, toi = certain.copy(), found.toi.copy()
    undecided = np.flatnonzero(~meets)
    for i in deadline.checked(undecided):
        nodes = found.nodes[i]
        time = first_meeting(found.is_edge_edge[i], positions_t0[nodes], positions_t1[nodes])
        meets[i] = time is not None
        toi[i] = 1.0 if time is None else time
    met = np.flatnonzero(meets)
    in_time = met[np.argsort(toi[met], kind="stable")]
    return found._replace(toi=toi).take(in_time), len(undecided)

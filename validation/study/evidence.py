"""`check` on every step there is, and on results that are deliberately wrong."""

import time

import numpy as np

from izo_ref.app.files import SavedResult
from izo_ref.base.errors import IzoError
from izo_ref.certificate.certify import certify_path
from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from validation.check import check, verdict_summary
from validation.study import steps

THICKNESS_M = 1e-4
# Thickness and time of the peer's results in peers.json: ARCSim 0.2.1, one thread.
PEER = "arcsim_0_2_1"
WRONG_STEP = "sphere-10k"
OWN_WRONG_STEP = "at-rest"  # where there are no step files
PUSHED_M = 1e-9


def step_row(name, say=None) -> dict:
    """`check` of our own result of a step; a row also if the step is refused."""
    try:
        scene = steps.load_step(name)
    except IzoError as error:
        return {"step": name, "refused": f"{type(error).__name__}: {str(error)[:160]}"}
    begin = time.perf_counter()
    own = resolve(scene, THICKNESS_M)
    resolve_s = time.perf_counter() - begin
    result = SavedResult(own.positions, own.thickness, own.impacts, own.multipliers)
    verdict = check(scene, result, THICKNESS_M, say=say, own=own)
    begin = time.perf_counter()
    proposed = certify_path(scene, scene.positions_t1)
    proposed_s = time.perf_counter() - begin
    row = {
        "step": name,
        "triangles": len(scene.faces),
        "status": own.status.name,
        "impacts": len(own.impacts.toi),
        "zones": len(own.zones),
        "objective_m2": own.objective,
        "candidates": own.certificate.candidates,
        "exact": own.certificate.exact,
        "proposal_candidates": proposed.candidates,
        "proposal_meeting": len(proposed.meeting_toi),
        "proposal_exact": proposed.exact,
        "proposal_certify_s": proposed_s,
        "resolve_s": resolve_s - own.timings["certify"] - own.timings["judge"],
        "certify_s": own.timings["certify"],
        "verdict": verdict_summary(verdict),
    }
    peer = steps.peers().get(name, {}).get(PEER, {})
    if "objective_g" in peer:
        row["peer_objective_m2"] = peer["objective_g"]
    return row


def wrong_rows(say=None) -> list[dict]:
    """Results with a fault that `check` has to find."""
    rows = []
    for name, scene, positions in _wrong_results():
        result = SavedResult(positions, None, None, None)
        verdict = check(scene, result, THICKNESS_M, say=say)
        rows.append({"result": name, "verdict": verdict_summary(verdict)})
    return rows


def _wrong_results():
    step = WRONG_STEP if steps.available() else OWN_WRONG_STEP
    scene = steps.load_step(step)
    yield f"{step}: the proposal itself", scene, scene.positions_t1
    own = resolve(scene, THICKNESS_M)
    yield (
        f"{step}: ours, one vertex pushed {PUSHED_M:g} m through a face",
        scene,
        pushed_through(scene, own),
    )
    yield "two layers fully swapped, both ends free", *swapped_layers()


def pushed_through(scene, own):
    """Our result with the free vertex of one impact on the wrong side by a nanometre."""
    impacts = own.impacts
    is_inside = (impacts.weights[:, 1:] < -0.1).all(axis=1) & ~impacts.is_edge_edge
    is_free = ~scene.pinned[impacts.nodes[:, 0]]
    first = np.flatnonzero(is_inside & is_free)[0]
    vertex, *face = impacts.nodes[first]
    positions = own.positions.copy()
    a, b, c = positions[face]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    if normal @ impacts.normals[first] < 0.0:
        normal = -normal
    gap = normal @ (positions[vertex] - a)
    positions[vertex] -= (gap + PUSHED_M) * normal
    return positions


def swapped_layers(n=8):
    """Two rippled sheets, one above the other, that change places; both ends are free.

    Not the same ripples: facets that stay parallel are within ipctk's tolerance all over,
    and each such pair may take all of its iterations.
    """
    x, y = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n), indexing="ij")
    low = np.column_stack(
        (x.ravel(), y.ravel(), 0.01 * (np.sin(9.0 * x) * np.cos(7.0 * y)).ravel())
    )
    high = np.column_stack(
        (x.ravel(), y.ravel(), 0.01 * (np.cos(8.0 * x) * np.sin(5.0 * y)).ravel())
    )
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    faces = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    shift = np.array([0.013, 0.007, 0.1])
    start = np.concatenate((low, high + shift))
    end = np.concatenate((low + 2.0 * shift, high + shift))
    scene = Scene(start, end, np.concatenate((faces, faces + n * n)))
    return scene, end

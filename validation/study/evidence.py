"""Study of evidence: `check` on every step, and on results that are deliberately wrong.

It resolves each step with default options and judges the result by `check`. Then it judges results
that are wrong in a known way, which `check` has to notice. `python -m validation evidence` starts
it.
"""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from izo_ref.app.files import SavedResult
from izo_ref.base.arrays import Positions
from izo_ref.base.errors import IzoError
from izo_ref.certificate.certify import certify_path
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from validation.check import SayFact, check, verdict_summary
from validation.limits import Limits
from validation.study import steps

THICKNESS_M = 1e-4
# Of each judge. Those of the largest steps take minutes.
LIMITS = Limits(seconds=3600.0, bytes=16 << 30)
# The results in peers.json that ours are compared with: ARCSim 0.2.1 on one thread, same thickness.
PEER = "arcsim_0_2_1"
WRONG_STEP = "sphere-10k"
OWN_WRONG_STEP = "at-rest"  # is used if there are no step files
PUSHED_M = 1e-9


def step_row(name: str, say: SayFact | None = None) -> dict[str, Any]:
    """Resolve a step, and judge our own result.

    Args:
        name: Name of the step.
        say: Is called with each fact as soon as it is found.

    Returns:
        A row; if the step is not valid input, it has only the reason.
    """
    try:
        scene = steps.load_step(name)
    except IzoError as error:
        return {"step": name, "refused": f"{type(error).__name__}: {str(error)[:160]}"}
    begin = time.perf_counter()
    own = resolve(scene, THICKNESS_M)
    resolve_s = time.perf_counter() - begin
    result = SavedResult(own.positions, own.thickness, own.impacts, own.multipliers)
    verdict = check(scene, result, THICKNESS_M, say=say, own=own, limits=LIMITS)
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


def wrong_rows(say: SayFact | None = None) -> list[dict[str, Any]]:
    """Judge results with a fault that `check` has to find.

    Args:
        say: Is called with each fact as soon as it is found.

    Returns:
        One row for each result.
    """
    rows = []
    for name, scene, positions in _wrong_results():
        result = SavedResult(positions, None, None, None)
        verdict = check(scene, result, THICKNESS_M, say=say, limits=LIMITS)
        rows.append({"result": name, "verdict": verdict_summary(verdict)})
    return rows


def _wrong_results() -> Iterator[tuple[str, Scene, Positions]]:
    """Yield name, scene and end positions of each wrong result."""
    step = WRONG_STEP if steps.available() else OWN_WRONG_STEP
    scene = steps.load_step(step)
    yield f"{step}: the proposed positions themselves", scene, scene.positions_t1
    own = resolve(scene, THICKNESS_M)
    yield (
        f"{step}: our result with one vertex pushed {PUSHED_M:g} m through a face",
        scene,
        pushed_through(scene, own),
    )
    yield "two layers that swapped places, both ends free", *swapped_layers()


def pushed_through(scene: Scene, own: Result) -> Positions:
    """Move the vertex of one vertex-face impact through its face, by PUSHED_M.

    Args:
        scene: The step.
        own: Our result; it needs an impact of an unpinned vertex inside a face.

    Returns:
        (n, 3) f8 [m], end positions.
    """
    impacts = own.impacts
    is_inside = (impacts.weights[:, 1:] < -0.1).all(axis=1) & ~impacts.is_edge_edge
    is_unpinned = ~scene.pinned[impacts.nodes[:, 0]]
    first = np.flatnonzero(is_inside & is_unpinned)[0]
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


def swapped_layers(n: int = 8) -> tuple[Scene, Positions]:
    """Make two rippled sheets, one above the other, that swap places; both ends are free.

    The two sheets have different ripples. Facets that stay parallel would be within ipctk's
    tolerance everywhere, and each such pair might take all of its iterations.

    Args:
        n: Vertices along a side of a sheet.

    Returns:
        The scene, and (n, 3) f8 [m], its proposed positions.
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

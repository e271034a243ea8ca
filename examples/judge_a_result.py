"""Judge end positions that another program wrote: is the path free, and are the zones optimal?

Without arguments, the other program is a small one at the end of this file. It looks at pairs of
a vertex and a face only, and pushes them apart one by one, as position-based solvers do. Its
answer passes a quick look: every constraint that it knows is satisfied. The judgement finds that
edges still meet, and that the vertices moved farther from the proposed positions than they had to.

Run it from the root of the repository; the files have the arrays that the README lists:

    python examples/judge_a_result.py
    python examples/judge_a_result.py STEP.npz RESULT.npz
"""

import argparse

import numpy as np

import izo_ref

THICKNESS_M = 1e-4


def main(arguments: list[str] | None = None) -> int:
    """Judge the path, then the zones."""
    parser = argparse.ArgumentParser(description="Judge end positions of a step.")
    parser.add_argument("files", nargs="*", metavar="STEP.npz RESULT.npz")
    files = parser.parse_args(arguments).files
    if len(files) not in (0, 2):
        parser.error("expected a step and a result, or nothing")
    if files:
        names = ("positions_t0", "positions_t1", "faces", "masses", "pinned")
        step, result = (dict(np.load(path)) for path in files)
        scene = izo_ref.Scene(**{name: step[name] for name in names if name in step})
    else:
        scene = two_cloths()
        result = other_program(scene)

    judge_path(scene, result["positions"])
    if "multipliers" in result:
        columns = (result[f"impact_{name}"] for name in izo_ref.Impacts._fields)
        judge_zones(scene, izo_ref.Impacts(*columns), result)
    return 0


def judge_path(scene: izo_ref.Scene, positions: np.ndarray) -> None:
    """Print which pairs meet on the straight path to the positions, and when."""
    certificate = izo_ref.certify_path(scene, positions)
    print(f"{certificate.candidates} candidate pairs, {len(certificate.meeting_toi)} of them meet")
    print(f"the path is free until t = {certificate.time_free:.6f}")
    for i in np.argsort(certificate.meeting_toi)[:5]:
        kind = "edge-edge" if certificate.meeting.is_edge_edge[i] else "vertex-face"
        nodes, time = certificate.meeting.nodes[i].tolist(), certificate.meeting_toi[i]
        print(f"  {kind} pair {nodes} meets at t = {time:.6f}")


def judge_zones(scene: izo_ref.Scene, impacts: izo_ref.Impacts, result: dict) -> None:
    """Print the residuals of each zone, and how far at most it is from its optimum."""
    zones = izo_ref.build_zones(scene, impacts)
    thickness = float(result["thickness"])
    print(f"\nzones: {len(zones)}; lengths are root mean squares, weighted by mass")
    print("impacts  violation/thickness  relative gap  correction [m]  distance to optimum [m]")
    for zone in np.argsort(-np.diff(zones.impact_offsets), kind="stable")[:5]:
        own = zones.impacts_of(zone)
        problem = izo_ref.zone_problem(scene, impacts, zones, zone, thickness)
        vertices = np.unique(impacts.nodes[own])  # the vertices of the problem, in its order
        positions, multipliers = result["positions"][vertices], result["multipliers"][own]
        residuals = izo_ref.residuals(problem, positions, multipliers)
        distance = izo_ref.distance_bound(problem, positions, multipliers)
        masses = np.where(scene.pinned[vertices], 0.0, scene.masses[vertices])
        moved = positions - scene.positions_t1[vertices]
        correction = np.sqrt(masses @ (moved**2).sum(axis=1) / masses.sum())
        print(
            f"{len(own):7d}  {residuals.violation:19.1e}  {residuals.gap:12.1e}  "
            f"{correction:14.2e}   at most {distance / np.sqrt(masses.sum()):13.1e}"
        )


def two_cloths() -> izo_ref.Scene:
    """Return a step in which the middle of a cloth is pressed through the cloth below it."""
    n = 14
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(-0.5, 0.5, n))
    x, y = x.ravel(), y.ravel()
    low = np.column_stack((x, y, np.zeros(n * n)))
    high = np.column_stack((0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, np.full(n * n, 0.01)))
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j
    faces = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    start = np.concatenate((low, high))
    end = start.copy()
    end[n * n :, 2] -= 0.03 * np.exp(-20.0 * (x**2 + y**2))
    return izo_ref.Scene(start, end, np.concatenate((faces, faces + n * n)))


def other_program(scene: izo_ref.Scene) -> dict[str, np.ndarray]:
    """Push the vertices out of the faces that they meet; forget the edges."""
    impacts = izo_ref.find_impacts(scene)
    impacts = impacts.take(~impacts.is_edge_edge)
    inverse_masses = np.where(scene.pinned, 0.0, 1.0 / scene.masses)
    positions, multipliers = scene.positions_t1.copy(), np.zeros(len(impacts.toi))
    for _ in range(20):
        for j, nodes in enumerate(impacts.nodes):
            weights, normal = impacts.weights[j], impacts.normals[j]
            missing = THICKNESS_M - normal @ (weights @ positions[nodes])
            push = max(0.0, missing / (weights**2 @ inverse_masses[nodes]))
            positions[nodes] += push * np.outer(weights * inverse_masses[nodes], normal)
            multipliers[j] += push
    columns = {f"impact_{name}": column for name, column in impacts._asdict().items()}
    found = {"positions": positions, "multipliers": multipliers, "thickness": THICKNESS_M}
    return found | columns


if __name__ == "__main__":
    raise SystemExit(main())

"""Call izo_ref at the end of each step of a simulator: a cloth falls onto a moving sphere.

The simulator is small: gravity, springs along the edges, a little damping, and explicit substeps.
It knows nothing of contact. At the end of each step it proposes positions, and `izo_ref.resolve`
finds the closest ones whose path is free. The same correction, divided by the time of the step,
is added to the velocities. The path of each step is certified, so the cloth never goes through
the sphere or through itself. The end of a certified step is a free start: `Scene.after` makes the
next step from it without checking that start again.

Run it from the root of the repository:

    python examples/inside_a_loop.py
"""

import time

import numpy as np
from scipy.spatial import ConvexHull

import izo_ref

STEP_S = 1.0 / 100.0  # of a step that ends with a call of izo_ref
SUBSTEPS = 16  # of the simulator in each step; its springs are stable below 1.4 ms
N_STEPS = 20
GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s^2]
STIFFNESS = 40.0  # [N/m], of each spring
DAMPING = 0.005  # [kg/s], of each spring
THICKNESS_M = 1e-3
SPHERE_SPEED = np.array([0.3, 0.0, 0.5])  # [m/s]


def main() -> int:
    """Simulate, and print a line every five steps."""
    sphere, sphere_faces = make_sphere(0.15, 200)
    cloth, cloth_faces = make_cloth(0.5, 17, height=0.155)
    positions = np.concatenate((sphere, cloth))
    faces = np.concatenate((sphere_faces, cloth_faces + len(sphere)))
    pinned = np.arange(len(positions)) < len(sphere)
    masses = np.full(len(positions), 0.2 * 0.5**2 / len(cloth))  # [kg], 0.2 kg per square metre
    velocities = np.where(pinned[:, None], SPHERE_SPEED, 0.0)

    # A step that goes nowhere: it checks the start, and the first step comes after it.
    scene = izo_ref.Scene(positions, positions, faces, masses, pinned)
    result = izo_ref.resolve(scene, THICKNESS_M)
    springs = scene.edges[scene.edges[:, 0] >= len(sphere)]
    rest_lengths = lengths(positions, springs)

    print("step  status  impacts  detections  correction [mm]  stretch  time [ms]")
    for step in range(1, N_STEPS + 1):
        begin = time.perf_counter()
        proposed = positions
        for _ in range(SUBSTEPS):
            forces = spring_forces(proposed, velocities, springs, rest_lengths)
            accelerations = GRAVITY + forces / masses[:, None]
            velocities[~pinned] += STEP_S / SUBSTEPS * accelerations[~pinned]
            proposed = proposed + STEP_S / SUBSTEPS * velocities

        scene = scene.after(result, proposed)
        result = izo_ref.resolve(scene, THICKNESS_M)
        if not result.certificate.free:
            print(f"step {step}: {result.status.value}")
            return 1
        velocities += (result.positions - proposed) / STEP_S
        positions = result.positions

        if step % 5 == 0:
            stretch = (lengths(positions, springs) / rest_lengths).max()
            print(
                f"{step:4d}  {result.status.name:6s}  {len(result.impacts.toi):7d}"
                f"  {len(result.history):10d}  {1e3 * np.sqrt(result.objective):15.3f}"
                f"  {stretch:7.3f}  {1e3 * (time.perf_counter() - begin):9.1f}"
            )
    print(f"{N_STEPS} steps, each of them certified free")
    return 0


def spring_forces(
    positions: np.ndarray, velocities: np.ndarray, springs: np.ndarray, rest_lengths: np.ndarray
) -> np.ndarray:
    """Return (n, 3) forces of springs and of their damping [N]."""
    a, b = springs.T
    along = positions[b] - positions[a]
    length = np.linalg.norm(along, axis=1)
    along /= length[:, None]
    speed = np.einsum("ij,ij->i", velocities[b] - velocities[a], along)
    pull = (STIFFNESS * (length - rest_lengths) + DAMPING * speed)[:, None] * along
    forces = np.zeros_like(positions)
    np.add.at(forces, a, pull)
    np.add.at(forces, b, -pull)
    return forces


def lengths(positions: np.ndarray, springs: np.ndarray) -> np.ndarray:
    """Return the length of each spring [m]."""
    return np.linalg.norm(positions[springs[:, 1]] - positions[springs[:, 0]], axis=1)


def make_sphere(radius: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and faces of a sphere with n vertices on a spiral."""
    k = np.arange(n) + 0.5
    z, angle = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z**2)
    positions = radius * np.column_stack((r * np.cos(angle), r * np.sin(angle), z))
    return positions, ConvexHull(positions).simplices


def make_cloth(size: float, n: int, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and faces of a flat square with n x n vertices."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, n) * size, np.linspace(-0.5, 0.5, n) * size)
    positions = np.column_stack((x.ravel(), y.ravel(), np.full(n * n, height)))
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j
    return positions, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


if __name__ == "__main__":
    raise SystemExit(main())

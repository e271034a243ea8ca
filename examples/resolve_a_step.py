"""Resolve one time step: build a scene, resolve it, read the result, and write it to a file.

A cloth hangs closely above a hill, and a simulator proposes end positions that go through it.
`izo_ref.resolve` returns the end positions that are closest to the proposed ones and whose
straight path touches nothing.

Run it from the root of the repository, without arguments for the cloth, or with a step file:

    python examples/resolve_a_step.py
    python examples/resolve_a_step.py STEP.npz -o RESULT.npz

`judge_a_result.py` judges the file that this program writes.
"""

import argparse
from pathlib import Path

import numpy as np

import izo_ref


def main(arguments: list[str] | None = None) -> int:
    """Resolve a step, print what was found, and write the result."""
    parser = argparse.ArgumentParser(description="Resolve one time step.")
    parser.add_argument("step", nargs="?", metavar="STEP.npz", help="the cloth if left out")
    parser.add_argument("-o", "--output", default="build/resolved.npz", metavar="RESULT.npz")
    parser.add_argument("--thickness", type=float, metavar="D", help="[m], default: see resolve")
    args = parser.parse_args(arguments)

    scene = read_step(args.step) if args.step else cloth_above_a_hill()
    print(f"{len(scene.positions_t0)} vertices, {len(scene.faces)} triangles")
    print(f"{len(izo_ref.find_impacts(scene).toi)} pairs meet on the proposed path")

    result = izo_ref.resolve(scene, thickness=args.thickness)

    print(f"\n{result.status.name}: {result.status.value}")
    print(f"objective: {result.objective:.4e} m^2 (mean squared correction, weighted by mass)")
    print(f"thickness: {result.thickness:.3g} m")
    print(f"detections: {len(result.history)}, time: {result.timings['total']:.2f} s")

    # Each zone is an optimisation problem of its own. Its residuals are computed from the
    # positions and multipliers alone, outside the solver.
    sizes = np.diff(result.zones.impact_offsets)
    print(f"\n{len(sizes)} zones, the largest:\nimpacts   violation [m]   relative duality gap")
    for zone in np.argsort(-sizes, kind="stable")[:5]:
        residuals = result.residuals[zone]
        print(f"{sizes[zone]:7d}   {residuals.violation_m:13.1e}   {residuals.gap:20.1e}")

    # The certificate is a new detection over all pairs of the path that is returned.
    certificate = result.certificate
    meeting = len(certificate.meeting_toi)
    print(f"\ncertificate: the path is free until t = {certificate.time_free:.6f}")
    print(f"  {certificate.candidates} candidate pairs, {meeting} of them meet")
    print(f"  {certificate.exact} pairs needed exact arithmetic")

    write_result(Path(args.output), result)
    print(f"\nresult: {args.output}")
    return 0 if certificate.free else 1


def read_step(path: str) -> izo_ref.Scene:
    """Read a step from a file; masses and pinned may be missing there."""
    names = ("positions_t0", "positions_t1", "faces", "masses", "pinned")
    with np.load(path) as arrays:
        return izo_ref.Scene(**{name: arrays[name] for name in names if name in arrays})


def cloth_above_a_hill() -> izo_ref.Scene:
    """Return a step in which a square cloth falls onto a pinned hill."""
    hill, hill_faces = grid(21)
    hill[:, 2] = 0.2 * np.exp(-12.0 * (hill[:, 0] ** 2 + hill[:, 1] ** 2))
    cloth, cloth_faces = grid(26)
    cloth = 0.7 * cloth + [0.0, 0.0, 0.21]
    start = np.concatenate((hill, cloth))
    pinned = np.arange(len(start)) < len(hill)  # pinned vertices follow their path exactly
    end = start.copy()
    end[~pinned, 2] -= 0.06
    masses = np.full(len(start), 0.2 * 0.7**2 / len(cloth))  # 0.2 kg per square metre
    faces = np.concatenate((hill_faces, cloth_faces + len(hill)))
    return izo_ref.Scene(start, end, faces, masses, pinned)


def grid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and faces of a flat square of side 1 with n x n vertices."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(-0.5, 0.5, n))
    positions = np.column_stack((x.ravel(), y.ravel(), np.zeros(n * n)))
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j
    return positions, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def write_result(path: Path, result: izo_ref.Result) -> None:
    """Write positions, and the impacts and multipliers with which the zones can be judged."""
    impacts = {f"impact_{name}": column for name, column in result.impacts._asdict().items()}
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        path,
        positions=result.positions,
        thickness=result.thickness,
        multipliers=result.multipliers,
        **impacts,
    )


if __name__ == "__main__":
    raise SystemExit(main())

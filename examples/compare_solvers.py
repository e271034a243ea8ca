"""Compare solvers on one zone: every method, every line search, and the presets.

The zone comes from two cloths that are pressed through each other, with light and heavy
vertices. A table shows what each solver says and what is true, in separate columns:

    solved   the solver stopped by its own rules, before the limit of steps
    correct  the answer is at most 1e-6 of the correction away from the optimum

A solver can stop far from the optimum, and a solver that reaches its limit can be close to it.
The distance is an upper bound: the distance to a reference answer, plus the proved bound on the
distance of the reference to the optimum, as a fraction of the correction. The gap is relative to
the objective, and the violation to the thickness.

Run it from the root of the repository:

    python examples/compare_solvers.py
"""

import time

import numpy as np

import izo_ref

MAX_STEPS = 5_000
PRESET_STEPS = 100  # the limit of the systems whose parameters the presets have
TOLERANCE = 1e-9  # asked for: relative duality gap, and violation over the thickness
CORRECT = 1e-6  # distance to the optimum, relative to the correction
THICKNESS_M = 1e-3

DIRECT = ("auto", "active-set", "interior-point", "pgs", "apgs")
DIRECTIONS = ("gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
LINE_SEARCHES = ("exact", "backtracking", "wolfe")
PRESETS = ("arcsim", "icloth", "xrtailor")
NO_YES = ("no", "yes")


def main() -> int:
    """Solve the zone with each solver and print the table."""
    problem = zone_of_two_cloths()
    print(f"a zone of {len(problem.nodes)} impacts and {len(problem.masses)} vertices")

    reference = izo_ref.solve_zone(problem, tolerance=1e-12)
    bound = izo_ref.distance_bound(
        problem, reference.positions, reference.multipliers, reference.displacements
    )
    correction = mass_norm(problem, reference.displacements)
    print(f"the reference is at most {bound / correction:.0e} of the correction off the optimum\n")

    print(
        "method          line search   steps   time [ms]      gap  violation  distance  "
        "solved  correct"
    )
    for name, keywords in solvers():
        izo_ref.solve_zone(problem, **keywords)  # the first call compiles and is not timed
        begin = time.perf_counter()
        solution = izo_ref.solve_zone(problem, **keywords)
        milliseconds = 1e3 * (time.perf_counter() - begin)
        limit = PRESET_STEPS if "preset" in keywords else MAX_STEPS
        solved = solution.feasible and solution.iterations < limit
        off = mass_norm(problem, solution.displacements - reference.displacements) + bound
        residuals = solution.residuals
        print(
            f"{name:15s} {keywords.get('line_search', '-'):12s} {solution.iterations:6d}"
            f"  {milliseconds:10.2f}  {residuals.gap:7.0e}  {residuals.violation:9.0e}"
            f"  {off / correction:8.0e}  {NO_YES[solved]:6s}  {NO_YES[off <= CORRECT * correction]}"
        )
    return 0


def solvers() -> list[tuple[str, dict]]:
    """Return a name and the keywords of `solve_zone` for each solver."""
    common = {"tolerance": TOLERANCE, "max_steps": MAX_STEPS}
    listed = [(method, {"method": method} | common) for method in DIRECT]
    for method in DIRECTIONS:
        for search in LINE_SEARCHES:
            listed.append((method, {"method": method, "line_search": search} | common))
    return listed + [(f"preset {name}", {"preset": name} | common) for name in PRESETS]


def zone_of_two_cloths() -> izo_ref.ZoneProblem:
    """Return the largest zone of a step in which two cloths are pressed through each other."""
    n = 18
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
    masses = 10.0 ** np.random.default_rng(1).uniform(-3.0, 1.0, len(start))  # [kg]
    scene = izo_ref.Scene(start, end, np.concatenate((faces, faces + n * n)), masses)
    # This selection takes more impacts than the default, so the constraints are nearly dependent.
    options = izo_ref.Options(selection="first-of-any")
    result = izo_ref.resolve(scene, THICKNESS_M, options=options)
    largest = int(np.argmax(np.diff(result.zones.impact_offsets)))
    return izo_ref.zone_problem(scene, result.impacts, result.zones, largest, THICKNESS_M)


def mass_norm(problem: izo_ref.ZoneProblem, vectors: np.ndarray) -> float:
    """Return sqrt(sum m |v|^2) in m kg^1/2; no vertex of this zone is pinned."""
    return float(np.sqrt((problem.masses[:, None] * vectors**2).sum()))


if __name__ == "__main__":
    raise SystemExit(main())

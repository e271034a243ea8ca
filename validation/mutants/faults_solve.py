"""Faults of the solvers and of the residuals that judge them."""

from validation.mutants.fault import CPU_SIMULATOR, ELSEWHERE, Fault

SOLVE = "tests/test_solve.py"
RESIDUALS = "tests/test_problem.py"
CAUGHT = "tests/test_caught.py"
EVERY_SET = "tests/test_solve.py::test_against_every_active_set"
CERTIFIED = "tests/test_solve.py::test_random_zones_are_certified"
THREADS = "tests/test_resolve.py::test_same_bits_with_one_thread_and_with_two"

SOLVERS = [
    Fault(
        "multipliers-not-clamped",
        "izo_ref/serial/lagrangian.py",
        "        zone.multipliers[j] = max(pushed, 0.0)\n",
        "        zone.multipliers[j] = pushed\n",
        "rows that are satisfied pull, as eq. 9 reads without its slack",
        ("tests/test_lagrangian.py",),
        ELSEWHERE,
    ),
    Fault(
        "multipliers-in-scaled-variables",
        "izo_ref/solve.py",
        "        scaled / rows.lengths,\n",
        "        scaled,\n",
        "multipliers are returned as the scaled variables have them",
        ("tests/test_solve.py::test_one_impact_has_a_closed_form",),
    ),
    Fault(
        "line-search-accepts-an-increase",
        "izo_ref/serial/line_search.py",
        "        enough = change < settings.armijo * step * slope\n",
        "        enough = change < -settings.armijo * step * slope\n",
        "the line search takes steps that increase the function",
        ("tests/test_line_search.py",),
        ELSEWHERE,
        240.0,
    ),
    Fault(
        "unsynchronised-sum-on-a-vertex",
        "izo_ref/serial/lagrangian.py",
        "                zone.gradient[i] -= pull * zone.normals[j, 0]\n",
        "                own = zone.curvatures[i] * zone.x[i]\n"
        "                zone.gradient[i] = own - pull * zone.normals[j, 0]\n",
        "of the impacts that push one vertex only the last counts, as in a race without atomics",
        ("tests/test_lagrangian.py",),
        ELSEWHERE,
    ),
    Fault(
        "status-in-a-shared-place",
        "izo_ref/cpu/advance.py",
        "        statuses_out[i] = status\n",
        "        statuses_out[i // 2 * 2] = status\n",
        "two pairs write their status to the same place: the later thread wins",
        ("tests/test_detect.py::test_frames_of_impacts", "tests/test_certify.py"),
        ELSEWHERE,
    ),
    Fault(
        "each-thread-sorts-its-part",
        "izo_ref/selection.py",
        '        np.argsort(impacts.toi, kind="stable"),\n',
        "        np.concatenate(\n            [\n"
        '                part[np.argsort(impacts.toi[part], kind="stable")]\n'
        "                for part in np.array_split(\n"
        "                    np.arange(len(impacts.toi)),\n"
        '                    __import__("numba").get_num_threads(),\n'
        "                )\n            ]\n        ),\n",
        "each thread sorts its part of the impacts, and nobody merges them",
        (THREADS,),
    ),
    Fault(
        "rows-never-dropped",
        "izo_ref/serial/active_set.py",
        "            step, place = _blocking(active, q, u, r)\n",
        "            step, place = _blocking(active, q, u, r)\n"
        "            step = step if full == np.inf else full\n",
        "rows whose multiplier becomes negative stay in the active set",
        (CERTIFIED,),
    ),
    Fault(
        "factor-not-updated-on-drop",
        "izo_ref/serial/active_set.py",
        "            factor[k, i + 1] = c * b - s * a\n",
        "            factor[k, i + 1] = c * b + s * a\n",
        "the Cholesky factor is wrong after a row left",
        (CERTIFIED, SOLVE),
    ),
    Fault(
        "guess-with-negative-multipliers",
        "izo_ref/serial/active_set.py",
        "            if r[k] <= 0.0 and (worst < 0 or r[k] < r[worst]):\n",
        "            if r[k] <= -1e30 and (worst < 0 or r[k] < r[worst]):\n",
        "the active set starts from rows that pull",
        ("tests/test_block_pivot.py",),
    ),
    Fault(
        "block-pivot-believes-itself",
        "izo_ref/serial/block_pivot.py",
        "    return (SOLVED if holds else NOT_CONVERGED), factorizations\n",
        "    return SOLVED, factorizations\n",
        "block pivoting does not look whether rows hold where they are nearly dependent",
        ("tests/test_block_pivot.py",),
    ),
    Fault(
        "gram-of-coefficients-only",
        "izo_ref/serial/block_pivot.py",
        "                gram[i, j] += own * coefficients[j, entry & 3] * cosine\n",
        "                gram[i, j] += own * coefficients[j, entry & 3]\n",
        "the Gram matrix forgets the angle between normals",
        ("tests/test_block_pivot.py", CERTIFIED),
    ),
    Fault(
        "last-pivots-not-updated",
        "izo_ref/serial/dense.py",
        "            for q in range(k, k + width):\n",
        "            for q in range(k, k + width - 1):\n",
        "of the last pivots, fewer than four, one does not reach the rows below",
        ("tests/test_dense.py",),
    ),
    Fault(
        "fronts-forget-what-is-below",
        "izo_ref/serial/fronts.py",
        "    for c in range(fronts.child_starts[s + 1] - 1, fronts.child_starts[s] - 1, -1):\n",
        "    for c in range(fronts.child_starts[s + 1] - 1, fronts.child_starts[s], -1):\n",
        "of the fronts below a front, the first is not added to it",
        ("tests/test_sparse.py",),
    ),
    Fault(
        "sweeps-without-bound",
        "izo_ref/serial/sweeps.py",
        "            step = max(missing / diagonal[j], -u[j])\n",
        "            step = missing / diagonal[j]\n",
        "multipliers become negative: rows pull",
        ("tests/test_sweeps.py",),
    ),
    Fault(
        "interior-point-stops-early",
        "izo_ref/interior_point.py",
        "        if error < ENOUGH or iteration > best[3] + 5:\n",
        "        if error < 1e6 or iteration > best[3] + 5:\n",
        "the interior point stops far from the tolerance and claims success",
        (CERTIFIED,),
    ),
    Fault(
        "interior-point-always-feasible",
        "izo_ref/interior_point.py",
        "        if _dot(multipliers, s) > FARTHEST * _dot(pull, pull) ** 0.5:\n"
        "            return z * scale, multipliers * scale, iteration, False\n",
        "        if _dot(multipliers, s) > FARTHEST * _dot(pull, pull) ** 0.5:\n"
        "            return z * scale, multipliers * scale, iteration, True\n",
        "a zone that nothing satisfies counts as solved",
        ("tests/test_solve.py::test_what_nothing_satisfies_is_said_to_be_infeasible",),
    ),
    Fault(
        "gap-with-signed-slack",
        "izo_ref/problem.py",
        "    products = float(np.sum(clamped * np.abs(slack)))\n",
        "    products = float(np.sum(clamped * slack))\n",
        "in the duality gap a violation hides what is missing elsewhere",
        (RESIDUALS, CAUGHT),
    ),
    Fault(
        "violation-of-pushing-rows-only",
        "izo_ref/problem.py",
        "    violation = max(0.0, float(np.max(-slack, initial=0.0)))\n",
        "    violation = max(0.0, float(np.max(-slack[clamped > 0.0], initial=0.0)))\n",
        "rows without multiplier may be violated as far as they like",
        (RESIDUALS,),
    ),
    Fault(
        "violation-in-metres",
        "izo_ref/problem.py",
        "        violation=violation / problem.thickness,\n",
        "        violation=violation,\n",
        "the violation is compared in metres, not over the thickness",
        (RESIDUALS,),
        CPU_SIMULATOR,
    ),
    Fault(
        "absolute-solver-tolerance",
        "izo_ref/interior_point.py",
        " max(relative_gap / gap_tolerance, violation * scale / violation_tolerance)\n",
        " max(gap, violation) * scale / 1e-6\n",
        "the interior point is content with 1e-6, whatever the unit",
        ("tests/test_solve.py::test_units_do_not_matter",),
        CPU_SIMULATOR,
    ),
    Fault(
        "negative-multipliers-unseen",
        "izo_ref/problem.py",
        "    negative = max(0.0, float(np.max(-multipliers, initial=0.0)))\n",
        "    negative = max(0.0, float(np.max(-clamped, initial=0.0)))\n",
        "the residuals look for negative multipliers after clamping them",
        (RESIDUALS,),
    ),
    Fault(
        "objective-of-half",
        "izo_ref/loop.py",
        "    return float((masses * (offsets**2).sum(axis=1)).sum() / masses.sum())\n",
        "    return float(0.5 * (masses * (offsets**2).sum(axis=1)).sum() / masses.sum())\n",
        "the objective is off by a factor of two",
        ("tests/test_resolve.py::test_one_vertex_by_hand",),
    ),
    Fault(
        "objective-not-over-masses",
        "izo_ref/loop.py",
        "    return float((masses * (offsets**2).sum(axis=1)).sum() / masses.sum())\n",
        "    return float((masses * (offsets**2).sum(axis=1)).sum() / len(masses))\n",
        "the objective is divided by the number of vertices, not by their mass",
        (CAUGHT,),
    ),
    Fault(
        "bound-without-across",
        "izo_ref/distance.py",
        "    return _rounded_up(_norm(across) + 2.0 * beyond + along)\n",
        "    return _rounded_up(2.0 * beyond + along)\n",
        "the bound on the distance forgets the part across the active rows",
        ("tests/test_distance.py",),
    ),
    Fault(
        "bound-believes-moved-obstacles",
        "izo_ref/distance.py",
        "    if displacements[np.isinf(problem.masses)].any() or ",
        "    if ",
        "the bound on the distance takes pinned vertices where the result put them",
        ("tests/test_distance.py",),
    ),
    Fault(
        "bound-without-rounding",
        "izo_ref/distance.py",
        "        error += 10 * U * terms + (1.0 + 1e-9) * sums * first + 2 * U * np.abs(total)\n",
        "        error += 0.0 * (terms + sums * first)\n",
        "the bound on the distance forgets the rounding of slacks",
        ("tests/test_distance.py", CAUGHT),
    ),
]

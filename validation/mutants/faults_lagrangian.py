"""Faults of the augmented-Lagrangian methods: directions, line searches, loop, presets."""

from validation.mutants.fault import (
    ELSEWHERE,
    NOT_ASKED,
    ON_GPU,
    Fault,
)

DIRECTIONS = "tests/solvers/test_directions.py"
SEARCHES = "tests/solvers/test_line_search.py"
METHODS = "tests/solvers/test_presets.py"
LOOP = "tests/solvers/test_augmented_lagrangian.py"

LAGRANGIAN = [
    Fault(
        "wolfe-slope-in-between",
        "izo_ref/solvers/serial/line_search.py",
        "            if not too_far and rise >= -wanted:\n",
        "            between = along_line(zone, penalty, slope, curvature, 0.3 * step)[1]\n"
        "            if exact and not too_far and rise >= -wanted:\n"
        "                return step, change\n"
        "            if not exact and enough and abs(between) <= wanted:\n",
        "The curvature condition takes the gradient between the ends, as the page has it.",
        (SEARCHES,),
        ELSEWHERE,
        flag="wolfe-gradient",
    ),
    Fault(
        "newton-with-all-rows",
        "izo_ref/solvers/serial/directions/newton.py",
        "        if zone.pushed[j] > 0:\n",
        "        if zone.coefficients[j, 0] == zone.coefficients[j, 0]:\n",
        "The generalised Hessian includes constraints that are not active.",
        (DIRECTIONS,),
        flag="newton-active-set",
    ),
    Fault(
        "no-wait-for-the-rows",
        "izo_ref/solvers/serial/directions/newton.py",
        "    group.wait()\n    for vertex",
        "    for vertex",
        "Vertices gather from constraints that other threads have not computed yet.",
        ("tests/cuda/test_simulator.py",),
        flag="gpu-only",
        not_by_vectors=ON_GPU,
    ),
    Fault(
        "sums-of-the-first-warp",
        "izo_ref/base/cuda/thread_group.py",
        "        for part in range(at, results, 3 * WARP):\n            a += shared[part]\n",
        "        for part in range(at, at + 3, 3 * WARP):\n            a += shared[part]\n",
        "In a block with more threads than a warp, only the first threads are summed.",
        ("tests/cuda/test_simulator.py",),
        flag="gpu-only",
        not_by_vectors=ON_GPU,
    ),
    Fault(
        "each-block-for-itself",
        "izo_ref/base/cuda/thread_group.py",
        "    for k in range(cuda.threadIdx.x, cuda.gridDim.x, cuda.blockDim.x):\n"
        "        a += parts",
        "    for k in range(cuda.blockIdx.x, cuda.blockIdx.x + 1):\n        a += parts",
        "In a zone that all blocks solve together, each block sums only its own threads.",
        ("tests/cuda/test_simulator.py",),
        flag="gpu-only",
        not_by_vectors=ON_GPU,
    ),
    Fault(
        "ends-in-the-loops-order",
        "izo_ref/loop/gpu_step.py",
        "put_rows(order, self.positions, positions)",
        "put_rows(to_gpu(np.arange(len(positions))), self.positions, positions)",
        "Positions on the GPU are returned in the order that the loop uses.",
        ("tests/cuda/test_simulator.py",),
        flag="gpu-only",
        not_by_vectors=ON_GPU,
    ),
    Fault(
        "lbfgs-oldest-pair-first",
        "izo_ref/solvers/serial/directions/lbfgs.py",
        "    for pair in range(stored - 1, oldest - 1, -1):\n",
        "    for pair in range(oldest, stored):\n",
        "The first loop of the recursion goes from the oldest pair to the newest.",
        (DIRECTIONS,),
        flag="lbfgs-order",
    ),
    Fault(
        "omega-not-squared",
        "izo_ref/solvers/serial/directions/chebyshev.py",
        "    return 4.0 / (4.0 - rho * rho * omega)\n",
        "    return 4.0 / (4.0 - rho * omega)\n",
        "Chebyshev's recursion takes rho instead of its square.",
        (DIRECTIONS, METHODS),
        flag="chebyshev-omega",
    ),
    Fault(
        "cg-keeps-the-gradient-of-old-multipliers",
        "izo_ref/solvers/serial/descent.py",
        "            if has_memory and not idle:\n                remember_step(zone, settings)\n",
        "",
        "The previous gradient is used as the change of the gradient, so beta and the stored "
        "pairs are wrong.",
        (LOOP, METHODS),
        flag="cg-beta",
    ),
    Fault(
        "stops-on-violation-alone",
        "izo_ref/solvers/serial/stopping.py",
        "    gap = 0.5 * measures.error + measures.products\n",
        "    gap = 0.0\n",
        "A zone whose constraints hold counts as solved, however far it is from the optimum.",
        (LOOP,),
        flag="early-stop",
        not_by_vectors=NOT_ASKED,
    ),
    Fault(
        "trace-in-scaled-units",
        "izo_ref/solvers/serial/descent.py",
        "        trace_out[iteration - 1, 0] = unit * measures.objective\n",
        "        trace_out[iteration - 1, 0] = measures.objective\n",
        "The trace has the objective of the scaled variables.",
        (LOOP,),
        flag="preset-scaling",
    ),
    Fault(
        "preset-in-own-scaling",
        "izo_ref/solvers/variables.py",
        "        scale = np.add.reduceat(1.0 / unpinned_masses, begin) / per_vertex\n",
        "        scale = per_vertex / np.add.reduceat(unpinned_masses, begin)\n",
        "A preset divides its objective by the mean mass instead of multiplying it by the mean "
        "inverse mass.",
        (METHODS,),
        flag="preset-scaling",
    ),
]

"""The augmented-Lagrangian methods on the GPU, compared with those on the CPU."""

import numpy as np
import pytest
from numba import cuda

import izo_ref
from izo_ref import Options
from izo_ref.base.cuda import thread_group as group
from izo_ref.base.errors import DeviceUnavailableError
from izo_ref.base.serial.thread_group import group_maxima, group_sum, group_sums
from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian
from izo_ref.solvers.cuda import lagrangian as kernels
from izo_ref.solvers.presets import METHOD_PARAMETERS, PRESETS
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.system import problem_system
from tests.helpers.grids import blocks_together
from tests.helpers.shapes import random_problem

# In compiled code, x / 0 is inf without a warning; in the simulator numpy warns.
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


def blocks_of(monkeypatch, n_threads, warp):
    """Make all blocks have `n_threads` threads, in warps of `warp` threads."""
    monkeypatch.setattr(lagrangian, "FEW", n_threads)
    monkeypatch.setattr(lagrangian, "MANY", n_threads)
    monkeypatch.setattr(group, "WARP", warp)


def violated_problem(rng, n_impacts):
    """Draw a zone until one of its constraints is violated, so that there is something to solve."""
    while True:
        problem = random_problem(rng, n_impacts, mass_ratio=1e3)
        if problem.gaps(problem.proposed).min() < 0.0:
            return problem


# (threads of a block, threads of a warp): one thread; a block within one warp; a block of more
# threads than a warp, whose first threads add several parts each
BLOCKS = [(1, 2), (3, 4), (5, 2)]


def sums_and_maxima(group, values, out):
    """Write the sums and maxima that this thread gets from its group."""
    k = group.rank()
    for _ in range(3):  # other threads may still read the memory of the round before
        a, b, c = group_sums(group, values[k, 0], values[k, 1], values[k, 2])
        d, e = group_maxima(group, values[k, 0], values[k, 1])
        f = group_sum(group, values[k, 2])
    out[k] = a, b, c, d, e, f


@pytest.mark.parametrize("n_blocks", [None, 1, 2, 7])
@pytest.mark.parametrize(("n_threads", "warp"), BLOCKS)
def test_all_threads_of_a_group_get_the_same_sums(rng, monkeypatch, n_threads, warp, n_blocks):
    monkeypatch.setattr(group, "WARP", warp)
    n = n_threads * (n_blocks or 1)
    values, out = rng.normal(size=(n, 3)), np.empty((n, 6))
    parts = np.zeros((n_blocks or 1, group.PARTS))

    @cuda.jit
    def kernel(values, parts, out):
        who = group.block() if n_blocks is None else group.grid(parts)
        sums_and_maxima(who, values, out)

    with blocks_together(kernel.py_func):
        kernel[n_blocks or 1, n_threads, 0, group.shared_bytes(n_threads)](values, parts, out)
    sums, largest = values.sum(axis=0), values.max(axis=0)
    for row in out:
        assert np.array_equal(row, out[0])
    # Both sums of n terms are rounded.
    bound = 2.0 * n * 2.0**-53 * np.abs(values).sum(axis=0)
    assert (np.abs(out[0, :3] - sums) <= bound).all()
    assert np.array_equal(out[0, 3:5], largest[:2])
    assert out[0, 5] == out[0, 2]


@pytest.mark.parametrize(("n_threads", "warp"), BLOCKS)
@pytest.mark.parametrize("method", METHOD_PARAMETERS)
def test_zones_solved_by_one_block_each_are_those_of_the_cpu(
    rng, monkeypatch, method, n_threads, warp
):
    blocks_of(monkeypatch, n_threads, warp)
    problems = [violated_problem(rng, n) for n in (1, 2, 4)]
    options = Options(method=method, max_steps=30)
    system, _ = problem_system(problems)
    found = solve_system(system, options, device="cuda")
    expected = solve_system(system, options)
    assert expected.iterations.max() > 2
    assert np.array_equal(found.iterations, expected.iterations)
    assert np.array_equal(found.methods, expected.methods)
    # The GPU sums in another order: a few roundings in each of at most 30 steps.
    size = np.abs(expected.displacements).max()
    np.testing.assert_allclose(
        found.displacements, expected.displacements, rtol=0.0, atol=1e-13 * size
    )
    if n_threads == 1:
        assert np.array_equal(found.positions, expected.positions)
        assert np.array_equal(found.multipliers, expected.multipliers)


@pytest.mark.parametrize("n_blocks", [1, 3])
@pytest.mark.parametrize("method", METHOD_PARAMETERS)
def test_large_zones_solved_by_several_blocks_are_those_of_the_cpu(
    rng, monkeypatch, method, n_blocks
):
    blocks_of(monkeypatch, 2, 2)
    monkeypatch.setattr(lagrangian, "LARGE", 1)
    monkeypatch.setattr(lagrangian, "count_resident_blocks", lambda: n_blocks)
    problems = [violated_problem(rng, n) for n in (3, 1, 2)]
    options = Options(method=method, max_steps=8)
    system, _ = problem_system(problems)
    with blocks_together(kernels.solve_lagrangian_by_grid.function):
        found = solve_system(system, options, device="cuda")
    expected = solve_system(system, options)
    assert expected.iterations.max() > 2
    assert np.array_equal(found.iterations, expected.iterations)
    size = np.abs(expected.displacements).max()
    np.testing.assert_allclose(
        found.displacements, expected.displacements, rtol=0.0, atol=1e-13 * size
    )


@pytest.mark.parametrize("method", METHOD_PARAMETERS)
def test_float32_solves_to_a_loose_tolerance(rng, monkeypatch, method):
    blocks_of(monkeypatch, 3, 2)
    problem = random_problem(rng, 3)
    options = {"method": method, "precision": "float32", "max_steps": 300, "tolerance": 1e-4}
    found = izo_ref.solve_zone(problem, device="cuda", **options)
    assert found.residuals.solved(1e-4, 1e-3)


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_have_the_trace_of_the_cpu(rng, monkeypatch, preset):
    blocks_of(monkeypatch, 1, 32)
    problem = random_problem(rng, 3)
    found = izo_ref.solve_zone(problem, preset=preset, max_steps=5, trace=True, device="cuda")
    expected = izo_ref.solve_zone(problem, preset=preset, max_steps=5, trace=True)
    assert len(expected.trace) > 0
    assert np.array_equal(found.trace, expected.trace)


def test_methods_of_the_cpu_alone_are_refused_on_a_gpu(rng):
    with pytest.raises(DeviceUnavailableError, match="'interior-point' runs on the CPU only"):
        izo_ref.solve_zone(random_problem(rng, 2), "interior-point", device="cuda")

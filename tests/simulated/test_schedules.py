"""Kernels that wait or use shared memory have no conflicts, in random schedules of their threads.

`tests/house/test_schedules.py` fails if such a kernel is missing in RUNS.
"""

import numpy as np
import pytest

from izo_ref import Options, find_impacts, resolve
from izo_ref.base.cuda import thread_group as group
from izo_ref.base.cuda.compile import Kernel
from izo_ref.base.gpu_arrays import empty, to_cpu, to_gpu
from izo_ref.base.serial.thread_group import group_add, group_maxima, group_sum, group_sums
from izo_ref.solvers import gpu_pivoting as pivoting
from izo_ref.solvers import gpu_solve as solve
from tests.helpers.kernel_log import KernelLog
from tests.helpers.shapes import falling_sheet, two_sheets

# In compiled code, x / 0 is inf without a warning; in the simulator numpy warns.
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
THREADS = 5  # of a block: more than the 2 of a warp below, and no multiple
SCHEDULES = 3


@pytest.fixture(params=range(SCHEDULES))
def log(request, rng):
    """Return a log with a schedule of its own; its seed is printed."""
    seed = int(rng.integers(2**31)) + request.param
    print(f"seed of the schedule: {seed}")
    return KernelLog(seed)


@pytest.fixture(autouse=True)
def small_warps(monkeypatch):
    """Let two threads be a warp, so that a block of few threads has several."""
    monkeypatch.setattr(group, "WARP", 2)


def add_and_combine(values, parts, counts_out, sums_out):
    """Let the threads of the grid, or of a block, sum, find maxima, and count."""
    own = group.block() if parts.shape[0] == 0 else group.grid(parts)
    k = own.rank()
    for _ in range(2):  # other threads may still read the memory of the sum before
        a, b, c = group_sums(own, values[k, 0], values[k, 1], values[k, 2])
        d, e = group_maxima(own, values[k, 0], values[k, 1])
    group_add(own, counts_out, 0, 1)
    own.wait()
    sums_out[k, 3], sums_out[k, 4], sums_out[k, 5] = d, e, counts_out[0]
    sums_out[k, 0], sums_out[k, 1], sums_out[k, 2] = a, b, group_sum(own, c)


def combined(log, values, n_blocks):
    """Run `add_and_combine` on one block alone (None), or on the blocks of a grid."""
    parts = to_gpu(np.zeros((n_blocks or 0, group.PARTS)))
    counts, sums = to_gpu(np.zeros(1, np.int64)), empty((len(values), 6), np.float64)
    n_bytes = group.shared_bytes(THREADS)
    own = to_gpu(values), parts, counts, sums
    launch = Kernel(add_and_combine).prepare(n_blocks or 1, THREADS, *own, shared_bytes=n_bytes)
    with log.running():
        launch()
    return to_cpu(sums)


@pytest.mark.parametrize("n_blocks", [None, 1, 3])
def test_sums_of_a_group_have_no_conflicts(rng, log, n_blocks):
    n = THREADS * (n_blocks or 1)
    values = rng.normal(size=(n, 3))
    found = combined(log, values, n_blocks)
    assert log.conflicts() == 0
    assert (found == found[0])[:, [0, 1, 3, 4, 5]].all(), "all threads get the same"
    # both sums of n terms are rounded
    bound = 2.0 * n * 2.0**-53 * np.abs(values).sum(axis=0)
    assert (np.abs(found[0, :2] - values.sum(axis=0)[:2]) <= bound[:2]).all()
    assert np.array_equal(found[0, 3:], [*values.max(axis=0)[:2], n])


@pytest.mark.parametrize("n_blocks", [None, 3])
def test_no_wait_of_the_sums_can_be_left_out(rng, n_blocks):
    log = KernelLog(1)
    combined(log, rng.normal(size=(THREADS * (n_blocks or 1), 3)), n_blocks)
    assert len(log.sites) >= 5
    assert log.needless_waits() == []


def test_the_order_of_the_threads_is_that_of_the_seed(rng):
    values, logs = rng.normal(size=(THREADS, 3)), [KernelLog(seed) for seed in (7, 7, 8)]
    for log in logs:
        combined(log, values, None)
    orders = [[thread for thread, *_ in log.launches[0]] for log in logs]
    assert orders[0] == orders[1]
    assert orders[0] != orders[2]


def writes_too_early(values, values_out):
    """Write what the next thread still reads."""
    k = group.block().rank()
    values_out[k] = values[(k + 1) % values.shape[0]]
    values[k] = 0


def test_a_missing_wait_is_noticed():
    values = to_gpu(np.arange(THREADS))
    log = KernelLog(1)
    with log.running():
        Kernel(writes_too_early)[THREADS](values, empty(THREADS, np.int64))
    assert log.conflicts() == THREADS


def waits_apart(flags):
    """Let half of the threads of a grid wait for its blocks, and the others for their block."""
    if flags[group.grid(None).rank()]:
        group.grid(None).wait()
    else:
        group.block().wait()


def test_threads_that_wait_for_ever_are_noticed():
    flags = to_gpu(np.arange(4) < 2)
    with KernelLog(1).running(), pytest.raises(RuntimeError, match="wait for ever"):
        Kernel(waits_apart).prepare(2, 2, flags)()


def step_by_blocks(rng):
    """Resolve a step whose zones are solved by one block each."""
    resolve(falling_sheet(3, 20.0, n=2), 1e-3, "cuda", Options(relinearize=0, max_iterations=1))


def detect(rng):
    """Find the impacts of a path, and compare them with those of the CPU."""
    scene = two_sheets(rng, 2)
    found, expected = find_impacts(scene, "cuda"), find_impacts(scene)
    assert len(expected.toi) > 0
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(own, other)


# Of each kernel that waits, uses shared memory, or uses its thread group itself: what runs it.
RUNS = {
    "detection.tree.list_pairs": detect,
    "detection.contacts.list_contacts": detect,
    "solvers.listed_zones.solve_list_in_blocks": step_by_blocks,
}


@pytest.mark.parametrize("name", RUNS)
def test_kernels_have_no_conflicts(rng, monkeypatch, log, name):
    monkeypatch.setattr(solve, "SMALL", 1)
    monkeypatch.setattr(pivoting, "THREADS", 3)
    stage, file, kernel = name.split(".")
    own = f"izo_ref.{stage}.cuda.{file}", kernel
    with log.running(only=own):
        RUNS[name](rng)
    assert own in log.kernels, f"nothing runs {name}"
    assert log.conflicts() == 0

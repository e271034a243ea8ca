"""The threads of a block, or of all blocks of a launch, as a thread group.

`base/serial/thread_group.py` says what a thread group is. Here each thread holds a *part* of a sum
or maximum.

The threads of a block put their parts into shared memory. Each of the first WARP threads combines
every WARPth part; then all threads combine these results in the same order. So sums are the same
from run to run, for blocks of the same size. The waits keep this apart from the next sum: the next
parts are written after all threads have read the parts of this one, and the next results after all
threads have read the results of this one.

With several blocks, each block puts the sums of its threads into the memory of the GPU, and then
each block combines the sums of all blocks as it combines the parts of its threads. Blocks wait for
each other once a sum. That is enough, because a sum alternates between two places: the parts of the
next sum go to the other place, while other blocks may still read the parts of this one, and the sum
after the next one comes after another wait. All blocks have to run at the same time; a launch with
a wait for the grid makes sure of that.
"""

from typing import Any

import numba
from numba import cuda

from izo_ref.base.arrays import Floats, Indices
from izo_ref.base.cuda.compile import device_function
from izo_ref.base.serial.thread_group import Team, ThreadGroup

WARP = 32
PARTS = 7  # numbers of each block: its current place, and two places for three parts each


def shared_bytes(n_threads: int) -> int:
    """Return the shared memory of a block [bytes].

    It holds three parts of each thread, and three results of each of WARP threads.
    """
    return 8 * 3 * (n_threads + WARP)


@device_function
def _rank() -> int:
    return cuda.threadIdx.x


@device_function
def _size() -> int:
    return cuda.blockDim.x


@device_function
def _wait() -> None:
    cuda.syncthreads()


@device_function
def _sums(_parts: Any, a: float, b: float, c: float) -> tuple[float, float, float]:
    shared = cuda.shared.array(0, numba.float64)  # the launch says how large it is
    k, n = cuda.threadIdx.x, cuda.blockDim.x
    at, results = 3 * k, 3 * n
    shared[at], shared[at + 1], shared[at + 2] = a, b, c
    cuda.syncthreads()
    if k < WARP:
        a, b, c = 0.0, 0.0, 0.0
        for part in range(at, results, 3 * WARP):
            a += shared[part]
            b += shared[part + 1]
            c += shared[part + 2]
        at += results
        shared[at], shared[at + 1], shared[at + 2] = a, b, c
    cuda.syncthreads()
    a, b, c = 0.0, 0.0, 0.0
    for part in range(results, results + 3 * min(n, WARP), 3):
        a += shared[part]
        b += shared[part + 1]
        c += shared[part + 2]
    return a, b, c


@device_function
def _maxima(_parts: Any, a: float, b: float) -> tuple[float, float]:
    shared = cuda.shared.array(0, numba.float64)
    k, n = cuda.threadIdx.x, cuda.blockDim.x
    at, results = 3 * k, 3 * n
    shared[at], shared[at + 1] = a, b
    cuda.syncthreads()
    if k < WARP:
        for part in range(at, results, 3 * WARP):
            a, b = max(a, shared[part]), max(b, shared[part + 1])
        at += results
        shared[at], shared[at + 1] = a, b
    cuda.syncthreads()
    # all threads start with the same result, because with NaN the order matters
    a, b = shared[results], shared[results + 1]
    for part in range(results + 3, results + 3 * min(n, WARP), 3):
        a, b = max(a, shared[part]), max(b, shared[part + 1])
    return a, b


@device_function
def _add(values: Indices, i: int, amount: int) -> int:
    return cuda.atomic.add(values, i, amount)


@device_function
def _least(values: Indices, i: int, value: int) -> None:
    cuda.atomic.min(values, i, value)


@device_function
def _first() -> int:
    return 0


@device_function
def _one() -> int:
    return 1


@device_function
def block() -> ThreadGroup:
    """Return the thread group of a block."""
    team = Team(_rank, _size, _wait, _first, _one)
    return ThreadGroup(_rank, _size, _wait, _sums, _maxima, _add, _least, team, None)


@device_function
def _rank_in_grid() -> int:
    return cuda.blockIdx.x * cuda.blockDim.x + cuda.threadIdx.x


@device_function
def _size_of_grid() -> int:
    return cuda.gridDim.x * cuda.blockDim.x


@device_function
def _number_of_block() -> int:
    return cuda.blockIdx.x


@device_function
def _count_blocks() -> int:
    return cuda.gridDim.x


@device_function
def _wait_for_grid() -> None:
    cuda.cg.this_grid().sync()


@device_function
def _place(parts: Floats) -> int:
    """Return the place of the parts of this sum: 1 or 4; the next sum uses the other one."""
    own = parts[cuda.blockIdx.x]
    place = 4 if own[0] == 1.0 else 1
    cuda.syncthreads()  # all threads have read the place
    if cuda.threadIdx.x == 0:
        own[0] = place
    return place


@device_function
def _sums_of_grid(parts: Floats, a: float, b: float, c: float) -> tuple[float, float, float]:
    k, place = cuda.blockIdx.x, _place(parts)
    a, b, c = _sums(None, a, b, c)
    if cuda.threadIdx.x == 0:
        parts[k, place], parts[k, place + 1], parts[k, place + 2] = a, b, c
    cuda.cg.this_grid().sync()
    a, b, c = 0.0, 0.0, 0.0
    for k in range(cuda.threadIdx.x, cuda.gridDim.x, cuda.blockDim.x):
        a += parts[k, place]
        b += parts[k, place + 1]
        c += parts[k, place + 2]
    return _sums(None, a, b, c)


@device_function
def _maxima_of_grid(parts: Floats, a: float, b: float) -> tuple[float, float]:
    k, place = cuda.blockIdx.x, _place(parts)
    a, b = _maxima(None, a, b)
    if cuda.threadIdx.x == 0:
        parts[k, place], parts[k, place + 1] = a, b
    cuda.cg.this_grid().sync()
    # start from block 0, so that a NaN never comes from a block that does not exist
    a, b = parts[0, place], parts[0, place + 1]
    for k in range(cuda.threadIdx.x, cuda.gridDim.x, cuda.blockDim.x):
        a, b = max(a, parts[k, place]), max(b, parts[k, place + 1])
    return _maxima(None, a, b)


@device_function
def grid(parts: Floats) -> ThreadGroup:
    """Return the thread group of all blocks of a launch.

    Args:
        parts: (n_blocks, PARTS) f8, work space in the memory of the GPU, zeros at first.
    """
    team = Team(_rank, _size, _wait, _number_of_block, _count_blocks)
    return ThreadGroup(
        _rank_in_grid,
        _size_of_grid,
        _wait_for_grid,
        _sums_of_grid,
        _maxima_of_grid,
        _add,
        _least,
        team,
        parts,
    )

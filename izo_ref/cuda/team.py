"""The threads of a block as a team (`serial/team.py`): sums and maxima in shared memory.

Each of the first WARP threads takes every WARPth part, then all take the results of those in
their order: the same from run to run, for blocks of the same size. Parts of the next sum are
written after all have read those of this one, and results after all have read the parts.
"""

import numba
from numba import cuda

from izo_ref.cuda._jit import device_function
from izo_ref.serial.team import Team

WARP = 32


def shared_bytes(n_threads):
    """Shared memory of a block: three parts of each thread, and three results of WARP of them."""
    return 8 * 3 * (n_threads + WARP)


@device_function
def _rank():
    return cuda.threadIdx.x


@device_function
def _size():
    return cuda.blockDim.x


@device_function
def _wait():
    cuda.syncthreads()


@device_function
def _totals(a, b, c):
    shared = cuda.shared.array(0, numba.float64)  # as large as the launch says
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
def _total(a):
    return _totals(a, 0.0, 0.0)[0]


@device_function
def _largest(a, b):
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
    # all from the same one on: with NaN the order counts
    a, b = shared[results], shared[results + 1]
    for part in range(results + 3, results + 3 * min(n, WARP), 3):
        a, b = max(a, shared[part]), max(b, shared[part + 1])
    return a, b


@device_function
def block():
    """The team of a block."""
    return Team(_rank, _size, _wait, _total, _totals, _largest)

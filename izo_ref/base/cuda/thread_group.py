"""The threads of a block, or of all blocks of a launch, as a team (`base/serial/thread_group.py`).

A block has its sums and maxima in shared memory. Each of the first WARP threads takes every
WARPth part, then all take the results of those in their order: the same from run to run, for
blocks of the same size. Parts of the next sum are written after all have read those of this one,
and results after all have read the parts.

Several blocks have those of each in the device's memory, and then each block sums them as it
does its threads'. They wait for each other once a sum: parts of the next are written beside
those of this one, which others may still read, and those of the one after come after the next
wait. All blocks have to run at the same time, which a launch with a wait of the grid sees to.
"""

import numba
from numba import cuda

from izo_ref.base.cuda.compile import device_function
from izo_ref.base.serial.thread_group import ThreadGroup

WARP = 32
PARTS = 7  # numbers of each block: the place of its last parts, and two places of three


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
def _sums(_parts, a, b, c):
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
def _maxima(_parts, a, b):
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
    return ThreadGroup(_rank, _size, _wait, _sums, _maxima, None)


@device_function
def _rank_in_grid():
    return cuda.blockIdx.x * cuda.blockDim.x + cuda.threadIdx.x


@device_function
def _size_of_grid():
    return cuda.gridDim.x * cuda.blockDim.x


@device_function
def _wait_for_grid():
    cuda.cg.this_grid().sync()


@device_function
def _place(parts):
    """Where the parts of this sum are: 1 or 4, and of the next the other."""
    own = parts[cuda.blockIdx.x]
    place = 4 if own[0] == 1.0 else 1
    cuda.syncthreads()  # all have read
    if cuda.threadIdx.x == 0:
        own[0] = place
    return place


@device_function
def _sums_of_grid(parts, a, b, c):
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
def _maxima_of_grid(parts, a, b):
    k, place = cuda.blockIdx.x, _place(parts)
    a, b = _maxima(None, a, b)
    if cuda.threadIdx.x == 0:
        parts[k, place], parts[k, place + 1] = a, b
    cuda.cg.this_grid().sync()
    # of the first, so that a NaN is none of those that are not there
    a, b = parts[0, place], parts[0, place + 1]
    for k in range(cuda.threadIdx.x, cuda.gridDim.x, cuda.blockDim.x):
        a, b = max(a, parts[k, place]), max(b, parts[k, place + 1])
    return _maxima(None, a, b)


@device_function
def grid(parts):
    """The team of all blocks of a launch; parts: (n_blocks, PARTS) f8, zeros at first."""
    return ThreadGroup(
        _rank_in_grid, _size_of_grid, _wait_for_grid, _sums_of_grid, _maxima_of_grid, parts
    )

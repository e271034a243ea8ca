"""Kernels for sums, choices and orders of arrays on a GPU; on the CPU numpy does it."""

from typing import Any

import numba
from numba import cuda

from izo_ref.base.arrays import AnyArray, Flags, Indices, Offsets
from izo_ref.base.cuda.compile import THREADS, cuda_kernel, device_function

# Where a kernel takes the values of an array together, a thread takes ITEMS of them, and a block of
# THREADS threads takes a tile of TILE. Many arrays here are so short that one launch is enough.
ITEMS = 8
TILE = THREADS * ITEMS
TILES = 4 * TILE  # shared memory of `sort_tiles`: keys and places, each twice

SUM, LARGEST, LEAST = range(3)  # operations of `reduce_tiles`


@device_function
def sum_so_far(own: int) -> int:
    """Return the sum of the values of the threads of a block, from the first thread to this one."""
    # Every thread of a block has to come to each barrier; threads without values add nothing.
    sums = cuda.shared.array(THREADS, numba.int64)
    k = cuda.threadIdx.x
    sums[k] = own
    distance = 1
    while distance < cuda.blockDim.x:
        cuda.syncthreads()
        before = sums[k - distance] if k >= distance else 0
        cuda.syncthreads()
        sums[k] += before
        distance *= 2
    return sums[k]


@cuda_kernel
def scan_tiles(
    # In:
    values: AnyArray,  # (n,) i8 or b1
    # Out:
    starts_out: Offsets,  # (n + 1,) i8, sum of the values before each in its tile; 0 at first
    totals_out: Indices,  # (n_tiles,) i8, sum of each tile
) -> None:
    """Sum the values before each value, tile by tile."""
    k, own = cuda.threadIdx.x, numba.int64(0)
    begin = cuda.blockIdx.x * TILE + k * ITEMS
    end = min(begin + ITEMS, values.shape[0])
    for i in range(begin, end):
        own += values[i]
    total = sum_so_far(own)
    so_far = total - own
    for i in range(begin, end):
        so_far += values[i]
        starts_out[i + 1] = so_far
    if k == cuda.blockDim.x - 1:
        totals_out[cuda.blockIdx.x] = total
    if cuda.blockIdx.x == 0 and k == 0:
        starts_out[0] = 0


@cuda_kernel
def choose_in_tile(
    # In:
    flags: Flags,  # (n,) b1, n is at most TILE
    # Out:
    index_out: Indices,  # (>= n_chosen,) i8, where the flags are true, ascending
    count_out: Indices,  # (1,) i8, n_chosen
) -> None:
    """Find and count the true flags of one tile."""
    k, own = cuda.threadIdx.x, numba.int64(0)
    begin, end = k * ITEMS, min((k + 1) * ITEMS, flags.shape[0])
    for i in range(begin, end):
        own += flags[i]
    total = sum_so_far(own)
    at = total - own
    for i in range(begin, end):
        if flags[i]:
            index_out[at] = i
            at += 1
    if k == cuda.blockDim.x - 1:
        count_out[0] = total


@cuda_kernel
def add_tiles(
    # In:
    before: Offsets,  # (n_tiles + 1,) i8, sum of the tiles before each
    # Out:
    starts_out: Offsets,  # (n + 1,) i8, of `scan_tiles`; becomes the sum of all values before each
) -> None:
    """Add the sum of the tiles before to the sums within each tile."""
    i = cuda.grid(1)
    if i < starts_out.shape[0] - 1:
        starts_out[i + 1] += before[i // TILE]


@cuda_kernel
def gather_chosen(
    # In:
    starts: Offsets,  # (n + 1,) i8, how many values before each are chosen
    # Out:
    index_out: Indices,  # (n_chosen,) i8, ascending
) -> None:
    """Write the indices of the chosen values."""
    i = cuda.grid(1)
    if i < starts.shape[0] - 1 and starts[i + 1] > starts[i]:
        index_out[starts[i]] = i


@device_function
def place_in_merge(keys: AnyArray, width: int, i: int) -> int:
    """Return the place of key i when each sorted run of `width` keys is merged with the next."""
    run = i // width
    beside = run ^ 1  # the other run, with which it is merged
    key = keys[i]
    low = min(beside * width, keys.shape[0])
    begin, end = low, min(low + width, keys.shape[0])
    while low < end:
        middle = (low + end) // 2
        if keys[middle] < key or (beside < run and keys[middle] == key):
            low = middle + 1
        else:
            end = middle
    return min(run, beside) * width + (i - run * width) + (low - begin)


@cuda_kernel
def sort_tiles(
    # In:
    keys: Indices,  # (n,) i8
    # Out:
    keys_out: Indices,  # (n,) i8, each tile sorted; equal keys keep their order
    places_out: Indices,  # (n,) i8, where each key was
) -> None:
    """Sort each tile by merging its runs in shared memory."""
    begin, k = cuda.blockIdx.x * TILE, cuda.threadIdx.x
    n = min(keys.shape[0] - begin, TILE)
    shared = cuda.shared.array(TILES, numba.int64)
    own_keys, own_places = shared[: 2 * TILE], shared[2 * TILE :]
    for i in range(k, n, cuda.blockDim.x):
        own_keys[i], own_places[i] = keys[begin + i], begin + i
    cuda.syncthreads()
    source, width = 0, 1
    while width < n:
        target = TILE - source
        for i in range(k, n, cuda.blockDim.x):
            at = target + place_in_merge(own_keys[source : source + n], width, i)
            own_keys[at], own_places[at] = own_keys[source + i], own_places[source + i]
        cuda.syncthreads()
        source, width = target, 2 * width
    for i in range(k, n, cuda.blockDim.x):
        keys_out[begin + i], places_out[begin + i] = own_keys[source + i], own_places[source + i]


@cuda_kernel
def merge_runs(
    # In:
    width: int,  # i8, runs of this many keys, from the first key on, are sorted
    keys: Indices,  # (n,) i8
    places: Indices,  # (n,) i8
    # Out:
    keys_out: Indices,  # (n,) i8, sorted in runs twice as long; equal keys keep their order
    places_out: Indices,  # (n,) i8, moved with the keys
) -> None:
    """Merge each sorted run with the next."""
    i = cuda.grid(1)
    if i < keys.shape[0]:
        at = place_in_merge(keys, width, i)
        keys_out[at], places_out[at] = keys[i], places[i]


@cuda_kernel
def take_rows(
    # In:
    values: AnyArray,  # (n, k) i4 or f8 or i8 or b1 or i1
    index: Indices,  # (m,) i8
    # Out:
    rows_out: AnyArray,  # (m, k) i4 or f8 or i8 or b1 or i1
) -> None:
    """Copy the rows of an index."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(values.shape[1]):
            rows_out[i, k] = values[index[i], k]


@cuda_kernel
def count_up(
    # In:
    first: int,  # i8
    # Out:
    numbers_out: Indices,  # (n,) i8
) -> None:
    """Write first, first + 1, ..."""
    i = cuda.grid(1)
    if i < numbers_out.shape[0]:
        numbers_out[i] = first + i


@cuda_kernel
def fill(
    # In:
    value: Any,  # f8 or f4 or i8 or i4 or b1 or i1
    # Out:
    values_out: AnyArray,  # (n,) f8 or f4 or i8 or i4 or b1 or i1
) -> None:
    """Write one value everywhere."""
    i = cuda.grid(1)
    if i < values_out.shape[0]:
        values_out[i] = value


@device_function
def combined(operation: int, a: Any, b: Any) -> Any:
    """Combine two values by SUM, LARGEST or LEAST."""
    if operation == SUM:
        return a + b
    return max(a, b) if operation == LARGEST else min(a, b)


@cuda_kernel
def reduce_tiles(
    # In:
    values: AnyArray,  # (n, k) i8 or f8
    column: int,  # i8
    operation: int,  # i8, SUM, LARGEST or LEAST
    # Out:
    results_out: AnyArray,  # (n_tiles,) i8 or f8
) -> None:
    """Combine the values of one column, tile by tile."""
    begin, k = cuda.blockIdx.x * TILE, cuda.threadIdx.x
    n_values = min(values.shape[0] - begin, TILE)
    # every thread of a block has to come to each barrier
    partial = cuda.shared.array(THREADS, values.dtype)
    n = min(n_values, cuda.blockDim.x)
    if k < n:
        partial[k] = values[begin + k, column]
        for i in range(k + cuda.blockDim.x, n_values, cuda.blockDim.x):
            partial[k] = combined(operation, partial[k], values[begin + i, column])
    while n > 1:
        cuda.syncthreads()
        half = (n + 1) // 2
        if k + half < n:
            partial[k] = combined(operation, partial[k], partial[k + half])
        n = half
    if k == 0:
        results_out[cuda.blockIdx.x] = partial[0]

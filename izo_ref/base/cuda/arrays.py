"""Sums, choices and orders of arrays that stay on the device; numpy does it on the processor."""

import numba
from numba import cuda

from izo_ref.base.cuda.compile import THREADS, cuda_kernel, device_function

# Values of a thread, and of a block of THREADS, where all of an array are taken together: many
# arrays here are so short that one launch is all.
ITEMS = 8
TILE = THREADS * ITEMS
TILES = 4 * TILE  # keys and places, each twice


@device_function
def sum_so_far(own):
    """Of the values of the threads of a block, up to this one's."""
    # all threads of a block come to each barrier: those without a value add nothing
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
    values,  # (n,) i8 or b1
    # Out:
    starts_out,  # (n + 1,) i8, sum of the values before each in its tile of TILE; 0 at first
    totals_out,  # (n_tiles,) i8, of each tile
):
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
    flags,  # (n,) b1, n is TILE at most
    # Out:
    index_out,  # (>= n_chosen,) i8, where they are true, ascending
    count_out,  # (1,) i8, n_chosen
):
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
    before,  # (n_tiles + 1,) i8, sum of the tiles before each
    # Out:
    starts_out,  # (n + 1,) i8, of scan_tiles, becomes the sum of all values before each
):
    i = cuda.grid(1)
    if i < starts_out.shape[0] - 1:
        starts_out[i + 1] += before[i // TILE]


@cuda_kernel
def gather_chosen(
    # In:
    starts,  # (n + 1,) i8, how many are chosen before each
    # Out:
    index_out,  # (n_chosen,) i8, those chosen, ascending
):
    i = cuda.grid(1)
    if i < starts.shape[0] - 1 and starts[i + 1] > starts[i]:
        index_out[starts[i]] = i


@device_function
def place_in_merge(keys, width, i):
    """Where key i comes when each run of `width` that is in order is merged with the next."""
    run = i // width
    beside = run ^ 1  # the other run that it is merged with
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
    keys,  # (n,) i8
    # Out:
    keys_out,  # (n,) i8, each tile of TILE in order, equal keys as they were
    places_out,  # (n,) i8, where each was
):
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
    width,  # i8, runs of so many, from the first on, are in order
    keys,  # (n,) i8
    places,  # (n,) i8
    # Out:
    keys_out,  # (n,) i8, runs of twice as many are in order, equal keys as they were
    places_out,  # (n,) i8, as the keys
):
    i = cuda.grid(1)
    if i < keys.shape[0]:
        at = place_in_merge(keys, width, i)
        keys_out[at], places_out[at] = keys[i], places[i]


@cuda_kernel
def take_rows(
    # In:
    values,  # (n, k) i4 or f8 or i8 or b1 or i1
    index,  # (m,) i8
    # Out:
    rows_out,  # (m, k) i4 or f8 or i8 or b1 or i1
):
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(values.shape[1]):
            rows_out[i, k] = values[index[i], k]


@cuda_kernel
def count_up(
    # In:
    first,  # i8
    # Out:
    numbers_out,  # (n,) i8, first, first + 1, ...
):
    i = cuda.grid(1)
    if i < numbers_out.shape[0]:
        numbers_out[i] = first + i


@cuda_kernel
def fill(
    # In:
    value,  # f8 or f4 or i8 or b1 or i1
    # Out:
    values_out,  # (n,) f8 or f4 or i8 or b1 or i1
):
    i = cuda.grid(1)
    if i < values_out.shape[0]:
        values_out[i] = value


SUM, LARGEST, LEAST = range(3)


@device_function
def combined(operation, a, b):
    """Of two."""
    if operation == SUM:
        return a + b
    return max(a, b) if operation == LARGEST else min(a, b)


@cuda_kernel
def reduce_tiles(
    # In:
    values,  # (n, k) i8 or f8
    column,  # i8
    operation,  # i8, SUM, LARGEST or LEAST
    # Out:
    results_out,  # (n_tiles,) i8 or f8, of each tile of TILE
):
    begin, k = cuda.blockIdx.x * TILE, cuda.threadIdx.x
    n_values = min(values.shape[0] - begin, TILE)
    # all threads of a block come to each barrier
    part = cuda.shared.array(THREADS, values.dtype)
    n = min(n_values, cuda.blockDim.x)
    if k < n:
        part[k] = values[begin + k, column]
        for i in range(k + cuda.blockDim.x, n_values, cuda.blockDim.x):
            part[k] = combined(operation, part[k], values[begin + i, column])
    while n > 1:
        cuda.syncthreads()
        half = (n + 1) // 2
        if k + half < n:
            part[k] = combined(operation, part[k], part[k + half])
        n = half
    if k == 0:
        results_out[cuda.blockIdx.x] = part[0]

"""Sums, choices and orders of arrays that stay on the device; numpy does it on the processor."""

import numba
from numba import cuda

from izo_ref.cuda._jit import THREADS, cuda_kernel


@cuda_kernel
def scan_blocks(
    # In:
    values,  # (n,) i8 or b1
    # Out:
    sums_out,  # (n,) i8, of each value and those before it in its block of THREADS
    totals_out,  # (n_blocks,) i8, of each block
):
    i, k = cuda.grid(1), cuda.threadIdx.x
    # all threads of a block come to each barrier: those without a value add nothing
    sums = cuda.shared.array(THREADS, numba.int64)
    sums[k] = values[i] if i < values.shape[0] else 0
    distance = 1
    while distance < cuda.blockDim.x:
        cuda.syncthreads()
        before = sums[k - distance] if k >= distance else 0
        cuda.syncthreads()
        sums[k] += before
        distance *= 2
    if i < values.shape[0]:
        sums_out[i] = sums[k]
    if k == cuda.blockDim.x - 1:
        totals_out[cuda.blockIdx.x] = sums[k]


@cuda_kernel
def starts_from_sums(
    # In:
    sums,  # (n,) i8, of scan_blocks
    before,  # (n_blocks,) i8, sum of the blocks before each
    # Out:
    starts_out,  # (n + 1,) i8, sum of all values before each, and of all
):
    i = cuda.grid(1)
    if i == 0:
        starts_out[0] = 0
    if i < sums.shape[0]:
        starts_out[i + 1] = sums[i] + before[i // THREADS]


@cuda_kernel
def chosen(
    # In:
    starts,  # (n + 1,) i8, how many are chosen before each
    # Out:
    index_out,  # (n_chosen,) i8, those chosen, ascending
):
    i = cuda.grid(1)
    if i < starts.shape[0] - 1 and starts[i + 1] > starts[i]:
        index_out[starts[i]] = i


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
        at = min(run, beside) * width + (i - run * width) + (low - begin)
        keys_out[at] = key
        places_out[at] = places[i]


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


@cuda_kernel
def reduce_blocks(
    # In:
    values,  # (n, k) i8 or f8
    column,  # i8
    operation,  # i8, SUM, LARGEST or LEAST
    # Out:
    results_out,  # (n_blocks,) i8 or f8, of each block of THREADS
):
    i, k = cuda.grid(1), cuda.threadIdx.x
    # all threads of a block come to each barrier
    part = cuda.shared.array(THREADS, values.dtype)
    begin = i - k
    n = min(values.shape[0] - begin, cuda.blockDim.x)
    if k < n:
        part[k] = values[i, column]
    while n > 1:
        cuda.syncthreads()
        half = (n + 1) // 2
        if k + half < n:
            other = part[k + half]
            if operation == SUM:
                part[k] += other
            elif operation == LARGEST:
                part[k] = max(part[k], other)
            else:
                part[k] = min(part[k], other)
        n = half
    if k == 0:
        results_out[cuda.blockIdx.x] = part[0]

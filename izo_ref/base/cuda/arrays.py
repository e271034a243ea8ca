"""Kernels that take and put rows of arrays on a GPU; on the CPU numpy does it."""

from numba import cuda

from izo_ref.base.arrays import AnyArray, Indices
from izo_ref.base.cuda.compile import cuda_kernel


@cuda_kernel
def take_rows(
    # In:
    values: AnyArray,  # (n, k) f8; of the caller, so perhaps another dtype
    index: Indices,  # (m,) i8
    # Out:
    rows_out: AnyArray,  # (m, k) f8
) -> None:
    """Copy the rows of an index."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(values.shape[1]):
            rows_out[i, k] = values[index[i], k]


@cuda_kernel
def put_rows(
    # In:
    index: Indices,  # (m,) i8, each once
    rows: AnyArray,  # (m, k) f8 or b1
    # Out:
    values_out: AnyArray,  # (n, k) f8 or b1
) -> None:
    """Write rows to the places of an index."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(rows.shape[1]):
            values_out[index[i], k] = rows[i, k]

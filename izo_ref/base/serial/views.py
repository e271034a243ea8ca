"""Views of memory, for the CPU and for a GPU: flat memory as a matrix, and indices.

numba's own `reshape` calls a C function, and a GPU does not have it.
"""

import numpy as np
from numba import types
from numba.core import cgutils, config
from numba.extending import intrinsic

from izo_ref.base.arrays import AnyArray, AnyInt
from izo_ref.base.compile import inlined


def _matrix_in_python(flat: AnyArray, rows: int, columns: int) -> AnyArray:
    return flat[: rows * columns].reshape(rows, columns)


@intrinsic
def _matrix_compiled(context, flat, rows, columns):
    """Return the view in compiled code: the same memory, with two sizes and two strides."""
    matrix = types.Array(flat.dtype, 2, "C")

    def build(context, builder, signature, arguments):
        source = context.make_array(signature.args[0])(context, builder, arguments[0])
        sizes = [
            context.cast(builder, value, own, types.intp)
            for value, own in zip(arguments[1:], signature.args[1:], strict=True)
        ]
        view = context.make_array(matrix)(context, builder)
        view.data, view.itemsize = source.data, source.itemsize
        view.meminfo, view.parent = source.meminfo, source.parent
        view.nitems = builder.mul(*sizes)
        view.shape = cgutils.pack_array(builder, sizes)
        strides = [builder.mul(sizes[1], source.itemsize), source.itemsize]
        view.strides = cgutils.pack_array(builder, strides)
        value = view._getvalue()
        if context.enable_nrt:
            context.nrt.incref(builder, matrix, value)
        return value

    return matrix(flat, rows, columns), build


# (flat, rows, columns) -> a (rows, columns) view of the first numbers of a contiguous flat array
# (n,), n >= rows * columns
matrix_of = _matrix_in_python if config.DISABLE_JIT else _matrix_compiled

# For sums with what `place` returns: numba makes the sum with a signed number signed.
ONE, TWO, THREE, FOUR = np.uint32(1), np.uint32(2), np.uint32(3), np.uint32(4)


@inlined
def place(index: AnyInt) -> np.uint32:
    """Return an index that is never negative as one that cannot be.

    By a signed index, numba reads from the end of the array if it is negative. LLVM cannot always
    prove that it is not, and a GPU then takes ten instructions for an address.

    Args:
        index: From 0 on, and less than 2^32.
    """
    return np.uint32(index)

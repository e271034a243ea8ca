"""Names for the arrays that pass between functions: shape, dtype and unit of each.

The type checker knows them as numpy arrays of a dtype. Shapes are for the reader, and are checked
where arrays come in (`base/checks.py`).
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Positions: TypeAlias = NDArray[np.float64]  # (n_vertices, 3) f8 [m]
Masses: TypeAlias = NDArray[np.float64]  # (n_vertices,) f8 [kg]
Faces: TypeAlias = NDArray[np.int32]  # (n_faces, 3) i4, vertices
Edges: TypeAlias = NDArray[np.int32]  # (n_edges, 2) i4, vertices, the lower one first
Nodes: TypeAlias = NDArray[np.int32]  # (n_impacts, 4) i4, vertices of both sides
Weights: TypeAlias = NDArray[np.float64]  # (n_impacts, 4) f8, signed; their sum is zero
Normals: TypeAlias = NDArray[np.float64]  # (n_impacts, 3) f8, unit vectors
Times: TypeAlias = NDArray[np.float64]  # (n_impacts,) f8, from 0 to 1
Multipliers: TypeAlias = NDArray[np.float64]  # (n_impacts,) f8 [kg]
Flags: TypeAlias = NDArray[np.bool_]  # (n,) b1
Indices: TypeAlias = NDArray[np.int64]  # (n,) i8, of the elements of another array
Offsets: TypeAlias = NDArray[np.int64]  # (n + 1,) i8, where each block begins, and the end
Floats: TypeAlias = NDArray[np.float64]  # f8, of the shape that is stated beside
Ints: TypeAlias = NDArray[np.int32]  # i4, of the shape that is stated beside
Codes: TypeAlias = NDArray[np.int8]  # (n,) i1, methods or statuses
AnyFloats: TypeAlias = NDArray[np.floating[Any]]  # f4 or f8, as the caller chose
AnyInts: TypeAlias = NDArray[np.integer[Any]]  # whole numbers of a width that is stated beside
GpuArray: TypeAlias = Any  # in the memory of a GPU; numba-cuda has no types for it
AnyArray: TypeAlias = NDArray[Any]  # of a dtype and shape that are stated beside
Vec3: TypeAlias = tuple[float, float, float]  # three numbers in registers
AnyInt: TypeAlias = int | np.integer[Any]  # one whole number of any width
AnyFloat: TypeAlias = float | np.floating[Any]  # one number, f4 or f8
AnyBool: TypeAlias = bool | np.bool_  # one truth value
Vec4: TypeAlias = tuple[float, float, float, float]  # four numbers in registers
Bits: TypeAlias = NDArray[np.uint8]  # u1, masks of eight bits

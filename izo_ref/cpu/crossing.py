"""Edges against faces at one time."""

from numba import prange

from izo_ref._jit import cpu_kernel
from izo_ref.cpu.advance import row3
from izo_ref.scalar.crossing import edge_face_status


@cpu_kernel
def edge_face_statuses(
    # In:
    positions,  # (n_vertices, 3) f8  [m]
    edges,  # (n_pairs, 2) i4
    faces,  # (n_pairs, 3) i4
    # Out:
    statuses_out,  # (n_pairs,) i1, of scalar/advance.py
):
    for i in prange(edges.shape[0]):
        statuses_out[i] = edge_face_status(
            row3(positions, edges[i, 0]),
            row3(positions, edges[i, 1]),
            row3(positions, faces[i, 0]),
            row3(positions, faces[i, 1]),
            row3(positions, faces[i, 2]),
        )

"""Records of zones side by side on a GPU: constraints in scaled variables, and solutions."""

from typing import NamedTuple

from izo_ref.base.arrays import GpuArray


class GpuConstraints(NamedTuple):
    """The constraints C z >= s of zones side by side, in scaled variables.

    Source: docs/method section 5.
    """

    impact_offsets: GpuArray  # (n_zones + 1,) i8
    vertex_offsets: GpuArray  # (n_zones + 1,) i8, unpinned vertices
    unknowns: GpuArray  # (n_impacts, 4) i4, unpinned vertices of the zones; -1 for pinned ones
    coefficients: GpuArray  # (n_impacts, 4) f8; together with the normals, rows of unit length
    normals: GpuArray  # (n_impacts, 3) f8
    rhs: GpuArray  # (n_impacts,) f8 [m kg^1/2], s
    lengths: GpuArray  # (n_impacts,) f8 [kg^-1/2], lengths of the rows before scaling


class GpuSolution(NamedTuple):
    """Solutions of all zones in scaled variables; the entries of unsolved zones are invalid."""

    multipliers: GpuArray  # (n_impacts,) f8 [m kg^1/2], of the constraints of unit length
    z: GpuArray  # (3 n_unpinned,) f8 [m kg^1/2]
    solved: GpuArray  # (n_zones,) b1


class Members(NamedTuple):
    """Which zone each impact and vertex belongs to, and the masses of the vertices."""

    zone_of_impact: GpuArray  # (n_impacts,) i8
    zone_of_vertex: GpuArray  # (n_unpinned,) i8
    vertices: GpuArray  # (n_unpinned,) i8, the number of each vertex in the scene
    inverse_sqrt_masses: GpuArray  # (n_vertices,) f8 [kg^-1/2], of the scene; 0 for pinned ones

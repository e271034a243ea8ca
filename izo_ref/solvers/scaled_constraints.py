"""The constraints of zones in scaled variables, without units (docs/method section 5).

The unknowns are z_i = sqrt(m_i) (x_i - y_i), with x the end positions and y the proposed ones. Each
constraint is divided by the length of its row, so that the constraints are C z >= s with rows of
unit length. In these variables the objective is 1/2 |z|^2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from izo_ref.base.arrays import Flags, Floats, Ints, Multipliers, Nodes, Normals, Positions
from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.serial.constraints import products, pull
from izo_ref.zones.system import ZoneSystem


class SystemSolution(NamedTuple):
    """Solutions of all zones of a system, zone by zone, in metres and kilograms."""

    positions: Positions  # (n_vertices, 3) f8 [m]
    displacements: Positions  # (n_vertices, 3) f8 [m], from the proposed positions
    multipliers: Multipliers  # (n_impacts,) f8 [kg], for the objective 1/2 sum m |x - y|^2
    active: Flags  # (n_impacts,) b1
    feasible: Flags  # (n_zones,) b1
    iterations: Ints  # (n_zones,) i4
    methods: NDArray[np.str_]  # (n_zones,) names of methods
    trace: Floats | None = None  # (n_steps, 2) f8, of the first zone, see ZoneSolution


class ScaledConstraints(NamedTuple):
    """The constraints of a system in scaled variables: C z >= s."""

    unknowns: Nodes  # (n_impacts, 4) i4, the vertices of each impact; -1 for pinned ones
    coefficients: Floats  # (n_impacts, 4) f8
    rhs: Floats  # (n_impacts,) f8 [m kg^1/2], s
    lengths: Floats  # (n_impacts,) f8 [kg^-1/2], lengths of the rows before scaling
    hopeless: Flags  # (n_impacts,) b1, violated, and no unpinned vertex can change it


class LargeZone(NamedTuple):
    """The constraints of one zone in scaled variables: C z >= s. Its vertices begin at 0."""

    nodes: Nodes  # (m, 4) i4, unpinned vertices of the zone; -1 for pinned ones
    coefficients: Floats  # (m, 4) f8; together with the normals, rows of unit length
    normals: Normals  # (m, 3) f8
    rhs: Floats  # (m,) f8 [m kg^1/2], s; at least one entry is positive
    lengths: Floats  # (m,) f8 [kg^-1/2], lengths of the rows before scaling
    n_vertices: int  # unpinned vertices

    def times(self, z: Floats) -> Floats:
        """Return C z, (m,) f8, for z (3 n_vertices,) f8."""
        out = np.empty(len(self.rhs))
        products(0, self.nodes, self.coefficients, self.normals, z, out)
        return out

    def pull(self, multipliers: Multipliers) -> Floats:
        """Return C^T u, (3 n_vertices,) f8, for the multipliers u, (m,) f8."""
        out = np.empty(3 * self.n_vertices)
        pull(0, self.nodes, self.coefficients, self.normals, multipliers, out)
        return out


def scale_constraints(system: ZoneSystem) -> ScaledConstraints:
    """Return the constraints of a system in scaled variables."""
    n = len(system.nodes)
    constraints = ScaledConstraints(
        np.empty((n, 4), np.int32), np.empty((n, 4)), np.empty(n), np.empty(n), np.empty(n, bool)
    )
    kernels.scale_constraints(
        system.nodes,
        system.weights,
        system.normals,
        system.proposed,
        1.0 / np.sqrt(system.masses),
        system.thickness,
        *constraints,
    )
    return constraints


def constraints_of_zone(system: ZoneSystem, constraints: ScaledConstraints, zone: int) -> LargeZone:
    """Return the constraints of one zone of a system."""
    own = slice(*system.impact_offsets[zone : zone + 2])
    first, last = system.vertex_offsets[zone : zone + 2]
    unknowns = constraints.unknowns[own]
    return LargeZone(
        np.where(unknowns < 0, -1, unknowns - first).astype(np.int32),
        constraints.coefficients[own],
        system.normals[own],
        constraints.rhs[own],
        constraints.lengths[own],
        int(last - first),
    )

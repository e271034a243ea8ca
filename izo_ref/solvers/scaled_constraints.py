"""A system of zones in variables without units (SPEC section 5), and its solution."""

from typing import NamedTuple

import numpy as np

from izo_ref.solvers.cpu import zones as kernels
from izo_ref.zones.system import ZoneSystem


class SystemSolution(NamedTuple):
    """Of all zones of a system, side by side."""

    positions: np.ndarray  # (n_vertices, 3) f8 [m]
    displacements: np.ndarray  # (n_vertices, 3) f8 [m], from the proposed positions
    multipliers: np.ndarray  # (n_impacts,) f8 [kg], of 1/2 sum m |x - y|^2
    active: np.ndarray  # (n_impacts,) b1, rows that hold the solution
    feasible: np.ndarray  # (n_zones,) b1
    iterations: np.ndarray  # (n_zones,) i4
    methods: np.ndarray  # (n_zones,) str
    trace: np.ndarray | None = None  # (steps, 2) f8, of the first zone, see ZoneSolution


class ScaledConstraints(NamedTuple):
    """The system in scaled variables: C z >= s with rows of unit length."""

    unknowns: np.ndarray  # (n_impacts, 4) i4, as nodes; -1 for pinned
    coefficients: np.ndarray  # (n_impacts, 4) f8
    rhs: np.ndarray  # (n_impacts,) f8 [m kg^1/2], s
    lengths: np.ndarray  # (n_impacts,) f8 [kg^-1/2], of the rows before scaling
    hopeless: np.ndarray  # (n_impacts,) b1, violated and without unknowns


def scale_constraints(system: ZoneSystem) -> ScaledConstraints:
    """z_i = sqrt(m_i) (x_i - y_i), and each row of the constraints over its length."""
    n = len(system.nodes)
    rows = ScaledConstraints(
        np.empty((n, 4), np.int32), np.empty((n, 4)), np.empty(n), np.empty(n), np.empty(n, bool)
    )
    kernels.scale_constraints(
        system.nodes,
        system.weights,
        system.normals,
        system.proposed,
        1.0 / np.sqrt(system.masses),
        system.thickness,
        *rows,
    )
    return rows

"""Records that pass between the modules."""

import enum
from typing import NamedTuple

import numpy as np


class Status(enum.Enum):
    """How a step ended. The value is a sentence for the user."""

    FREE = "The path is certified free and every zone is solved to tolerance."
    FREE_BY_FALLBACK = (
        "The path is certified free, but not every zone is optimal: some were scaled back "
        "toward the start of the step, or not solved to tolerance, so the result may be "
        "farther from the candidate positions than it need be."
    )
    BLOCKED = (
        "No free path was found: the pairs named meet, or something is pinched between "
        "prescribed parts. Up to the time given the path is free; take a smaller step or "
        "change the prescribed motion."
    )


class Pairs(NamedTuple):
    """Vertex-face and edge-edge pairs."""

    nodes: np.ndarray  # (n, 4) i4, vertex then face, or edge then edge
    is_edge_edge: np.ndarray  # (n,) b1


class Impacts(NamedTuple):
    """Pairs that meet on a path, each with its contact frozen at its time of impact.

    The frozen gap of impact j at positions x is normals_j . sum_k weights_jk x[nodes_jk].
    """

    nodes: np.ndarray  # (n, 4) i4, vertex then face, or edge then edge
    is_edge_edge: np.ndarray  # (n,) b1
    toi: np.ndarray  # (n,) f8, in [0, 1]
    weights: np.ndarray  # (n, 4) f8, first side positive, second negative, sum zero
    normals: np.ndarray  # (n, 3) f8, unit, the gap is positive at t = 0

    def take(self, index):
        """The impacts of an index array or a mask."""
        return Impacts(*(column[index] for column in self))


def no_impacts() -> Impacts:
    return Impacts(
        np.empty((0, 4), np.int32),
        np.empty(0, bool),
        np.empty(0),
        np.empty((0, 4)),
        np.empty((0, 3)),
    )


def join_impacts(parts) -> Impacts:
    """One after the other."""
    parts = list(parts) or [no_impacts()]
    return Impacts(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))

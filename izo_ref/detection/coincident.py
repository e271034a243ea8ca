"""Vertices that coincide among the intersections at the start, and what to do about them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Faces, Positions
from izo_ref.base.records import Pairs
from izo_ref.detection.rows import equal_rows, first_of_each

NAMED = 3  # groups that a message names


class Coincident(NamedTuple):
    """Vertices of intersecting elements that are at the same place at the start.

    Attributes:
        groups: The vertices of each group, ascending; the groups by their lowest vertex.
        parted: The groups whose vertices do not all end at the same place.
        n_faces: Number of faces whose corners coincide with those of a face before them.
    """

    groups: list[list[int]]
    parted: list[list[int]]
    n_faces: int

    def __str__(self) -> str:
        """Return sentences for the user; nothing if no vertices coincide."""
        if not self.groups:
            return ""
        n, k = len(self.groups), sum(map(len, self.groups))
        text = f"{k} vertices coincide exactly, in {_count(n)}, the first: {_names(self.groups)}. "
        if self.n_faces:
            text += f"{self.n_faces} faces lie exactly on others. "
        if len(self.parted) < n:
            text += (
                "If they are one vertex, pass weld=0: it joins those that also end at one place. "
            )
        if self.parted:
            text += (
                f"The vertices of {_count(len(self.parted))} end at different places, and are not "
                f"welded, the first: {_names(self.parted)}. "
            )
        return text


def find_coincident(
    positions_t0: Positions, positions_t1: Positions, faces: Faces, pairs: Pairs
) -> Coincident:
    """Find the vertices of intersecting pairs that are at the same place at the start.

    Args:
        positions_t0: (n, 3) f8 [m].
        positions_t1: (n, 3) f8 [m].
        faces: (m, 3) i4.
        pairs: The pairs that intersect.
    """
    n = len(positions_t0)
    place = equal_rows(positions_t0)
    path = equal_rows(np.hstack((positions_t0, positions_t1)))
    used = np.zeros(n, bool)
    used[pairs.nodes] = True
    several = np.flatnonzero(used & (np.bincount(place)[place] > 1))
    order = several[np.argsort(place[several], kind="stable")]
    starts = np.flatnonzero(np.diff(place[order])) + 1
    groups = sorted(g.tolist() for g in np.split(order, starts) if len(g) > 1)
    parted = [group for group in groups if len(set(path[group].tolist())) > 1]
    corners = np.sort(place[faces].astype(np.int32), axis=1)
    n_faces = len(faces) - len(first_of_each(corners, n)) if groups else 0
    return Coincident(groups, parted, n_faces)


def _count(n: int) -> str:
    return f"{n} group" if n == 1 else f"{n} groups"


def _names(groups: list[list[int]]) -> str:
    shown = ["(" + ", ".join(map(str, g[:5])) + (", ...)" if len(g) > 5 else ")") for g in groups]
    return ", ".join(shown[:NAMED])

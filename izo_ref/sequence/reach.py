"""How far the vertices of a mesh have gone through a surface.

The edges that go through a surface cut their own mesh into patches, as far as the contours are
closed. The largest patch of each connected component counts as the side where it belongs, and the
vertices of all others have gone through: they are cut off. Which side is right cannot be known from
one frame, so this is a guess for parts that are more than half through.

Source: D. Baraff, A. Witkin and M. Kass, Untangling Cloth (2003), section 4, whose flood fill also
takes the smaller side. Here the patches are those of the graph of edges without crossings.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Edges, Faces, Flags, Floats, Indices, Positions

CHUNK = 1 << 16  # points and faces whose distances are computed at once


class Patches(NamedTuple):
    """The patches into which crossings cut a mesh.

    Attributes:
        patch: (n_vertices,) i8, the patch that each vertex is in.
        sizes: (n_patches,) i8, number of vertices of each.
        cut_off: (n_vertices,) b1, vertices that are not in the largest patch of their component.
    """

    patch: Indices
    sizes: Indices
    cut_off: Flags


def find_patches(edges: Edges, cut: Flags, component: Indices) -> Patches:
    """Cut a mesh at some edges.

    Args:
        edges: (k, 2) i4, all edges of the mesh.
        cut: (k,) b1, edges that join no patch.
        component: (n_vertices,) i8, the connected component that each vertex is in.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n, (a, b) = len(component), edges[~cut].T
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), (n, n))
    patch = connected_components(graph, directed=False)[1].astype(np.int64)
    sizes = np.bincount(patch)
    component_of = np.empty(len(sizes), np.int64)
    component_of[patch] = component
    # The last patch of each component is its largest one; of equal ones, that of lowest number.
    order = np.lexsort((-np.arange(len(sizes)), sizes, component_of))
    is_last = np.append(np.diff(component_of[order]) != 0, True)
    largest = np.zeros(len(sizes), bool)
    largest[order[is_last]] = True
    return Patches(patch, sizes, ~largest[patch])


def reaches_of(
    positions: Positions,
    mesh: tuple[Edges, Faces, Indices],
    crossing: tuple[Indices, Faces],
) -> Floats:
    """Return how far the vertices behind each crossing have gone through, (n,) f8 [m].

    It is the largest distance of a vertex of the patch that is cut off there, from the component of
    the face that is crossed. If a component crosses itself, the faces of cut-off vertices are not
    among those that distances are taken from. It is 0 where nothing is cut off, because the contour
    ends at a border, or because the edge belongs to the larger side at both ends.

    Args:
        positions: (n_vertices, 3) f8 [m].
        mesh: The edges, (k, 2) i4; the faces, (m, 3) i4; and (n_vertices,) i8, the connected
            component that each vertex is in.
        crossing: (n,) i8, number of the edge of each crossing, and (n, 3) i4, the vertices of the
            face that it goes through.
    """
    edges, _, component = mesh
    numbers, crossed = crossing
    odd = np.bincount(numbers, minlength=len(edges)) % 2 == 1  # even: in and out again
    patches = find_patches(edges, odd, component)
    reaches = np.zeros(len(numbers))
    ends, rows = edges[numbers], np.flatnonzero(odd[numbers])
    # Of two ends that are cut off, the one in the smaller patch is farther through.
    sizes = np.where(patches.cut_off[ends], patches.sizes[patches.patch[ends]], len(component) + 1)
    end = ends[np.arange(len(ends)), sizes.argmin(axis=1)]
    rows = rows[patches.cut_off[end[rows]]]
    if len(rows) == 0:
        return reaches
    targets = component[crossed[rows, 0]]
    patch_of = patches.patch[end[rows]]
    cases = np.column_stack((patch_of, targets))
    cases, case_of = np.unique(cases, axis=0, return_inverse=True)
    reaches[rows] = _of_cases(positions, mesh, patches, cases)[case_of.reshape(-1)]
    return reaches


def _of_cases(
    positions: Positions, mesh: tuple[Edges, Faces, Indices], patches: Patches, cases: Indices
) -> Floats:
    """Return how far each patch is from a component that it has gone through, (n,) f8 [m].

    Args:
        positions: (n_vertices, 3) f8 [m].
        mesh: Edges, faces and components, as for `reaches_of`.
        patches: The patches.
        cases: (n, 2) i8, a patch and a component.
    """
    _, faces, component = mesh
    whole = ~patches.cut_off[faces].any(axis=1)
    members = np.argsort(patches.patch, kind="stable")
    begins = np.concatenate(([0], np.cumsum(patches.sizes)))
    found = np.zeros(len(cases))
    for target in np.unique(cases[:, 1]):
        own = np.flatnonzero(cases[:, 1] == target)
        groups = [members[begins[k] : begins[k + 1]] for k in cases[own, 0]]
        is_other = np.array([component[group[0]] != target for group in groups])
        of_target = component[faces[:, 0]] == target
        for flags, allowed in ((is_other, of_target), (~is_other, of_target & whole)):
            chosen = [groups[i] for i in np.flatnonzero(flags)]
            if chosen and allowed.any():
                found[own[flags]] = _farthest(positions, chosen, positions[faces[allowed]])
    return found


def _farthest(positions: Positions, groups: list[Indices], corners: Floats) -> Floats:
    """Return the largest distance of a vertex of each group from the nearest of some faces [m].

    Args:
        positions: (n_vertices, 3) f8 [m].
        groups: The vertices of each group.
        corners: (m, 3, 3) f8 [m], the corners of each face.
    """
    group_of = np.arange(len(groups)).repeat([len(group) for group in groups])
    points = positions[np.concatenate(groups)]
    sizes = _by_size(corners)
    low, high = np.full(len(points), np.inf), np.full(len(points), np.inf)
    for tree, radius, _ in sizes:
        distance = tree.query(points)[0]
        low, high = np.minimum(low, distance - radius), np.minimum(high, distance)
    # Only a point that may be the farthest one of its group needs its own distance.
    least = np.zeros(len(groups))
    np.maximum.at(least, group_of, low)
    kept = np.flatnonzero(high >= least[group_of])
    distances = np.full(len(kept), np.inf)
    for tree, radius, own in sizes:
        near = tree.query_ball_point(points[kept], high[kept] * (1.0 + 2.0**-40) + radius)
        counts = np.array([len(faces) for faces in near])
        row = np.arange(len(kept)).repeat(counts)
        face = np.concatenate([np.asarray(faces, np.int64) for faces in near])
        for begin in range(0, len(row), CHUNK):
            part = slice(begin, begin + CHUNK)
            apart = point_face_distances(points[kept[row[part]]], own[face[part]])
            np.minimum.at(distances, row[part], apart)
    farthest = np.zeros(len(groups))
    np.maximum.at(farthest, group_of[kept], distances)
    return farthest


def _by_size(corners: Floats) -> list[tuple[Any, float, Floats]]:
    """Sort faces by their size, so that a few large ones do not make all others candidates.

    Returns:
        For each size: a tree of the centres, the largest distance of a corner from its centre [m],
        and the corners of the faces.
    """
    from scipy.spatial import KDTree

    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    octaves = np.frexp(radii)[1]
    return [
        (KDTree(centres[octaves == octave]), float(radii[octaves == octave].max()), own)
        for octave in np.unique(octaves)
        for own in [corners[octaves == octave]]
    ]


def point_face_distances(points: Positions, corners: Floats) -> Floats:
    """Return the distance of each point from its own face, (n,) f8 [m].

    The nearest point of a face is the foot of the point on its plane, if that is inside, and else
    on one of its sides.

    Args:
        points: (n, 3) f8 [m].
        corners: (n, 3, 3) f8 [m], the corners of the face of each point.
    """
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length_sq = (normals * normals).sum(axis=1)
    inside, nearest = length_sq > 0.0, np.full(len(points), np.inf)
    for k in range(3):
        start, side = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        to_point = points - start
        inside &= (np.cross(side, to_point) * normals).sum(axis=1) >= 0.0
        whole = (side * side).sum(axis=1)
        along = (to_point * side).sum(axis=1)
        along = np.divide(along, whole, out=np.zeros_like(whole), where=whole > 0.0).clip(0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(to_point - along[:, None] * side, axis=1))
    height = np.abs(((points - corners[:, 0]) * normals).sum(axis=1))
    length = np.sqrt(length_sq)
    height = np.divide(height, length, out=np.zeros_like(height), where=length > 0.0)
    return np.where(inside, height, nearest)

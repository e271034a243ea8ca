"""Contours: their gradient is that of their length, and degenerate crossings stay bounded."""

import numpy as np
import pytest

from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from izo_ref.sequence.contours import ContourFinder
from validation.scenes.tangles import crossed_corner, crossed_sheets, layered_shells


def contours_of(positions, faces):
    """Return what finds the contours of a mesh, and those at rest."""
    edges = edges_of(faces)
    found = find_intersections(positions, edges, faces)
    finder = ContourFinder(edges, faces, len(positions))
    return finder, finder.find(positions, found.crossing_edges, found.crossed_faces)


def two_triangles(tip, size=1.0):
    """Return a level triangle, and an upright one whose lower corner is below it at `tip`."""
    low = np.array([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]])
    high = np.array([[*tip, -0.3], [tip[0] - 0.2, tip[1] + 0.1, 0.5], [tip[0] + 0.3, tip[1], 0.6]])
    return size * np.concatenate((low, high)), np.array([[0, 1, 2], [3, 4, 5]], np.int32)


def length_of(positions, faces):
    """Return the length of the one segment of two triangles."""
    _, contours = contours_of(positions, faces)
    points = np.einsum("ni,nik->nk", contours.edge_weights, positions[contours.edges])
    assert len(points) == 2
    return np.linalg.norm(points[1] - points[0])


def test_the_gradient_is_that_of_the_length():
    """Against differences of the length, for two triangles with one segment."""
    positions, faces = two_triangles((0.4, 0.3))
    finder, contours = contours_of(positions, faces)
    row, around = finder._faces_around(contours.edges)
    normals = np.tile([0.0, 0.0, 1.0], (2, 1))
    descent = finder._gradient(positions, contours.edges, normals, row, around)
    for i, (edge, weights) in enumerate(zip(contours.edges, contours.edge_weights, strict=True)):
        slopes = np.zeros(3)
        for k in range(3):
            ends = []
            for step in (1e-6, -1e-6):
                moved = positions.copy()
                # the whole edge moves; its other end point belongs to the other edge as well
                moved[edge, k] += step
                ends.append(_length_of_one_end(moved, edge, contours, i))
            slopes[k] = (ends[0] - ends[1]) / 2e-6
        exact = -slopes / max(np.linalg.norm(slopes), 1.0)
        assert weights.sum() == pytest.approx(1.0)
        assert descent[i] == pytest.approx(exact, abs=1e-6)


def _length_of_one_end(positions, edge, contours, i):
    """Return the length of the segment if only the crossing of one edge is computed anew."""
    a, b = positions[edge]
    moved = a + (a[2] / (a[2] - b[2])) * (b - a)
    start = two_triangles((0.4, 0.3))[0]
    other = contours.edge_weights[1 - i] @ start[contours.edges[1 - i]]
    return np.linalg.norm(moved - other)


def test_points_of_crossing_are_on_the_edge_and_in_the_face():
    for tangle in (crossed_corner(), layered_shells()):
        positions = tangle.positions_t0
        _, contours = contours_of(positions, tangle.faces)
        on_edge = np.einsum("ni,nik->nk", contours.edge_weights, positions[contours.edges])
        in_face = np.einsum("ni,nik->nk", contours.face_weights, positions[contours.faces])
        assert np.abs(on_edge - in_face).max() < 1e-14


def test_contours_are_told_apart():
    first, second = crossed_corner(), crossed_sheets()
    n = len(first.positions_t0)
    positions = np.concatenate((first.positions_t0, second.positions_t0 + 5.0))
    faces = np.concatenate((first.faces, second.faces + np.int32(n)))
    _, contours = contours_of(positions, faces)
    assert len(np.unique(contours.contour)) == 2
    is_first = contours.edges[:, 0] < n
    assert len(np.unique(contours.contour[is_first])) == 1
    assert len(np.unique(contours.contour[~is_first])) == 1


def test_the_corner_moves_out_of_the_sheet():
    """The corner is below the sheet, so its edges move up, and those of the sheet move down."""
    tangle = crossed_corner()
    _, contours = contours_of(tangle.positions_t0, tangle.faces)
    of_corner = contours.edges[:, 0] >= 17 * 17
    assert of_corner.any()
    assert not of_corner.all()
    assert (contours.directions[of_corner, 2] > 0.0).all()
    assert (contours.directions[~of_corner, 2] < 0.0).all()


# name: positions of the edge's two ends, over the face (0,0,0), (1,0,0), (0,1,0)
DEGENERATE = {
    "at a corner": ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]),
    "on a side": ([0.5, 0.0, -1.0], [0.5, 0.0, 1.0]),
    "end in the face": ([0.2, 0.2, 0.0], [0.2, 0.2, 1.0]),
    "in the plane": ([0.1, 0.1, 0.0], [0.3, 0.4, 0.0]),
    "nearly in the plane": ([0.1, 0.1, -1e-12], [0.3, 0.4, 1e-12]),
    "without length": ([0.2, 0.2, 0.0], [0.2, 0.2, 0.0]),
    "far shorter": ([0.2, 0.2, -1e-200], [0.2, 0.2, 1e-200]),
}


@pytest.mark.parametrize("name", DEGENERATE)
@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_degenerate_crossings_are_bounded(name, flat, size):
    """The face may have no area, too; the faces around the edge may lie in the crossed one."""
    face = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0 if flat else 0.0, 0.0 if flat else 1.0, 0.0]]
    tips = [[0.4, 0.1, 0.0], [0.1, 0.4, 0.0]]
    positions = size * np.array([*face, *DEGENERATE[name], *tips])
    faces = np.array([[0, 1, 2], [3, 4, 5], [4, 3, 6]], np.int32)
    finder = ContourFinder(edges_of(faces), faces, 7)
    contours = finder.find(positions, np.array([[3, 4]], np.int32), faces[:1])
    assert np.isfinite(contours.directions).all()
    assert np.linalg.norm(contours.directions) <= 1.0 + 1e-12
    for weights in (contours.edge_weights, contours.face_weights):
        assert (weights >= 0.0).all()
        assert weights.sum() == pytest.approx(1.0)

"""Elements that intersect at rest, against every pair in fractions, and the time it takes."""

import time
from itertools import combinations

import numpy as np
import pytest

import izo_ref
from izo_ref import errors
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from tests.helpers.shapes import grid
from tests.naive.simplices import simplices_meet


def expected_intersections(positions, edges, faces):
    """Return the description and the pairs of all intersections, by looking at all pairs."""

    def meet(a, b):
        return not set(a) & set(b) and simplices_meet(positions[list(a)], positions[list(b)])

    edges, faces = [tuple(e) for e in edges.tolist()], [tuple(f) for f in faces.tolist()]
    crossing = [(e, f) for e in edges for f in faces if meet(e, f)]
    touching = [((v,), f) for v in range(len(positions)) for f in faces if meet((v,), f)]
    touching += [(a, b) for a, b in combinations(edges, 2) if meet(a, b)]
    touching = [(len(a) == 2, *a, *b) for a, b in touching]
    pairs, through = set(touching), []
    for edge, face in crossing:
        five = {(False, v, *face) for v in edge}
        sides = [tuple(sorted((face[k], face[(k + 1) % 3]))) for k in range(3)]
        five |= {(True, *a, *b) for a, b in (sorted((edge, side)) for side in sides)}
        if five.isdisjoint(touching):
            through.append(f"edge {edge} and face {face}")
        pairs |= five
    return through, touching, sorted(pairs)


def description(through, touching, most):
    """Return what is said of some intersections."""
    said, touch = [], []
    for is_edge_edge, a, b, c, d in touching[:most]:
        sides = (f"edge ({a}, {b})", f"edge ({c}, {d})")
        touch.append(" and ".join(sides if is_edge_edge else (f"vertex {a}", f"face {(b, c, d)}")))
    if through:
        count = "1 edge that goes" if len(through) == 1 else f"{len(through)} edges that go"
        said.append(f"{count} through a face, the first: {'; '.join(through[:most])}")
    if touching:
        n = len(touching)
        count = "1 pair that touches" if n == 1 else f"{n} pairs that touch"
        said.append(f"{count}, the first: {'; '.join(touch)}")
    return ", and ".join(said)


def soup(rng, kind):
    """Return a few faces with vertices at few places: most of them touch in some way."""
    n = int(rng.integers(6, 11))
    positions = rng.integers(-1, 2, (n, 3)).astype(float)
    if kind == "tenths":
        positions *= 0.1
    elif kind == "in a plane":
        positions[:, 2] = 0.3
        positions[:, :2] += rng.choice([0.0, 0.1], (n, 2))
    elif kind == "two planes":
        positions = rng.normal(size=(n, 3))
        positions[:, 0] = rng.choice([0.0, 0.1], n)
    faces = [rng.choice(n, 3, replace=False) for _ in range(int(rng.integers(2, 6)))]
    return positions, np.array(faces, np.int32)


@pytest.mark.parametrize("kind", ["integers", "tenths", "in a plane", "two planes"])
def test_all_intersections_are_found_in_order(rng, kind):
    total = 0
    for _ in range(6):
        positions, faces = soup(rng, kind)
        edges = edges_of(faces)
        through, touching, pairs = expected_intersections(positions, edges, faces)
        found = find_intersections(positions, edges, faces)
        for most in (3, 1000):
            assert found.describe(most) == description(through, touching, most)
        got = found.pairs()
        rows = np.column_stack((got.is_edge_edge, got.nodes)).tolist()
        assert [tuple(row) for row in rows] == pairs
        total += found.n_found
    assert total > 10


def doubled_sheet(n, shift=0.0):
    """Return a flat sheet and its copy in the same plane."""
    positions, faces = grid(n)
    both = np.concatenate((positions, positions + (shift, 0.3 * shift, 0.0)))
    return both, np.concatenate((faces, faces + len(positions)))


@pytest.mark.parametrize("shift", [0.0, 0.37 / 40])
def test_sheets_in_one_plane_are_refused_quickly(shift):
    """The exact layer takes 0.1 CPU s, the shifted one 0.6; with fractions they took minutes."""
    positions, faces = doubled_sheet(5, shift)
    with pytest.raises(errors.InitialIntersectionError):
        izo_ref.Scene(positions, positions, faces)  # compiles
    positions, faces = doubled_sheet(40, shift)
    begin = time.process_time()
    with pytest.raises(errors.InitialIntersectionError):
        izo_ref.Scene(positions, positions, faces)
    assert time.process_time() - begin < 10.0

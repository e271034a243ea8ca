"""Faults of a mesh: faces without area and vertices that coincide, decided exactly."""

import numpy as np

from izo_ref.sequence.mesh_faults import find_faults


def test_each_fault_is_found_and_nothing_else():
    positions = np.array(
        [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (2.0, 0.0, 0.0), (-0.0, 1.0, 0.0)]
        + [(9.0, 9.0, 9.0)] * 2  # in no face
    )
    faces = np.array([(0, 1, 2), (0, 1, 3), (1, 1, 2), (3, 2, 4), (4, 3, 1)], np.int32)
    faults = find_faults(positions, faces)
    assert faults.repeated.tolist() == [2]
    assert faults.flat.tolist() == [1, 3]
    assert faults.coincident.tolist() == [4]


def test_thin_faces_far_from_the_origin_are_told_from_flat_ones(rng):
    """Corners on a line of floats, and the same with one corner one float away."""
    steps = np.array([(0.0,), (3.0,), (7.0,)]) * rng.integers(1, 100, size=3)
    line = (2.0**30 + steps).astype(float)
    bent = line.copy()
    bent[1, 2] = np.nextafter(bent[1, 2], np.inf)
    positions = np.concatenate((line, bent))
    faults = find_faults(positions, np.arange(6, dtype=np.int32).reshape(2, 3))
    assert faults.flat.tolist() == [0]


def test_a_good_mesh_has_no_faults(rng):
    positions = rng.normal(size=(30, 3)) * 10.0 ** rng.integers(-150, 150, size=(30, 1))
    faces = np.arange(30, dtype=np.int32).reshape(-1, 3)
    assert [len(part) for part in find_faults(positions, faces)] == [0, 0, 0]

import numpy as np
import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats import own_space
from izo_ref.formats.gltf_edit import offsets_from


def transform(rng, shift):
    matrix = np.eye(4)
    matrix[:3, :3] = rng.normal(size=(3, 3))
    matrix[3, :3] = rng.normal(size=3) * shift
    return matrix


def numbers(rng, lowest):
    return (rng.normal(size=(2000, 3)) * 10.0 ** rng.integers(lowest, 3, (2000, 3))).astype("f4")


@pytest.mark.parametrize("shift", [0, 1, 1e4, 1e9])
def test_positions_that_were_rounded_stay_when_they_are_rounded_again(shift):
    rng = np.random.default_rng(int(shift))
    for _ in range(10):
        matrix, old, base = transform(rng, shift), numbers(rng, -6), numbers(rng, -9)
        world = own_space.to_world(numbers(rng, -6), matrix)
        world += numbers(rng, -8)
        own = own_space.to_own(world, matrix, old)
        again = own_space.to_own(own_space.to_world(own, matrix), matrix, old)
        rounded = own_space.to_world(own, matrix)
        assert (own_space.to_world(again, matrix) == rounded).all()
        own = base + offsets_from(base, world, matrix, old)
        rounded = own_space.to_world(own, matrix)
        own = base + offsets_from(base, rounded, matrix, old)
        assert (own_space.to_world(own, matrix) == rounded).all()


def test_rounding_moves_positions_by_the_floats_of_the_file_alone():
    rng = np.random.default_rng(1)
    matrix, old = transform(rng, 10), numbers(rng, -6)
    own = numbers(rng, -6)
    found = own_space.to_own(own_space.to_world(own, matrix), matrix, old)
    largest = np.abs(own).max(axis=1, keepdims=True)
    assert (np.abs(found - own) <= 1e-9 * (largest + 10)).all()


def test_what_stays_keeps_its_bits():
    old = np.array([(1, -0.0, 3), (4, 5, 6)], "f4")
    world = own_space.to_world(old, np.eye(4))
    world[0, 1] = 0.0
    world[1, 2] = 7
    found = own_space.to_own(world, np.eye(4), old)
    assert np.signbit(found[0, 1])
    assert found[1].tolist() == [4, 5, 7]


@pytest.mark.parametrize("entry", [(0, 3, 1.0), (3, 0, np.inf), (0, 0, 0.0)])
def test_transforms_that_cannot_be_undone_are_refused(entry):
    matrix = np.eye(4)
    matrix[entry[:2]] = entry[2]
    with pytest.raises(FileFormatError, match="here: expected a transform"):
        own_space.check_matrix(matrix, "here")

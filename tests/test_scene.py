"""The arrays of a scene are checked once, when it is made."""

from pathlib import Path

import numpy as np
import pytest

import izo_ref
from izo_ref.base import errors
from tests.helpers.shapes import grid

START = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = np.array([[0, 1, 2], [0, 1, 3]])


def scene(**changes):
    """Return a scene at rest with some of its arguments replaced."""
    arguments = {"positions_t0": START, "positions_t1": START, "faces": FACES}
    return izo_ref.Scene(**(arguments | changes))


def changed(array, index, value):
    """Return a copy of an array with one entry replaced."""
    array = np.array(array, dtype=float if isinstance(value, float) else None)
    array[index] = value
    return array


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"positions_t0": START[:, :2]}, errors.ShapeError, ["positions_t0", "(n, 3)", "(4, 2)"]),
        ({"positions_t1": START[:3]}, errors.ShapeError, ["positions_t1", "(4, 3)", "(3, 3)"]),
        ({"positions_t0": [["a"] * 3]}, errors.ShapeError, ["positions_t0", "numbers"]),
        (
            {"positions_t1": changed(START, (2, 1), np.nan)},
            errors.NonFiniteError,
            ["positions_t1", "found 1", "nan", "[2, 1]"],
        ),
        (
            {"positions_t0": changed(START, (3, 0), -np.inf)},
            errors.NonFiniteError,
            ["positions_t0", "-inf", "[3, 0]"],
        ),
        ({"faces": FACES[:, :2]}, errors.ShapeError, ["faces", "(2, 2)"]),
        ({"faces": FACES + 0.5}, errors.ShapeError, ["faces", "integers", "0.5", "[0, 0]"]),
        (
            {"faces": changed(FACES, (1, 2), 4)},
            errors.IndexRangeError,
            ["faces", "0 to 3", "row 1", "[0, 1, 4]"],
        ),
        ({"faces": changed(FACES, (0, 0), -1)}, errors.IndexRangeError, ["row 0", "[-1, 1, 2]"]),
        (
            {"faces": changed(FACES, (1, 2), 1)},
            errors.DegenerateFaceError,
            ["face 1", "[0, 1, 1]"],
        ),
        ({"masses": [1, 1, 0, 1]}, errors.MassError, ["masses", "> 0", "0.0", "vertex 2"]),
        ({"masses": [1, 1, 1, -2]}, errors.MassError, ["-2.0", "vertex 3"]),
        ({"masses": [1, 1, np.inf, 1]}, errors.NonFiniteError, ["masses", "inf"]),
        ({"masses": [1, 1]}, errors.ShapeError, ["masses", "(4)", "(2,)"]),
        ({"pinned": [0, 2, 0, 0]}, errors.ShapeError, ["pinned", "bool", "int64"]),
        ({"positions_t1": START * 1j}, errors.ShapeError, ["positions_t1", "real", "complex128"]),
        ({"positions_t0": START.astype(str)}, errors.ShapeError, ["positions_t0", "real"]),
        ({"faces": [[0, 1, 2], [0, 1]]}, errors.ShapeError, ["faces", "3 indices", "2 in row 1"]),
        ({"faces": [0, 1, 2, 0, 1, 3]}, errors.ShapeError, ["faces", "(6,)", "reshape(-1, 3)"]),
        ({"faces": [[0, 1, 2, 3]]}, errors.ShapeError, ["faces", "(1, 4)", "quad"]),
        ({"faces": [[0, 1, 2, 3, 0]]}, errors.ShapeError, ["faces", "(1, 5)", "polygon"]),
        ({"faces": FACES + 1}, errors.IndexRangeError, ["row 1", "faces - 1"]),
        ({"faces": [[0, 1, None]]}, errors.ShapeError, ["faces", "integers"]),
        ({"faces": [["0", "1", "2"]]}, errors.ShapeError, ["faces", "integers"]),
        ({"masses": 0.0}, errors.MassError, ["masses", "> 0", "vertex 0"]),
        ({"pinned": [True]}, errors.ShapeError, ["pinned", "(4,)", "(1,)"]),
        ({"initial_intersections": "no"}, errors.OptionError, ["'raise'", "'no'"]),
    ],
)
def test_bad_input_is_refused_and_its_first_bad_entry_named(changes, error, words):
    with pytest.raises(error) as caught:
        scene(**changes)
    assert isinstance(caught.value, izo_ref.IzoError)
    for word in words:
        assert word in str(caught.value)


def test_a_scene_fills_in_defaults_and_converts_types():
    made = scene()
    assert made.positions_t0.dtype == np.float64
    assert made.faces.dtype == np.int32
    assert made.masses.tolist() == [1.0] * 4
    assert not made.pinned.any()
    assert made.excluded is None
    assert made.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3]]


@pytest.mark.parametrize("faces", [FACES.astype(float), FACES.astype(object), FACES.tolist()])
def test_whole_numbers_of_any_type_are_indices(faces):
    np.testing.assert_array_equal(scene(faces=faces).faces, FACES)


@pytest.mark.parametrize("masses", [2.0, np.float32(2.0), [[2.0]] * 4, np.full(4, 2)])
def test_one_mass_or_a_column_of_masses_is_taken(masses):
    assert scene(masses=masses).masses.tolist() == [2.0] * 4


@pytest.mark.parametrize("kind", [int, float, np.uint8])
def test_flags_may_be_zeros_and_ones(kind):
    made = scene(pinned=np.array([0, 1, 1, 0], kind))
    assert made.pinned.tolist() == [False, True, True, False]


@pytest.mark.parametrize("mass", [0.0, -1.0, np.inf, np.nan, 7.0])
def test_the_mass_of_a_pinned_vertex_may_be_anything(mass):
    """The result is that with a mass of 1 kg, bit for bit."""
    fallen = changed(START, (3, 2), -0.5)

    def resolved(mass):
        masses, pinned = changed(np.ones(4), 0, mass), [True, False, False, False]
        return izo_ref.resolve(scene(positions_t1=fallen, masses=masses, pinned=pinned), 0.01)

    np.testing.assert_array_equal(resolved(mass).positions, resolved(1.0).positions)
    with pytest.raises(errors.NonFiniteError, match="nan"):
        scene(masses=changed(np.ones(4), 1, np.nan), pinned=[True, False, False, False])


def test_a_vertex_without_mass_is_not_set_free():
    made = scene(masses=changed(np.ones(4), 2, 0.0), pinned=[False, False, True, False])
    result, free = izo_ref.resolve(made, 0.01), np.zeros(4, bool)
    with pytest.raises(errors.MassError, match="vertex 2"):
        made.after(result, START, pinned=free)
    assert made.after(result, START, masses=3.0, pinned=free).masses.tolist() == [3.0] * 4


@pytest.mark.parametrize("call", [izo_ref.resolve, izo_ref.find_impacts, izo_ref.plan])
def test_what_is_no_scene_is_refused(call):
    with pytest.raises(
        errors.OptionError, match=r"scene: expected a Scene, got str.*izo_ref.Scene"
    ):
        call("step.npz")
    with pytest.raises(errors.OptionError, match=r"got (Posix|Windows)Path"):
        izo_ref.certify_path(Path("step.npz"), START)


def test_what_is_no_options_is_refused():
    with pytest.raises(errors.OptionError, match="options: expected Options, got dict"):
        izo_ref.resolve(scene(), options={})
    with pytest.raises(errors.OptionError, match="on_iteration: expected a function"):
        izo_ref.resolve(scene(), on_iteration=1)
    with pytest.raises(errors.OptionError, match="options: expected Options, got dict"):
        izo_ref.plan(scene(), {"relinearize": 1})


def test_input_is_copied():
    start = START.copy()
    made = scene(positions_t0=start)
    start[0] = 9.0
    assert made.positions_t0[0].tolist() == [0, 0, 0]


@pytest.mark.parametrize("faces", [[], np.empty((0, 3), int)])
def test_a_scene_may_have_no_faces(faces):
    made = scene(faces=faces)
    result = izo_ref.resolve(made)
    assert result.status is izo_ref.Status.FREE


def crossing_sheets():
    """Return positions and faces of two sheets that intersect."""
    a, faces = grid(4)
    b = a[:, [0, 2, 1]] + (0.05, 0.4, -0.45)
    return np.concatenate((a, b)), np.concatenate((faces, faces + 16))


def test_initial_intersections_are_refused_and_named():
    positions, faces = crossing_sheets()
    with pytest.raises(errors.InitialIntersectionError) as caught:
        izo_ref.Scene(positions, positions, faces)
    assert "edge (" in str(caught.value)
    assert "face (" in str(caught.value)
    assert len(caught.value.pairs.nodes) > 0


def test_initial_intersections_can_be_left_out_and_are_listed():
    positions, faces = crossing_sheets()
    made = izo_ref.Scene(positions, positions + 0.01, faces, initial_intersections="exclude")
    assert len(made.excluded.nodes) > 0
    result = izo_ref.resolve(made)
    assert result.certificate.excluded is made.excluded
    assert result.certificate.free


def test_touching_at_the_start_is_an_intersection():
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 0], [0, 0, 1], [1, 0, 1.0]])
    with pytest.raises(errors.InitialIntersectionError):
        izo_ref.Scene(start, start, [[0, 1, 2], [3, 4, 5]])
    start[3, 2] = np.nextafter(0.0, 1.0)
    izo_ref.Scene(start, start, [[0, 1, 2], [3, 4, 5]])


def test_a_face_folded_flat_onto_its_neighbour_is_found():
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, 0.0]])
    with pytest.raises(errors.InitialIntersectionError):
        izo_ref.Scene(start, start, [[0, 1, 2], [1, 0, 3]])


@pytest.mark.parametrize("height", [0.0, -5e-324, -1e-17])
def test_a_start_that_crosses_by_less_than_rounding_is_refused(height):
    """The corner touches the face or is just below it, where no sign in floats is certain."""
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, height], [0, 0, 1], [1, 0, 1]])
    with pytest.raises(izo_ref.base.errors.InitialIntersectionError):
        izo_ref.Scene(start, start, [[0, 1, 2], [3, 4, 5]])


@pytest.mark.parametrize("name", ["weld", "masses", "positions_t1"])
def test_integers_that_no_float_holds_are_refused(name):
    start = np.eye(3)
    arrays = {"positions_t0": start, "positions_t1": start, "faces": [[0, 1, 2]]}
    with pytest.raises(errors.IzoError, match=f"{name}: expected"):
        izo_ref.Scene(**(arrays | {name: 10**400}))

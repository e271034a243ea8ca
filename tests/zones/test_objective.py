"""The objective of a step."""

import pytest

import izo_ref
from tests.helpers.shapes import vertex_over_face


def test_the_objective_is_divided_by_the_mass_of_unpinned_vertices():
    scene = vertex_over_face(masses=(7.0, 8.0, 9.0, 0.5), pinned=(True, True, True, False))
    result = izo_ref.resolve(scene, thickness=0.125)
    # The unpinned masses are 0.5, 1 and 1, and the first moves by 1.125.
    assert result.objective == pytest.approx(0.5 * 1.125**2 / 2.5)

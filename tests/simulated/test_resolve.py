"""A whole step with detection on the device, against one of the processor alone."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Status
from tests.shapes import two_sheets, vertex_over_face

pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.mark.parametrize("name", ["face", "sheets"])
def test_a_step_ends_as_on_the_processor(rng, name):
    scene = vertex_over_face() if name == "face" else two_sheets(rng, 3)
    found = izo_ref.resolve(scene, 1e-3, device="cuda")
    expected = izo_ref.resolve(scene, 1e-3)
    assert expected.status is Status.FREE
    assert len(expected.impacts.toi) > 0
    assert found.status is expected.status
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(found.multipliers, expected.multipliers)
    assert [i.moved for i in found.history] == [i.moved for i in expected.history]
    assert found.history[0].candidates == expected.history[0].candidates

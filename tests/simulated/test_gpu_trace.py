"""A trace of a step on the GPU has the arrays of one on the CPU."""

import numpy as np
import pytest

from izo_ref.porting.trace import trace_resolve
from izo_ref.porting.trace_files import load_arrays
from tests.helpers.shapes import pinched_sheet, two_sheets

pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.mark.parametrize("name", ["sheets", "blocked"])
def test_a_trace_of_a_gpu_is_that_of_the_cpu(rng, tmp_path, name):
    blocked = pinched_sheet(-0.01, bump=0.2, side=2)
    scene = two_sheets(rng, 2) if name == "sheets" else blocked
    found = {}
    for device in ("cpu", "cuda"):
        trace_resolve(scene, tmp_path / device, 1e-3, device)
        found[device] = load_arrays(tmp_path / device)
    assert set(found["cuda"]) == set(found["cpu"])
    for key, expected in found["cpu"].items():
        assert found["cuda"][key] == pytest.approx(expected, rel=1e-12), key
        assert found["cuda"][key].dtype == np.asarray(expected).dtype

"""The occupancy of kernels is what NVIDIA's tables and calculator say."""

import pytest

from validation import ptx
from validation.occupancy import MULTIPROCESSORS, occupancy

A100, ADA, H100 = (8, 0), (8, 9), (9, 0)


# The shares are those of NVIDIA's occupancy calculator. Each case is limited by what is named.
@pytest.mark.parametrize(
    ("capability", "n_threads", "registers", "shared_bytes", "blocks", "share"),
    [
        pytest.param(A100, 256, 32, 0, 8, 1.0, id="threads"),
        pytest.param(A100, 256, 64, 0, 4, 0.5, id="registers"),
        pytest.param(A100, 256, 40, 0, 6, 0.75, id="registers in units of a warp"),
        pytest.param(A100, 128, 255, 0, 2, 0.125, id="most registers"),
        pytest.param(A100, 32, 16, 0, 32, 0.5, id="blocks"),
        pytest.param(A100, 1024, 32, 0, 2, 1.0, id="large blocks"),
        pytest.param(A100, 128, 32, 48 << 10, 3, 0.1875, id="shared memory"),
        pytest.param(A100, 1024, 65, 0, 0, 0.0, id="no block fits"),
        pytest.param(ADA, 256, 32, 0, 6, 1.0, id="8.9: threads"),
        pytest.param(ADA, 1024, 32, 0, 1, 2.0 / 3.0, id="8.9: large blocks"),
        pytest.param(ADA, 32, 16, 0, 24, 0.5, id="8.9: blocks"),
        pytest.param(ADA, 128, 32, 99 << 10, 1, 1.0 / 12.0, id="8.9: shared memory"),
        pytest.param(H100, 128, 168, 0, 3, 0.1875, id="9.0: registers"),
        pytest.param(H100, 128, 32, 227 << 10, 1, 0.0625, id="9.0: shared memory"),
    ],
)
def test_known_occupancies(capability, n_threads, registers, shared_bytes, blocks, share):
    found = occupancy(capability, n_threads, registers, shared_bytes)
    assert found.blocks == blocks
    assert found.share == pytest.approx(share, abs=1e-12)
    assert found.threads == blocks * n_threads


def test_every_capability_that_is_compiled_for_has_its_limits():
    assert set(ptx.CAPABILITIES) == set(MULTIPROCESSORS)
    assert (min(MULTIPROCESSORS), max(MULTIPROCESSORS)) == ptx.TESTED

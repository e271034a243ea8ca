"""Runs tests/simulated in a separate process, in which CUDA kernels run in Python."""

import os
import subprocess
import sys
from importlib.util import find_spec

import pytest

from tests.helpers.steps import SEED

# They take 90 s of CPU time, several times as long beside other work. A test that does not end is
# stopped.
LIMIT_S = 600.0


@pytest.mark.first
@pytest.mark.skipif(find_spec("numba_cuda") is None, reason="needs numba-cuda: izo-ref[cuda]")
def test_kernels_of_the_device_in_python(request):
    simulator = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1", "IZO_SEED": str(SEED)}
    slow = ["--slow"] if request.config.getoption("--slow") else []
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "tests/simulated", *slow],
        env=os.environ | simulator,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    print(done.stdout)
    assert done.returncode == 0, done.stdout

"""Tests of CUDA kernels that run in Python.

tests/cuda/test_simulator.py starts them in a process with the variables of the simulator;
without these variables, none is collected.
"""

import os

if os.environ.get("NUMBA_ENABLE_CUDASIM", "0") == "0":
    collect_ignore_glob = ["test_*.py"]
else:
    from validation.simulator import prepare

    prepare()

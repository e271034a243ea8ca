"""Run by tests/cuda/test_simulator.py, in a process in which kernels run in Python."""

import os

if os.environ.get("NUMBA_ENABLE_CUDASIM", "0") == "0":
    collect_ignore_glob = ["test_*.py"]
else:
    from validation.simulator import prepare

    prepare()

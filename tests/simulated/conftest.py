"""Run by tests/test_simulator.py, in a process in which kernels run in Python."""

import os
import sys

if os.environ.get("NUMBA_ENABLE_CUDASIM", "0") == "0":
    collect_ignore_glob = ["test_*.py"]
else:
    # The simulator has a thread of the system for each of a block, and one that asks them all
    # without a pause: with Python's 5 ms each of its turns takes five times as long in all.
    sys.setswitchinterval(1e-4)

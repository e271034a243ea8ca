"""numba's simulator, in which kernels run in Python: what it takes to run ours in it."""

import sys
import threading

from numba.cuda.simulator.kernelapi import FakeCUDAShared


def prepare():
    """Call once, before a kernel runs."""
    # The simulator has a thread of the system for each of a block, and one that asks them all
    # without a pause: with Python's 5 ms each of its turns takes five times as long in all.
    sys.setswitchinterval(1e-4)

    # It looks whether another thread of the block has made the shared array, and makes it if not:
    # two threads at once would each make their own. Kernels here have one at most, so that all
    # calls may look like one.
    make_or_find, one_at_a_time = FakeCUDAShared.array, threading.Lock()

    def shared_array(self, *arguments, **named):
        with one_at_a_time:
            return make_or_find(self, *arguments, **named)

    FakeCUDAShared.array = shared_array

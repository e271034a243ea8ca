"""Prepare the simulator of numba-cuda, in which kernels run as Python, for our kernels."""

import sys
import threading
from typing import Any

from numba.cuda.simulator.kernelapi import FakeCUDAShared


def prepare() -> None:
    """Change settings of Python and of the simulator; call this once, before a kernel runs."""
    # The simulator starts one thread of the operating system for each thread of a block, and one
    # more thread asks them all for their state without a pause. With Python's usual switch interval
    # of 5 ms, that thread keeps each of its turns too long, and everything takes five times as
    # long.
    sys.setswitchinterval(1e-4)

    # The first thread of a block that asks for a shared array makes it, and the others find it. The
    # simulator does not lock this step, so two threads at once would each make an array of their
    # own. It tells shared arrays apart by the line of the call. Behind the lock all calls come from
    # one line, which is right because a kernel here has at most one shared array.
    make_or_find, lock = FakeCUDAShared.array, threading.Lock()

    def shared_array(self: FakeCUDAShared, *arguments: Any, **named: Any) -> Any:
        with lock:
            return make_or_find(self, *arguments, **named)

    FakeCUDAShared.array = shared_array

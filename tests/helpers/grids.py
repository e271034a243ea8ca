"""Run the blocks of a simulated kernel at the same time, so that they can wait for each other.

The CUDA simulator itself runs one block after the other.
"""

import threading
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
from numba.cuda.simulator import kernel, kernelapi

from validation.simulator import start_next_thread

TIMEOUT_S = 60.0  # a wait that some threads never reach fails after this time


@contextmanager
def blocks_together(function):
    """Run all blocks of the kernel of this function at once, each with its own shared memory."""
    run_block, make_shared = kernel.BlockManager.run, kernelapi.FakeCUDAShared.array
    launch = {}

    def run(manager, point, *arguments):
        if manager._f is not function:
            run_block(manager, point, *arguments)
            return
        n_blocks, n_threads = (int(np.prod(d)) for d in (manager._grid_dim, manager._block_dim))
        if point[0] == 0:
            barrier = threading.Barrier(n_blocks * n_threads, timeout=TIMEOUT_S)
            launch.update(barrier=barrier, running=[], failed=[])
        thread = threading.Thread(target=attempt, args=(manager, point, *arguments))
        launch["running"].append(thread)
        thread.start()
        if point[0] == n_blocks - 1:
            for thread in launch["running"]:
                thread.join()
            if launch["failed"]:
                raise launch["failed"][0]

    def attempt(*arguments):
        """Run one block, keep its error, and release the others."""
        try:
            run_block(*arguments)
        except Exception as error:
            launch["failed"].append(error)
            launch["barrier"].abort()

    def shared_array(shared, shape, dtype, alignment=None):
        manager = threading.current_thread()._manager
        if manager._f is not function:
            return make_shared(shared, shape, dtype, alignment)
        memory = manager.__dict__.setdefault("memory", np.zeros(shared._dynshared_size, np.byte))
        return memory.view(kernelapi.numpy_support.as_dtype(dtype))

    def wait_for_all(group):
        start_next_thread()
        launch["barrier"].wait()

    with (
        patch.object(kernel.BlockManager, "run", run),
        patch.object(kernelapi.FakeCUDAShared, "array", shared_array),
        patch.object(kernelapi.GridGroup, "sync", wait_for_all),
    ):
        yield

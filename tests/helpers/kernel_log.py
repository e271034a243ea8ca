"""Run kernels of the simulator in random schedules, and log what each thread reads and writes.

All blocks of a launch run at the same time. One thread runs at a time; a seed draws which one goes
on after a wait, and after some accesses.
"""

import sys
import threading
from contextlib import ExitStack, contextmanager
from itertools import accumulate
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numba.cuda.simulator import kernel, kernelapi

from izo_ref.base.cuda import simulated
from tests.helpers.logged import ATOMIC, Users, logged
from tests.helpers.turns import Turns

ATOMICS = ("add", "max", "min", "cas", "exch")
BLOCK, GRID = "block", "grid"


class KernelLog:
    """Accesses of the threads of launches, to arrays and to shared memory.

    Args:
        seed: Draws the schedule.

    Attributes:
        sites: File and line of each wait.
        kernels: Module and name of the kernel of each launch.
        launches: Of each launch, its accesses: (block and thread, waits of that thread, number of
            those before the access, address, kind, bytes that are written).
    """

    def __init__(self, seed):
        """Begin with nothing logged."""
        self.sites, self.kernels, self.launches, self._seed = set(), [], [], seed

    def add(self, address, kind, value=None):
        """Log an access, if a thread of a kernel makes it."""
        thread = threading.current_thread()
        if isinstance(thread, KernelThread):
            kind = ATOMIC if thread.in_atomic else kind
            access = thread.key, thread.waits, len(thread.waits), address, kind, value
            self.launches[-1].append(access)
            if not thread.in_atomic:
                thread.turns.access(thread.rank)

    def conflicts(self, without=None):
        """Return the number of conflicts of all launches.

        A conflict is a number that one thread writes and another one reads or writes, with no wait
        of the block between them, or of the grid if they are in different blocks.

        Args:
            without: File and line of a wait, as in `sites`, which counts as none.
        """
        return sum(_conflicts_of(launch, without) for launch in self.launches)

    def needless_waits(self):
        """Return the waits that could be left out without a conflict."""
        return sorted(site for site in self.sites if self.conflicts(site) == 0)

    @contextmanager
    def running(self, only=None):
        """Run and log the kernels that are launched inside the block.

        Args:
            only: Module and name of the only kernel to log; None logs all.
        """
        blocks, make = [], simulated.array_of
        run_as_ever, make_shared = kernel.BlockManager.run, kernelapi.FakeCUDAShared.array

        def run_block(manager, point, *arguments):
            if only not in (None, _name(manager._f)):
                run_as_ever(manager, point, *arguments)
                return
            n_blocks, n_threads = (int(np.prod(d)) for d in (manager._grid_dim, manager._block_dim))
            blocks.append((manager, point, arguments))
            if len(blocks) == n_blocks:
                self.launches.append([])
                self.kernels.append(_name(manager._f))
                self._run(list(blocks), n_threads)
                blocks.clear()

        def array_of(array):
            own = make(array)
            own._ary = logged(own._ary, self)
            return own

        def shared_array(*arguments):
            is_own = isinstance(threading.current_thread(), KernelThread)
            return (self._shared if is_own else make_shared)(*arguments)

        with ExitStack() as stack:
            for owner, name, own in (
                (kernel.BlockManager, "run", run_block),
                (simulated, "array_of", array_of),
                (kernelapi.FakeCUDAShared, "array", shared_array),
                (kernelapi.GridGroup, "sync", lambda _: threading.current_thread().wait(GRID)),
                *((kernelapi.FakeCUDAAtomic, name, _atomic(name)) for name in ATOMICS),
            ):
                stack.enter_context(patch.object(owner, name, own))
            yield self

    def _run(self, blocks, n_threads):
        n = len(blocks) * n_threads
        together = [range(k - k % n_threads, k - k % n_threads + n_threads) for k in range(n)]
        turns = Turns([{BLOCK: together[k], GRID: range(n)} for k in range(n)], self._seed, (GRID,))

        def work(rank):
            manager, point, arguments = blocks[rank // n_threads]
            return KernelThread(self, turns, rank, manager, point, rank % n_threads, arguments)

        turns.run(work)

    def _shared(self, shared, shape, dtype, alignment=None):
        """Return shared memory of the block of this thread; dynamic if the shape is 0."""
        own = np.dtype(str(dtype))  # of a type of numba, or of numpy
        memory = threading.current_thread().manager.__dict__.setdefault("memory", {})
        if shape == 0:
            dynamic = memory.setdefault(0, np.full(shared._dynshared_size, 0xFF, np.uint8))
            return logged(dynamic.view(own), self)
        return logged(memory.setdefault(_caller(), np.full(shape, -7, own)), self)


class KernelThread(threading.Thread):
    """A thread of a block; a kernel asks the current thread for its index."""

    def __init__(self, log, turns, rank, manager, point, index, arguments):
        """Prepare a thread."""
        super().__init__(daemon=True)
        self.blockIdx, self.threadIdx = kernelapi.Dim3(*point), kernelapi.Dim3(index, 0, 0)
        self.log, self.turns, self.rank, self.manager = log, turns, rank, manager
        self.key, self.in_atomic = (point[0], index), False
        self.waits = []  # (site, is of the grid)
        self._arguments = arguments

    def run(self):
        """Run the kernel."""
        error = None
        try:
            self.turns.begin(self.rank)
            self.manager._f(*self._arguments)
        except Exception as caught:
            error = caught
        self.turns.end(self.rank, error)

    def syncthreads(self):
        """Wait for the block."""
        self.wait(BLOCK)

    def wait(self, group):
        """Wait for the block or the grid."""
        site = _caller()
        self.log.sites.add(site)
        self.turns.wait(self.rank, group)
        self.waits.append((site, group == GRID))


def _caller():
    """Return file and line of the code of the package or of a test that called."""
    frame = sys._getframe(1)
    while not {"izo_ref", "simulated"} & {*Path(frame.f_code.co_filename).parts[-4:-1]}:
        frame = frame.f_back
    return Path(frame.f_code.co_filename).name, frame.f_lineno


def _name(function):
    """Return the module and the name of a kernel."""
    return function.__module__, function.__name__


def _atomic(name):
    """Return an atomic operation of the simulator whose access is logged as one."""
    change = getattr(kernelapi.FakeCUDAAtomic, name)

    def logged_change(self, *arguments):
        thread = threading.current_thread()
        if not isinstance(thread, KernelThread):
            return change(self, *arguments)
        thread.in_atomic = True
        try:
            return change(self, *arguments)
        finally:
            thread.in_atomic = False

    return logged_change


def _conflicts_of(accesses, without):
    """Return the number of conflicts of a launch."""
    in_block, in_grid = {}, {}
    phases = {}  # of each thread: by its number of waits, those that count, and those of the grid
    for (block, thread), waits, n_waits, address, kind, value in accesses:
        if (block, thread) not in phases:
            kept = [site != without for site, _ in waits]
            of_grid = [keep and is_grid for keep, (_, is_grid) in zip(kept, waits, strict=True)]
            phases[block, thread] = [[0, *accumulate(flags)] for flags in (kept, of_grid)]
        of_block, of_grid = (counts[n_waits] for counts in phases[block, thread])
        in_block.setdefault((block, of_block, address), Users()).add(thread, kind, value)
        in_grid.setdefault((of_grid, address), Users()).add(block, kind, value)
    return sum(own.conflict() for own in (*in_block.values(), *in_grid.values()))

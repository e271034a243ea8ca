"""Prepare the simulator of numba-cuda, in which kernels run as Python, for our kernels.

The simulator starts one thread of the operating system for each thread of a block, and one more
thread asks them all for their state without a pause. Python runs one thread at a time, so most of
the CPU time goes into these questions.

Here one thread of the operating system runs the threads of a block one after the other, until one
of them waits at a barrier. That thread then sleeps, and a new thread of the operating system runs
the next threads of the block. So each thread of the block runs as far as it can before the next
one starts. Where a barrier is missing, it reads what the others have not written yet, or it
overwrites what the others have not read yet.
"""

import sys
import threading
from typing import Any

import numpy as np
from numba.cuda.simulator import kernel
from numba.cuda.simulator.kernelapi import Dim3, FakeCUDAShared


def prepare() -> None:
    """Change settings of Python and of the simulator; call this once, before a kernel runs."""
    # Threads that leave a barrier together then alternate at many places of the kernel.
    sys.setswitchinterval(1e-4)
    block_manager: Any = kernel.BlockManager
    block_manager.run = _run_block

    # The first thread of a block that asks for a shared array makes it, and the others find it. The
    # simulator does not lock this step, so two threads at once would each make an array of their
    # own. It identifies a shared array by the line that asks for it. With the lock, that line is
    # always the same. This is right as long as a kernel has at most one shared array.
    make_or_find, lock = FakeCUDAShared.array, threading.Lock()

    def shared_array(self: FakeCUDAShared, *arguments: Any, **named: Any) -> Any:
        with lock:
            return make_or_find(self, *arguments, **named)

    FakeCUDAShared.array = shared_array


def start_next_thread() -> None:
    """Start the next thread of the block; a kernel calls this before it waits for other blocks."""
    thread: Any = threading.current_thread()
    thread.block.start_next()


def _run_block(manager: Any, block_index: tuple[int, ...], *arguments: Any) -> None:
    """Run one block of a launch, in place of `BlockManager.run`.

    Raises:
        Exception: The first exception of a thread, with the index of the thread in its message.
    """
    block = _Block(manager, block_index, arguments)
    block.start_next()
    block.ended.wait()
    if block.error is not None:
        raise block.error


class _Block:
    """The threads of one block and their barrier.

    Attributes:
        manager: The simulator's record of the block.
        index: The index of the block in its launch.
        arguments: The arguments of the kernel.
        ended: It is set when all threads have ended, or when one has failed.
        error: The first exception of a thread, or None.
    """

    def __init__(self, manager: Any, index: tuple[int, ...], arguments: tuple[Any, ...]) -> None:
        self.manager, self.index, self.arguments = manager, index, arguments
        self.ended = threading.Event()
        self.error: Exception | None = None
        self._to_start = iter(np.ndindex(*manager._block_dim))
        self._alive = int(np.prod(manager._block_dim))
        self._waiting, self._rounds = 0, 0
        self._changed = threading.Condition()

    def start_next(self) -> None:
        """Start a thread that runs those that have not started, one after the other."""
        with self._changed:
            place = next(self._to_start, None)
        if place is not None:
            _Thread(self, place).start()

    def end_one(self) -> tuple[int, ...] | None:
        """Note that the caller's thread has ended; return the index of the next one, or None."""
        with self._changed:
            self._alive -= 1
            self._open_barrier()
            if self._alive == 0:
                self.ended.set()
            return next(self._to_start, None)

    def wait(self) -> None:
        """Wait until every thread of the block that has not ended waits here."""
        self.start_next()
        with self._changed:
            own_round = self._rounds
            self._waiting += 1
            self._open_barrier()
            while self._rounds == own_round:
                if self.error is not None:
                    raise RuntimeError("another thread of the block has failed")
                self._changed.wait()

    def fail(self, error: Exception) -> None:
        """Wake the threads that wait, and end the block."""
        with self._changed:
            self.error = self.error or error
            self._changed.notify_all()
        self.ended.set()

    def _open_barrier(self) -> None:
        if 0 < self._waiting == self._alive:
            self._waiting = 0
            self._rounds += 1
            self._changed.notify_all()


class _Thread(threading.Thread):
    """Runs threads of a block; a kernel asks the current thread for its index."""

    def __init__(self, block: _Block, place: tuple[int, ...]) -> None:
        super().__init__(daemon=True)
        self.block, self._manager = block, block.manager
        self.blockIdx, self.threadIdx = Dim3(*block.index), Dim3(*place)

    def run(self) -> None:
        place: tuple[int, ...] | None = tuple(self.threadIdx)
        while place is not None:
            self.threadIdx = Dim3(*place)
            try:
                self._manager._f(*self.block.arguments)
            except Exception as error:
                named = type(error)(f"tid={list(place)} ctaid={list(self.blockIdx)}: {error}")
                self.block.fail(named.with_traceback(error.__traceback__))
                return
            place = self.block.end_one()

    def syncthreads(self) -> None:
        self.block.wait()

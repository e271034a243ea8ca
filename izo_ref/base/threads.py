"""Share the items of a kernel's loop among threads.

Kernels release Python's global lock, so threads of Python run them side by side. The calling thread
and the helpers take one part of the items after the other, until none is left. A helper that the
operating system wakes late finds nothing left, and nobody waits for it. A launch on two threads
takes 20 to 30 us more than its work, also on a busy machine.
"""

import os
import threading
from collections.abc import Callable, Sequence
from itertools import count
from queue import SimpleQueue
from typing import Any

import numba

# Parts of the items for each thread. The fewer there are, the longer a thread may have to wait for
# another one; each costs a call, and a thread that takes one may have to wait for Python's lock.
# sphere-10k takes 98 ms on two threads with one part each, 92 with 2, 93 with 4 and 95 with 8.
PARTS = 4


class _Launch:
    """One launch: the parts that no thread has taken yet, and what is left to wait for.

    Args:
        kernel: The function; it gets the first item of a part, the end of the part, and the
            arguments.
        arguments: All other arguments.
        parts: Ranges of items.
    """

    def __init__(
        self, kernel: Callable[..., None], arguments: Sequence[Any], parts: Sequence[range]
    ) -> None:
        """Prepare the parts; each thread that calls `work` takes some of them."""
        self._kernel, self._arguments = kernel, arguments
        # each of these two is advanced by one call of C, which no other thread can interrupt
        self._parts, self._unfinished = iter(parts), count(len(parts) - 1, -1)
        self._finished = threading.Lock()
        self._finished.acquire()
        self._error: BaseException | None = None

    def work(self) -> None:
        """Take parts until none is left."""
        for part in self._parts:
            try:
                self._kernel(part.start, part.stop, *self._arguments)
            except BaseException as error:
                self._error = error  # needs no memory, which may be what is missing
            finally:
                if next(self._unfinished) == 0:
                    self._finished.release()

    def wait(self) -> None:
        """Wait until each part is finished, and raise what a thread raised."""
        self._finished.acquire()
        if self._error is not None:
            raise self._error


class _Helpers:
    """Threads that wait for launches; they are started when they are first needed."""

    def __init__(self) -> None:
        """Begin without a thread."""
        self._orders: SimpleQueue[_Launch] = SimpleQueue()
        self._starting = threading.Lock()
        self._n = 0

    def join(self, launch: _Launch, n: int) -> None:
        """Let n helpers join a launch, or as many as the system can start."""
        with self._starting:
            while self._n < n:
                try:
                    threading.Thread(target=self._help, name="izo_ref", daemon=True).start()
                except RuntimeError:  # too little memory, or too many threads: others do the work
                    break
                self._n += 1
            n = min(n, self._n)
        for _ in range(n):
            self._orders.put(launch)

    def _help(self) -> None:
        while True:
            self._orders.get().work()


_helpers = _Helpers()


def _forget_helpers() -> None:
    """Begin anew in a child process, which has no thread of its parent."""
    global _helpers
    _helpers = _Helpers()


os.register_at_fork(after_in_child=_forget_helpers)


def share(kernel: Callable[..., None], items: range, arguments: Sequence[Any]) -> None:
    """Run a kernel over some items on as many threads as numba is set to, and wait for the end.

    Args:
        kernel: Compiled function of the first item, the end of the items, and the arguments.
        items: The items, in steps of one.
        arguments: All other arguments.
    """
    n, n_threads = len(items), min(numba.get_num_threads(), len(items))
    if n_threads <= 1:
        if n:
            kernel(items.start, items.stop, *arguments)
        return
    n_parts = min(n, PARTS * n_threads)
    parts = [items[n * k // n_parts : n * (k + 1) // n_parts] for k in range(n_parts)]
    launch = _Launch(kernel, arguments, parts)
    _helpers.join(launch, n_threads - 1)
    launch.work()
    launch.wait()

"""Log which thread reads and writes which number between two waits, in functions run as Python."""

import sys
import threading
from pathlib import Path

import numpy as np

from izo_ref.base.serial.thread_group import ThreadGroup

TIMEOUT_S = 60.0
READ, WRITE, ATOMIC = 0, 1, 2  # kinds of accesses


class Log:
    """Accesses of the threads of a group.

    Attributes:
        accesses: (thread, phase, address, READ, WRITE or ATOMIC) of each access; the phase of a
            thread is how many times it has waited.
        sites: File and line of each wait, by the phase that it ends; None for a sum or maximum.
    """

    def __init__(self, n_threads):
        """Begin with nothing logged."""
        self.accesses, self.sites = [], {}
        self._own, self._n, self._parts = threading.local(), n_threads, [None] * n_threads
        self._barrier = threading.Barrier(n_threads, timeout=TIMEOUT_S)
        self._lock = threading.RLock()

    def add(self, address, kind):
        """Log an access, if a thread of the group makes it."""
        rank = getattr(self._own, "rank", None)
        if rank is not None:
            kind = ATOMIC if getattr(self._own, "atomic", False) else kind
            self.accesses.append((rank, self._own.phase, address, kind))

    def _at_once(self, values, i, change):
        """Change a number with no other thread in between, and return what it was."""
        with self._lock:
            self._own.atomic = True
            before = values[i]
            values[i] = change(before)
            self._own.atomic = False
        return before

    def _wait(self, site):
        self.sites[self._own.phase] = site
        self._barrier.wait()
        self._own.phase += 1

    def _combined(self, values, combine):
        self._parts[self._own.rank] = values
        self._wait(None)
        result = tuple(combine(column) for column in zip(*self._parts, strict=True))
        self._barrier.wait()
        return result

    def group(self):
        """Return the thread group."""

        def wait():
            caller = sys._getframe(1)
            self._wait((Path(caller.f_code.co_filename).name, caller.f_lineno))

        return ThreadGroup(
            lambda: self._own.rank,
            lambda: self._n,
            wait,
            lambda _, *values: self._combined(values, sum),
            lambda _, *values: self._combined(values, max),
            lambda values, i, amount: self._at_once(values, i, lambda old: old + amount),
            lambda values, i, value: self._at_once(values, i, lambda old: min(old, value)) and None,
            None,
        )

    def run(self, function):
        """Call a function in each thread, and return what the threads return."""
        results = [None] * self._n

        def work(rank):
            self._own.rank, self._own.phase = rank, 0
            try:
                results[rank] = function()
            except Exception:
                self._barrier.abort()
                raise

        threads = [threading.Thread(target=work, args=(rank,)) for rank in range(self._n)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return results

    def conflicts(self, without=None):
        """Return (number of conflicts, the first one's address).

        A conflict is a number that one thread writes and another one reads or writes between two
        waits. Threads may change a number together if all of them do it at once (`group_add`).

        Args:
            without: File and line of a wait, as in `sites`, which counts as none.
        """
        begins, phase = {0: 0}, 0
        for ended in sorted(self.sites):
            phase += without is None or self.sites[ended] != without
            begins[ended + 1] = phase
        users = {}
        for rank, own, address, kind in self.accesses:
            users.setdefault((begins[own], address), (set(), set(), set()))[kind].add(rank)
        found = [
            address
            for (_, address), (readers, writers, together) in users.items()
            if (writers or (readers and together)) and len(readers | writers | together) > 1
        ]
        return len(found), found[:1]


class Logged(np.ndarray):
    """An array whose accesses are logged, number by number; make it by `logged`."""

    log = None

    def __array_finalize__(self, source):
        """Let views log to the same place."""
        self.log = getattr(source, "log", None)

    def _address(self, key):
        index = key if isinstance(key, tuple) else (key,)
        if len(index) < self.ndim or any(isinstance(i, slice) for i in index):
            return None
        steps = (int(i) * step for i, step in zip(index, self.strides, strict=True))
        return self.__array_interface__["data"][0] + sum(steps)

    def __getitem__(self, key):
        """Read a number and log it, or take a view."""
        address = self._address(key)
        if address is not None and self.log is not None:
            self.log.add(address, READ)
        return super().__getitem__(key)

    def __setitem__(self, key, value):
        """Write a number and log it."""
        address = self._address(key)
        assert address is not None, "the thread writes number by number"
        if self.log is not None:
            self.log.add(address, WRITE)
        super().__setitem__(key, value)


def logged(array, log):
    """Return an array with the same memory whose accesses are logged."""
    view = array.view(Logged)
    view.log = log
    return view

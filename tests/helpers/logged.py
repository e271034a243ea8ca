"""Log which thread reads and writes which number between two waits, in functions run as Python."""

import sys
import threading
from pathlib import Path

import numpy as np

from izo_ref.base.serial.thread_group import ThreadGroup
from tests.helpers.turns import Turns

TIMEOUT_S = 60.0
READ, WRITE, ATOMIC = 0, 1, 2  # kinds of accesses


class Log:
    """Accesses of the threads of a group.

    Attributes:
        accesses: (thread, phase, address, READ, WRITE or ATOMIC, bytes that are written) of each
            access; the phase of a thread is how many times it has waited.
        sites: File and line of each wait, by the phase that it ends; None for a sum or maximum.
    """

    def __init__(self, n_threads, seed=None):
        """Begin with nothing logged.

        Args:
            n_threads: Threads of the group.
            seed: Draws which thread goes on after a wait and after some accesses; None lets all
                threads run at the same time.
        """
        self.accesses, self.sites = [], {}
        self._own, self._n, self._parts = threading.local(), n_threads, [None] * n_threads
        self._barrier = threading.Barrier(n_threads, timeout=TIMEOUT_S)
        self._lock = threading.RLock()
        everyone = [{"all": range(n_threads)} for _ in range(n_threads)]
        self._turns = None if seed is None else Turns(everyone, seed)

    def add(self, address, kind, value=None):
        """Log an access, if a thread of the group makes it."""
        rank = getattr(self._own, "rank", None)
        if rank is not None:
            kind = ATOMIC if getattr(self._own, "atomic", False) else kind
            self.accesses.append((rank, self._own.phase, address, kind, value))
            if self._turns is not None and kind != ATOMIC:
                self._turns.access(rank)

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
        self._wait_for_all()
        self._own.phase += 1

    def _wait_for_all(self):
        if self._turns is None:
            self._barrier.wait()
        else:
            self._turns.wait(self._own.rank, "all")

    def _combined(self, values, combine):
        self._parts[self._own.rank] = values
        self._wait(None)
        result = tuple(combine(column) for column in zip(*self._parts, strict=True))
        self._wait_for_all()
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

        if self._turns is not None:
            self._turns.run(lambda rank: threading.Thread(target=self._in_turn, args=(work, rank)))
            return results
        threads = [threading.Thread(target=work, args=(rank,)) for rank in range(self._n)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return results

    def _in_turn(self, work, rank):
        error = None
        try:
            self._turns.begin(rank)
            work(rank)
        except Exception as caught:
            error = caught
        self._turns.end(rank, error)

    def conflicts(self, without=None):
        """Return (number of conflicts, the first one's address).

        A conflict is a number that one thread writes and another one reads or writes between two
        waits. Threads may change a number together if all of them do it at once (`group_add`), and
        they may write the same value where none reads it before it writes.

        Args:
            without: File and line of a wait, as in `sites`, which counts as none.
        """
        begins, phase = {0: 0}, 0
        for ended in sorted(self.sites):
            phase += without is None or self.sites[ended] != without
            begins[ended + 1] = phase
        users = {}
        for rank, own, address, kind, value in self.accesses:
            users.setdefault((begins[own], address), Users()).add(rank, kind, value)
        found = [address for (_, address), own in users.items() if own.conflict()]
        return len(found), found[:1]


class Users:
    """The threads that use a number between two waits."""

    def __init__(self):
        """Begin with no users."""
        self._by_kind, self._values = (set(), set(), set()), set()

    def add(self, user, kind, value):
        """Add a user, and what it writes; a user may be a thread or a block.

        A user that reads what it has written itself is no reader: others may write the same value.
        """
        if kind == WRITE:
            self._values.add(value)
        if kind != READ or user not in self._by_kind[WRITE]:
            self._by_kind[kind].add(user)

    def conflict(self):
        """Return whether the result depends on the order of the users."""
        readers, writers, together = self._by_kind
        if len(readers | writers | together) < 2:
            return False
        if readers or together:
            return bool(writers or (readers and together))
        return len(self._values) > 1  # all may write the same


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
        """Write a number, or all numbers of a view, and log each."""
        address = self._address(key)
        if address is None:
            view = super().__getitem__(key)
            for place, number in np.ndenumerate(np.broadcast_to(value, view.shape)):
                view[place] = number
            return
        if self.log is not None:
            self.log.add(address, WRITE, np.asarray(value, self.dtype).tobytes())
        super().__setitem__(key, value)


def logged(array, log):
    """Return an array with the same memory whose accesses are logged."""
    view = array.view(Logged)
    view.log = log
    return view

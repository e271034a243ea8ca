"""Log which thread reads and writes which number between two waits, in functions run as Python."""

import sys
import threading
from pathlib import Path

import numpy as np

from izo_ref.base.serial.thread_group import Team, ThreadGroup
from tests.helpers.turns import Turns

TIMEOUT_S = 60.0
READ, WRITE, ATOMIC = 0, 1, 2  # kinds of accesses


class Log:
    """Accesses of the threads of a group.

    Attributes:
        accesses: (thread, phase, step, address, READ, WRITE or ATOMIC, bytes that are written) of
            each access. The phase of a thread is how many times it has waited for all threads, and
            its step is how many times it has waited at all.
        sites: File and line of each wait for all threads, by the phase that it ends; None for a sum
            or maximum.
        team_sites: File and line of each wait, by the team and the step that it ends.
    """

    def __init__(self, n_threads, seed=None, n_teams=1):
        """Begin with nothing logged.

        Args:
            n_threads: Threads of the group.
            seed: Draws which thread goes on after a wait and after some accesses; None lets all
                threads run at the same time.
            n_teams: Teams of these threads, all of the same size.
        """
        self.accesses, self.sites, self.team_sites = [], {}, {}
        self._own, self._n, self._parts = threading.local(), n_threads, [None] * n_threads
        self._n_teams, self._team_size = n_teams, n_threads // n_teams
        self._barrier = threading.Barrier(n_threads, timeout=TIMEOUT_S)
        self._team_barriers = [
            threading.Barrier(self._team_size, timeout=TIMEOUT_S) for _ in range(n_teams)
        ]
        self._lock = threading.RLock()
        groups = [{"all": range(n_threads), "team": self._members(k)} for k in range(n_threads)]
        self._turns = None if seed is None else Turns(groups, seed)

    def add(self, address, kind, value=None):
        """Log an access, if a thread of the group makes it."""
        rank = getattr(self._own, "rank", None)
        if rank is not None:
            kind = ATOMIC if getattr(self._own, "atomic", False) else kind
            own = self._own
            self.accesses.append((rank, own.phase, own.step, address, kind, value))
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

    def _team(self):
        return self._own.rank // self._team_size

    def _members(self, rank):
        """Return the threads of the team of a thread."""
        first = rank - rank % self._team_size
        return range(first, first + self._team_size)

    def _wait(self, site):
        own = self._own
        self.sites[own.phase] = self.team_sites[self._team(), own.step] = site
        self._wait_for_all()
        own.phase, own.step = own.phase + 1, own.step + 1

    def _wait_for_team(self, site):
        own, team = self._own, self._team()
        self.team_sites[team, own.step] = site
        if self._turns is None:
            self._team_barriers[team].wait()
        else:
            self._turns.wait(own.rank, "team")
        own.step += 1

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
            self._wait(_site(sys._getframe(1)))

        def wait_for_team():
            self._wait_for_team(_site(sys._getframe(1)))

        team = Team(
            lambda: self._own.rank % self._team_size,
            lambda: self._team_size,
            wait_for_team,
            self._team,
            lambda: self._n_teams,
        )
        return ThreadGroup(
            lambda: self._own.rank,
            lambda: self._n,
            wait,
            lambda _, *values: self._combined(values, sum),
            lambda _, *values: self._combined(values, max),
            lambda values, i, amount: self._at_once(values, i, lambda old: old + amount),
            lambda values, i, value: self._at_once(values, i, lambda old: min(old, value)) and None,
            team,
            None,
        )

    def run(self, function):
        """Call a function in each thread, and return what the threads return."""
        results = [None] * self._n

        def work(rank):
            self._own.rank, self._own.phase, self._own.step = rank, 0, 0
            try:
                results[rank] = function()
            except Exception:
                for barrier in (self._barrier, *self._team_barriers):
                    barrier.abort()
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

        A conflict is a number that one thread writes and another one reads or writes, with no wait
        between them, or no wait for all threads if they are in different teams. Threads may change
        a number together if all of them do it at once (`group_add`), and they may write the same
        value where none reads it before it writes.

        Args:
            without: File and line of a wait, as in `sites`, which counts as none.
        """
        phases, steps = _counted(self.sites, without), {}
        for team in range(self._n_teams):
            own = {step: site for (of, step), site in self.team_sites.items() if of == team}
            steps[team] = _counted(own, without)
        between_teams, in_team = {}, {}
        for rank, phase, step, address, kind, value in self.accesses:
            team = rank // self._team_size
            users = between_teams.setdefault((phases[phase], address), Users())
            users.add(team, kind, value)
            users = in_team.setdefault((team, steps[team][step], address), Users())
            users.add(rank, kind, value)
        found = [key[-1] for key, own in (between_teams | in_team).items() if own.conflict()]
        return len(found), found[:1]


def _counted(sites, without):
    """Return how many waits come before each phase or step, without those of one site."""
    begins, count = {0: 0}, 0
    for ended in sorted(sites):
        count += without is None or sites[ended] != without
        begins[ended + 1] = count
    return begins


def _site(frame):
    """Return the file and the line of a caller."""
    return Path(frame.f_code.co_filename).name, frame.f_lineno


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

"""Let one of several threads run at a time, in an order that a seed draws."""

import random
import threading

TIMEOUT_S = 60.0  # a thread that gets no turn for so long fails
SWITCH = 0.05  # chance that another thread goes on after an access
READY, DONE = "ready", "done"


class Turns:
    """The turns of some threads, numbered from 0.

    A thread that waits names a group of threads. It goes on when all threads of the group wait with
    the same name, or have ended where the group allows that.

    Args:
        groups: Of each thread, `{name of a group: threads of this group}`.
        seed: Draws which thread goes on.
        strict: Names of the groups that wait for ever for a thread that has ended.
    """

    def __init__(self, groups, seed, strict=()):
        """Begin with all threads ready, and none running."""
        self._groups, self._random, self._strict = groups, random.Random(seed), strict
        self._states = [READY] * len(groups)
        self._turns = [threading.Event() for _ in groups]
        self.error = None

    def run(self, work):
        """Call work(rank) in each thread; raise the first error of a thread.

        Args:
            work: Makes a thread of a rank; it calls `begin` first and `end` last.
        """
        threads = [work(rank) for rank in range(len(self._groups))]
        for thread in threads:
            thread.start()
        self._next()
        for thread in threads:
            thread.join()
        if self.error is not None:
            raise self.error

    def begin(self, rank):
        """Wait for the first turn."""
        self._pause(rank)

    def end(self, rank, error=None):
        """Give the turn away for ever; an error ends all threads."""
        self._states[rank] = DONE
        if error is not None:
            self._fail(error)
        for name in self._groups[rank]:
            self._open(name, rank)
        self._next()

    def wait(self, rank, name):
        """Wait for the other threads of a group."""
        self._states[rank] = name
        self._open(name, rank)
        self._next()
        self._pause(rank)

    def access(self, rank):
        """Perhaps let another thread go on."""
        if self._random.random() < SWITCH:
            self._next()
            self._pause(rank)

    def _open(self, name, rank):
        members = self._groups[rank][name]
        alive = [k for k in members if self._states[k] != DONE or name in self._strict]
        if all(self._states[k] == name for k in alive):
            for k in alive:
                self._states[k] = READY

    def _next(self):
        """Give the turn to a thread that is ready."""
        ready = [k for k, state in enumerate(self._states) if state == READY]
        if ready:
            self._turns[self._random.choice(ready)].set()
        elif any(state != DONE for state in self._states):
            self._fail(RuntimeError(f"threads wait for ever: {self._states}"))

    def _pause(self, rank):
        """Wait for the turn."""
        if not self._turns[rank].wait(TIMEOUT_S):
            self._fail(RuntimeError(f"thread {rank} got no turn in {TIMEOUT_S:.0f} s"))
        self._turns[rank].clear()
        if self.error is not None:
            raise RuntimeError("another thread has failed")

    def _fail(self, error):
        self.error = self.error or error
        for turn in self._turns:
            turn.set()

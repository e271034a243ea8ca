"""Which rounds with new normals are tried and kept; and the seconds that a step reports."""

from types import SimpleNamespace

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.loop import stopwatch
from izo_ref.loop.rounds import LITTLE_WORK, relinearize
from tests.helpers.shapes import two_sheets


class Rounds:
    """A loop whose rounds do given work, and end with given objectives or not at all.

    Attributes:
        said: What was asked of the loop and of its step, in order.
    """

    def __init__(self, begin, rounds, work=0):
        """Begin at an objective, with rounds (objective or None, work)."""
        self.value, self.rounds, self.said = begin, list(rounds), []
        self.history = [SimpleNamespace(moved=work, found=0)]
        self.step = self
        self.times = SimpleNamespace(begin_rounds=lambda: None, note=self.said.append)

    def objective(self):
        return self.value

    def save(self):
        return self.value

    def restore(self, saved):
        self.value = saved
        self.said.append("restored")

    def relinearize(self):
        self.said.append("normals")

    def run(self, number, limit):
        self.said.append((number, limit))
        value, work = self.rounds.pop(0)
        self.history.append(SimpleNamespace(moved=work // 2, found=work - work // 2))
        self.value = 1e9 if value is None else value
        return value is not None


def tried(loop, **options):
    """Run the rounds, and return their numbers, and whether the last one was taken back."""
    relinearize(loop, Options(**options))
    numbers = [entry[0] for entry in loop.said if isinstance(entry, tuple)]
    assert loop.said.count("normals") == len(numbers)
    return numbers, loop.said[-1:] == ["restored"]


def test_rounds_go_on_while_each_lowers_the_objective_enough():
    loop = Rounds(100.0, [(90.0, 0), (80.0, 0), (79.99, 0), (1.0, 0)])
    assert tried(loop, relinearize=4, relinearize_gain=0.05) == ([1, 2, 3], False)
    assert loop.value == 79.99  # the last round is kept, though it did not pay
    assert [entry[1] for entry in loop.said if isinstance(entry, tuple)] == [100.0, 90.0, 80.0]
    loop = Rounds(100.0, [(95.0, 0), (90.25, 0), (80.0, 0)])
    assert tried(loop, relinearize=2, relinearize_gain=0.05) == ([1, 2], False)
    assert tried(Rounds(1.0, []), relinearize=0) == ([], False)


def test_a_round_that_fails_is_taken_back():
    loop = Rounds(100.0, [(90.0, 0), (None, 0), (50.0, 0)])
    assert tried(loop, relinearize=3) == ([1, 2], True)
    assert loop.value == 90.0


@pytest.mark.parametrize(("work", "numbers"), [(40_000, [1, 2]), (0, [1]), (200_000, [1, 2, 3])])
def test_no_round_begins_once_the_budget_is_spent(work, numbers):
    """Each round does 12,000 units of work, and 10,000 are always free."""
    assert LITTLE_WORK == 10_000
    loop = Rounds(100.0, [(90.0, 12_000), (80.0, 12_000), (70.0, 12_000)], work)
    found, _ = tried(loop, relinearize=3, relinearize_budget=0.4)
    assert found == numbers


def test_a_stopwatch_gives_each_stage_its_own_seconds(monkeypatch):
    times = iter([10.0, 12.0, 15.0, 15.5])
    monkeypatch.setattr(stopwatch, "time", SimpleNamespace(perf_counter=lambda: next(times)))
    watch = stopwatch.Stopwatch()
    for stage in ("first", "second", "third"):
        watch.lap(stage)
    assert watch.timings() == {"first": 2.0, "second": 3.0, "third": 0.5, "total": 5.5}


def test_the_seconds_of_stages_and_iterations_add_up(rng):
    result = izo_ref.resolve(two_sheets(rng, 5), 1e-3)
    timings = dict(result.timings)
    total = timings.pop("total")
    assert set(timings) == {"main", "relinearize", "scale_back", "certify", "judge"}
    assert min(timings.values()) >= 0.0
    assert sum(timings.values()) == pytest.approx(total)
    rounds = {}
    for entry in result.history:
        seconds = entry.detect_s + entry.solve_s
        assert min(entry.detect_s, entry.solve_s) >= 0.0
        name = "main" if entry.round == 0 else "relinearize"
        rounds[name] = rounds.get(name, 0.0) + seconds
    assert all(seconds <= timings[name] for name, seconds in rounds.items())
    assert np.isfinite(total)

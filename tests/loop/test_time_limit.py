"""A time limit: wherever it strikes, the answer is certified, and says that it was cut short."""

import time
from importlib import import_module

import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Status
from izo_ref.base.deadline import Deadline, OutOfTimeError
from izo_ref.base.errors import OptionError, UncertifiedStartError
from izo_ref.base.records import PairState
from izo_ref.loop.ending import at_start
from izo_ref.loop.time_plan import TimePlan
from izo_ref.zones.objective import objective
from tests.helpers.shapes import grid, pinched_sheet, two_sheets
from validation.scenes.balls import pressed_balls

LIMIT_S = 10.0


class JumpingClock:
    """A clock that stands still for some readings, and then jumps.

    Args:
        readings: Readings before the jump.
        after_s: What it shows after the jump [s].
    """

    def __init__(self, readings, after_s):
        self.left, self.after_s, self.count = readings, after_s, 0

    def __call__(self):
        self.count += 1
        self.left -= 1
        return self.after_s if self.left < 0 else 0.0


class TickingClock:
    """A clock that goes on by the same time at each reading [s]."""

    def __init__(self, tick_s):
        self.tick_s, self.now_s = tick_s, 0.0

    def __call__(self):
        self.now_s += self.tick_s
        return self.now_s


class SetClock:
    """A clock that shows what it was set to [s]."""

    now_s = 0.0

    def __call__(self):
        return self.now_s


def ends_at(clock, deadline, end_s):
    """Return whether the present stage of a deadline ends at a time, and not a bit before."""
    clock.now_s = end_s * (1.0 - 1e-12)
    deadline.check()
    clock.now_s = end_s * (1.0 + 1e-12)
    with pytest.raises(OutOfTimeError):
        deadline.check()
    return True


@pytest.mark.parametrize("n_certificates", [1, 2])
def test_each_stage_leaves_the_time_that_those_after_it_need(n_certificates):
    """The first detection takes 2 s of 100; docs/method/7-statuses has the rules."""
    clock = SetClock()
    deadline = Deadline(100.0, clock)
    times = TimePlan(deadline, n_certificates)
    clock.now_s = 3.0
    times.begin_first_detection()
    assert ends_at(clock, deadline, 50.0)
    clock.now_s = 5.0
    times.begin_main()
    certificates_s = n_certificates * (1.2 * 2.0 + 0.05 * 100.0)
    scaling_s = 4.0 * 2.0 + 0.05 * 100.0
    assert ends_at(clock, deadline, 100.0 - certificates_s - scaling_s)
    times.begin_rounds()
    assert ends_at(clock, deadline, 100.0 - certificates_s)
    clock.now_s = 40.0
    times.begin_scaling_back()
    half_s = 0.5 * (40.0 + 100.0 - certificates_s)
    clock.now_s = half_s * (1.0 - 1e-12)
    assert times.halves()
    clock.now_s = half_s * (1.0 + 1e-12)
    assert not times.halves()
    assert ends_at(clock, deadline, 100.0 - certificates_s)
    times.begin_certificate()
    assert ends_at(clock, deadline, 100.0)
    times.begin_at_start()
    assert ends_at(clock, deadline, 125.0)
    times.end()
    deadline.check()


@pytest.fixture
def by_clock(monkeypatch):
    """Return a function that resolves a scene with a limit of LIMIT_S by some clock."""

    def run(scene, clock, thickness=1e-3, **options):
        module = import_module("izo_ref.loop.resolve")
        monkeypatch.setattr(module, "Deadline", lambda limit_s: Deadline(limit_s, clock))
        named = Options(max_seconds=LIMIT_S, **options)
        return izo_ref.resolve(scene, thickness, options=named)

    return run


def assert_same(result, free):
    """Assert that a result has the bits of the one without a limit."""
    assert result.reason == ""
    assert result.status is free.status
    np.testing.assert_array_equal(result.positions, free.positions)
    np.testing.assert_array_equal(result.multipliers, free.multipliers)
    assert result.certificate.candidates == free.certificate.candidates
    untimed = [line._replace(detect_s=0.0, solve_s=0.0) for line in result.history]
    assert untimed == [line._replace(detect_s=0.0, solve_s=0.0) for line in free.history]


def assert_cut_short(scene, result):
    """Assert that a result is certified, says that it was cut, and is no worse than the start."""
    assert result.status is Status.FREE_BY_FALLBACK
    assert "The time limit of 10 s ended" in result.reason
    own = izo_ref.certify_path(scene, result.positions)
    assert own.free
    assert result.certificate.free
    assert result.time_free == 1.0
    assert result.objective <= objective(scene, at_start(scene))
    np.testing.assert_array_equal(result.positions[scene.pinned], scene.positions_t1[scene.pinned])


def excluded_scene():
    """Return a sheet that falls on another one, and beside them two sheets that cross."""
    low, faces = grid(4)
    high, _ = grid(4, 0.1)
    crossing, own = grid(2, 0.0)
    across = np.array([[2.4, 0.4, -0.5], [2.6, 0.45, 0.5], [2.5, 0.7, 0.6]])
    start = np.concatenate((low, high + (0.05, 0.03, 0.0), crossing + (2.0, 0.0, 0.0), across))
    n, m, k = len(low), 2 * len(low), 2 * len(low) + len(crossing)
    end = start.copy()
    end[n:m, 2] -= 0.2
    parts = faces, faces + n, own + m, np.array([[k, k + 1, k + 2]])
    return izo_ref.Scene(start, end, np.concatenate(parts), initial_intersections="ratchet")


SCENES = {
    "sheets": lambda rng: two_sheets(rng, 5),
    "balls": lambda rng: pressed_balls(rng, 2),
}


@pytest.mark.parametrize(
    ("name", "after_s", "tries"),
    [
        ("sheets", 1e9, None),  # at every reading
        ("sheets", 0.92 * LIMIT_S, 25),
        ("sheets", 1.1 * LIMIT_S, 25),
        ("balls", 0.92 * LIMIT_S, 15),
        ("balls", 1e9, 15),
    ],
)
def test_wherever_the_limit_strikes_the_answer_is_free_or_the_same(
    rng, by_clock, name, after_s, tries
):
    """The clock jumps at its readings in turn: into the fail-safe, behind it, and behind all."""
    scene = SCENES[name](rng)
    free = izo_ref.resolve(scene, 1e-3)
    assert free.status is Status.FREE
    never = JumpingClock(10**9, after_s)
    assert_same(by_clock(scene, never), free)
    assert never.count > 20
    n_cut, step = 0, 1 if tries is None else max(1, never.count // tries)
    for k in range(1, never.count + 1, step):
        result = by_clock(scene, JumpingClock(k, after_s))
        if result.reason:
            n_cut += 1
            assert_cut_short(scene, result)
        else:
            assert_same(result, free)
    assert n_cut > 5


def test_the_limit_may_strike_in_each_stage(rng, by_clock):
    """A clock that ticks ends another stage for each length of its tick."""
    scene, reasons = two_sheets(rng, 5), set()
    for tick_s in np.geomspace(1e-3, 20.0, 40):
        result = by_clock(scene, TickingClock(float(tick_s)))
        if result.reason:
            assert_cut_short(scene, result)
            reasons.add(result.reason.split(" ended ")[1])
    fail_safe = "The fail-safe took over."
    at_start = "All vertices that are not pinned stay at the start."
    assert f"the main loop. {fail_safe}" in reasons
    assert f"the first detection and scaling back. {at_start}" in reasons


def test_a_search_with_less_thickness_that_is_cut_is_said(by_clock, monkeypatch):
    def cut(*_):
        raise OutOfTimeError

    module = import_module("izo_ref.loop.resolve")
    monkeypatch.setattr(module, "find_with_less_thickness", cut)
    result = by_clock(pinched_sheet(-0.05, bump=0.2), TickingClock(0.0), 0.02)
    assert result.status is Status.BLOCKED
    assert result.reason.endswith(
        "What has too little room for the thickness was not resolved again with less."
    )


def test_rounds_that_are_cut_leave_the_answer_of_the_rounds_before(rng, by_clock):
    """The clock jumps behind the end of the rounds, but not behind that of the certificate."""
    scene, n_cut = two_sheets(rng, 8), 0
    before = [izo_ref.resolve(scene, 1e-3, options=Options(relinearize=k)) for k in range(3)]
    after_s = 0.97 * LIMIT_S
    never = JumpingClock(10**9, after_s)
    by_clock(scene, never, relinearize=2)
    for k in range(never.count // 2, never.count):
        cut = by_clock(scene, JumpingClock(k, after_s), relinearize=2)
        if "rounds" not in cut.reason:
            continue
        n_cut += 1
        assert cut.status is Status.FREE_BY_FALLBACK
        assert cut.reason.endswith("The answer is that of the rounds before.")
        assert cut.converged  # its zones are solved; the status says all the same that it was cut
        assert cut.feasible
        assert cut.scaled_back == []
        assert any(np.array_equal(cut.positions, whole.positions) for whole in before)
    assert n_cut > 3


@pytest.mark.parametrize("readings", [0, 8, 16, 24, 40, 80, 10**9])
@pytest.mark.parametrize("after_s", [0.99 * LIMIT_S, 1e9])
def test_prescribed_motion_ends_free_or_blocked_and_says_what_is_proved(
    rng, by_clock, readings, after_s
):
    """The lower sheet is pinned and rises: with the upper one at the start, the two may meet."""
    scene = two_sheets(rng, 5, pinned_below=True)
    result = by_clock(scene, JumpingClock(readings, after_s))
    own, certificate = izo_ref.certify_path(scene, result.positions), result.certificate
    assert (result.status is Status.BLOCKED) == (not certificate.free)
    np.testing.assert_array_equal(result.positions[scene.pinned], scene.positions_t1[scene.pinned])
    if certificate.finished:
        assert certificate.free == own.free
        assert result.time_free == own.time_free
    else:
        assert not certificate.free
        assert result.time_free == 0.0
        assert "nothing is proved" in result.reason
        with pytest.raises(UncertifiedStartError, match="the time limit ended its certificate"):
            scene.after(result, scene.positions_t1)
    assert bool(result.reason) or result.status is Status.FREE


def test_pairs_that_are_left_out_stay_so_and_unknown_ends_are_named(by_clock):
    scene = excluded_scene()
    free = izo_ref.resolve(scene, 1e-3)
    assert free.status is Status.FREE_EXCEPT_EXCLUDED
    seen = set()
    for readings in (0, 2, 5, 10, 20, 40, 10**9):
        for after_s in (1.1 * LIMIT_S, 1e9):
            result = by_clock(scene, JumpingClock(readings, after_s))
            assert result.status is Status.FREE_EXCEPT_EXCLUDED
            assert result.certificate.free
            ends = result.certificate.excluded_ends
            assert len(ends) == len(free.certificate.excluded_ends)
            seen |= {PairState(end) for end in ends.tolist()}
    assert PairState.UNKNOWN in seen
    assert len(seen) > 1


@pytest.mark.parametrize("readings", [0, 5, 20, 60, 10**9])
@pytest.mark.parametrize("after_s", [0.9 * LIMIT_S, 1e9])
def test_a_step_of_another_size_is_certified_in_its_own_units(rng, by_clock, readings, after_s):
    near = two_sheets(rng, 5)
    ends = (np.ldexp(p, 300) for p in (near.positions_t0, near.positions_t1))
    scene = izo_ref.Scene(*ends, near.faces, near.masses)
    result = by_clock(scene, JumpingClock(readings, after_s), None)
    own = izo_ref.certify_path(scene, result.positions)
    assert own.free
    assert result.certificate.free
    assert result.certificate.scene is scene
    assert result.status is (Status.FREE_BY_FALLBACK if result.reason else Status.FREE)
    assert result.objective <= objective(scene, at_start(scene))
    held = np.zeros(len(scene.pinned), bool)
    for part in result.scaled_back:
        held[part.vertices] |= part.scale == 0.0
    np.testing.assert_array_equal(result.positions[held], scene.positions_t0[held])


@pytest.mark.parametrize("method", ["apgs", "newton", "active-set", "interior-point"])
def test_the_limit_ends_every_method(rng, by_clock, method):
    scene = two_sheets(rng, 5)
    for readings in (3, 12, 30, 60):
        result = by_clock(scene, JumpingClock(readings, 1e9), method=method, max_steps=500)
        if result.reason:
            assert_cut_short(scene, result)


def test_a_limit_that_is_not_reached_is_not_seen(rng):
    scene = two_sheets(rng, 8)
    assert_same(
        izo_ref.resolve(scene, 1e-3, options=Options(max_seconds=1e6)), izo_ref.resolve(scene, 1e-3)
    )


def test_without_a_limit_nobody_asks_the_clock(rng, monkeypatch):
    """No time is added to a run that has no limit."""

    def forbidden():
        raise AssertionError("the clock was read")

    module = import_module("izo_ref.loop.resolve")
    monkeypatch.setattr(module, "Deadline", lambda limit_s: Deadline(limit_s, forbidden))
    assert izo_ref.resolve(two_sheets(rng, 5), 1e-3).status is Status.FREE


def test_by_the_real_clock_the_answer_comes_in_time(rng):
    """Deep contact of several seconds with a limit of 1.1 s. A busy machine may need three tries.

    The first try compiles, which nothing can cut.
    """
    scene, spent_s = pressed_balls(rng, 40), []
    for _ in range(3):
        begin = time.perf_counter()
        result = izo_ref.resolve(scene, 1e-3, options=Options(max_seconds=1.1))
        spent_s.append(time.perf_counter() - begin)
        assert result.certificate.free
        assert result.status is (Status.FREE_BY_FALLBACK if result.reason else Status.FREE)
        assert not result.reason or result.objective <= objective(scene, at_start(scene))
        if spent_s[-1] < 1.5 * 1.1:
            break
    assert min(spent_s) < 1.5 * 1.1


@pytest.mark.parametrize("value", [0.0, -1.0, float("inf"), float("nan"), "2", True, 1j])
def test_limits_that_are_no_positive_numbers_are_refused(value):
    with pytest.raises(OptionError, match="max_seconds: expected None or a finite number > 0"):
        Options(max_seconds=value)


def test_a_limit_is_a_number_of_seconds():
    assert Options().max_seconds is None
    assert Options(max_seconds=np.float32(0.5)).max_seconds == 0.5
    assert type(Options(max_seconds=2).max_seconds) is float

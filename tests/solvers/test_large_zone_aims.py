"""When a large zone that was missed is aimed at again, with solutions that are given here."""

import numpy as np
import pytest

from izo_ref.solvers import large_zone
from izo_ref.solvers.scaled_constraints import LargeZone

TOLERANCE = 1e-9
ZONE = LargeZone(
    np.array([[0, -1, -1, -1]], np.int32),
    np.array([[1.0, 0.0, 0.0, 0.0]]),
    np.array([[0.0, 0.0, 1.0]]),
    np.ones(1),
    np.ones(1),
    1,
)


@pytest.mark.parametrize(
    ("offs", "solved_by_itself", "aims", "solved"),
    [
        ([0.0], True, [0.0], True),
        ([3.0, 0.5], False, [0.0, 6.0], True),  # the second aim was missed, the zone was not
        ([3.0, 2.0, 0.5], False, [0.0, 6.0, 10.0], True),
        ([3.0, 2.0, 1.5], False, [0.0, 6.0, 10.0], False),  # no fourth aim
        ([501.0], False, [0.0], False),  # missed by far
        ([0.5, 0.5], False, [0.0, 1.0], True),  # not solved for another reason than the violation
        ([-0.5], False, [0.0], False),
    ],
)
def test_a_zone_is_aimed_at_again_by_twice_what_was_missed(
    monkeypatch, offs, solved_by_itself, aims, solved
):
    """Offs and aims are in units of the tolerance; three aims are allowed."""
    left, aimed, tolerances = list(offs), [], []

    def solve(zone, start, gap_tolerance, violation_tolerance, *_):
        aimed.append((zone.rhs[0] - 1.0) / TOLERANCE)
        tolerances.append(violation_tolerance / TOLERANCE)
        z = np.array([0.0, 0.0, 1.0 - left.pop(0) * TOLERANCE])
        return large_zone.LargeSolution(z, np.ones(1), "given", 1, solved_by_itself)

    monkeypatch.setattr(large_zone, "_solve", solve)
    found = large_zone.solve_large_zone(ZONE, np.zeros(1), 1e-9, TOLERANCE, False)
    assert found.solved is solved
    assert aimed == pytest.approx(aims, abs=1e-5)
    # an aim may be missed by half of the way beyond
    assert tolerances == pytest.approx([1.0 + 0.5 * aim for aim in aims], abs=1e-5)
    assert not left


@pytest.mark.parametrize("n_impacts", [1, 2, 3, 4])
@pytest.mark.parametrize("knows_a_start", [False, True])
@pytest.mark.parametrize("interior_only", [False, True])
@pytest.mark.parametrize("pivots", [False, True])
def test_a_zone_is_pivoted_from_a_start_if_its_constraints_may_be_independent(
    monkeypatch, n_impacts, knows_a_start, interior_only, pivots
):
    """One vertex has three unknowns. Where pivoting gives up, the interior point takes over.

    The answer of the interior point is polished, unless no other method is allowed.
    """
    zone = LargeZone(*(np.repeat(part, n_impacts, axis=0) for part in ZONE[:5]), 1)
    own, asked = (np.array([0.0, 0.0, 1.0]), np.ones(n_impacts), 7), []

    def pivot_from(*_):
        asked.append("pivoting")
        return own if pivots else None

    def polish(_, z, u, *__):
        asked.append("polish")
        return z, u

    monkeypatch.setattr(large_zone, "pivot_from", pivot_from)
    monkeypatch.setattr(large_zone, "polish", polish)
    monkeypatch.setattr(large_zone, "_sweep", lambda *_: 0)
    monkeypatch.setattr(large_zone, "is_entangled", lambda _: False)
    monkeypatch.setattr(large_zone, "interior_point", lambda *_: (*own, True))
    start = np.full(n_impacts, 0.0 + knows_a_start)
    found = large_zone.solve_large_zone(zone, start, 1e-9, TOLERANCE, interior_only)
    tried = knows_a_start and not interior_only and n_impacts < 3
    polished = not interior_only and n_impacts < 3 and not (tried and pivots)
    assert asked == ["pivoting"] * tried + ["polish"] * polished
    assert found.method == ("pivoting" if tried and pivots else "interior-point")
    assert (found.solved, found.steps) == (True, 7)

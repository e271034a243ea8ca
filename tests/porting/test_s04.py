"""The vectors of stage S4, and mistakes that they catch."""

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.reference import groups
from tests.helpers.vectors import caught, require_good_cases
from tests.naive import groups as naive
from tests.ports.own.s04 import answer

CASES = load_cases(stages=["S4"])
OWNED = ("selection-order", "selection-ties", "selection-deep", "zone-pinned")


def parts_of(case):
    """Return the inputs as the reference takes them."""
    own = case.inputs
    n = len(own["toi"])
    nodes = [own["nodes"][4 * j : 4 * j + 4] for j in range(n)]
    weights = own.get("weights", [0.0] * 4 * n)
    rows = [weights[4 * j : 4 * j + 4] for j in range(n)]
    kinds = own.get("edge_edge_impacts", [0] * n)
    return own["toi"], nodes, own["pinned"], own["selection"], rows, kinds


def passes(select):
    """Return a function that says whether `select` gives what a case expects."""
    return lambda case: select(*parts_of(case)) == case.expected["selected"]["values"]


def test_the_cases_are_complete():
    require_good_cases(CASES, OWNED)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_functions_pass(case):
    assert answer(dict(case.inputs), "f8")["selected"] == case.expected["selected"]["values"]


def test_the_reference_agrees_with_the_oracle(rng):
    for _ in range(30):
        nodes = np.array([rng.choice(14, 4, replace=False) for _ in range(20)])
        toi, pinned = rng.integers(1, 6, 20) / 8.0, rng.random(14) < 0.2
        weights = rng.random((20, 4)) * (1, 1, -1, -1)
        kinds = rng.random(20) < 0.5
        some = ~pinned[nodes].all(axis=1)
        toi, nodes, weights, kinds = toi[some], nodes[some], weights[some], kinds[some]
        arguments = toi.tolist(), nodes.tolist(), pinned.tolist()
        expected = {
            "independent": naive.independent(toi, nodes, pinned),
            "first-of-any": naive.first_of_any(toi, nodes, pinned),
            "deep": naive.first_of_main_vertices(toi, nodes, weights, kinds, pinned, 1.5),
        }
        for selection, chosen in expected.items():
            own = groups.select(*arguments, selection, weights.tolist(), kinds.tolist())
            assert np.flatnonzero(own).tolist() == chosen


def in_the_order_given(toi, *rest):
    return groups.select([0.0] * len(toi), *rest)


def waits_for_all(toi, nodes, pinned, selection, *rest):
    """Let impacts that were not selected hold their vertices too."""
    if selection != "independent":
        return groups.select(toi, nodes, pinned, selection, *rest)
    seen, selected = set(), [0] * len(toi)
    for j in sorted(range(len(toi)), key=lambda j: toi[j]):
        own = {v for v in nodes[j] if not pinned[v]}
        selected[j] = int(not own & seen)
        seen |= own
    return selected


def last_of_equal_times(toi, nodes, pinned, selection, weights, kinds):
    backwards = (part[::-1] for part in (weights, kinds))
    return groups.select(toi[::-1], nodes[::-1], pinned, selection, *backwards)[::-1]


def sorted_in_blocks(toi, *rest):
    """Sort the impacts of each block of 1024 threads, and not the blocks with one another."""
    return groups.select([j // 1024 + t / 2.0 for j, t in enumerate(toi)], *rest)


def hashed(toi, nodes, pinned, selection, *rest):
    """Mark vertices in a table of 128 places, without a look at who is there already."""
    if any(pinned) or selection == "deep":
        return groups.select(toi, nodes, pinned, selection, *rest)
    return groups.select(toi, [[v % 128 for v in row] for row in nodes], [0] * 128, selection)


def pinned_count(toi, nodes, pinned, *rest):
    return groups.select(toi, nodes, [0] * len(pinned), *rest)


def deep_as_any_other(toi, nodes, pinned, selection, *rest):
    ordinary = "independent" if selection == "deep" else selection
    return groups.select(toi, nodes, pinned, ordinary, *rest)


def kinds_are_equal(toi, nodes, pinned, selection, weights, kinds):
    return groups.select(toi, nodes, pinned, selection, weights, [0] * len(kinds))


def nothing_waits(toi, nodes, pinned, selection, weights, kinds):
    if selection != "deep":
        return groups.select(toi, nodes, pinned, selection)
    late = [1.0 + t / 4.0 for t in toi]
    return groups.select(late, nodes, pinned, selection, weights, kinds)


@pytest.mark.parametrize(
    ("flag", "wrong", "least"),
    [
        ("selection-order", in_the_order_given, 5),
        ("selection-order", waits_for_all, 3),
        ("selection-ties", last_of_equal_times, 5),
        ("selection-order", sorted_in_blocks, 1),
        ("selection-order", hashed, 1),
        ("zone-pinned", pinned_count, 4),
        ("selection-deep", deep_as_any_other, 3),
        ("selection-deep", kinds_are_equal, 2),
        ("selection-deep", nothing_waits, 2),
    ],
    ids=lambda part: getattr(part, "__name__", str(part)),
)
def test_mistakes_are_caught(flag, wrong, least):
    assert len(caught(flag, CASES, passes(wrong))) >= least


def test_the_reference_passes():
    assert all(passes(groups.select)(case) for case in CASES)

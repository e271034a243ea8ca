"""The vectors of stage S5, and mistakes that they catch."""

import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.reference import groups
from tests.helpers.vectors import caught, require_good_cases, same_partition
from tests.naive.groups import components
from tests.ports.own.s05 import answer

CASES = load_cases(stages=["S5"])


def rows_of(case):
    """Return the vertices of each impact."""
    flat = case.inputs["nodes"]
    return [flat[j : j + 4] for j in range(0, len(flat), 4)]


def passes(zones):
    """Return a function that says whether `zones` gives what a case expects."""
    return lambda case: same_partition(
        zones(rows_of(case), case.inputs["pinned"]), case.expected["zone_of_impact"]["values"]
    )


def test_the_cases_are_complete():
    require_good_cases(CASES, ("zone-transitive", "zone-pinned", "zone-capacity"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_functions_pass(case):
    for dtype in case.dtypes:
        own = answer(dict(case.inputs), dtype)["zone_of_impact"]
        assert same_partition(own, case.expected["zone_of_impact"]["values"])


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_the_reference_agrees_with_the_oracle(case):
    zone = case.expected["zone_of_impact"]["values"]
    found = {frozenset(j for j, z in enumerate(zone) if z == k) for k in set(zone) - {-1}}
    assert found == {frozenset(group) for group in components(rows_of(case), case.inputs["pinned"])}


def one_pass(nodes, pinned):
    """Let each impact take the zone of the first one before it with which it shares a vertex."""
    zone_of_vertex, zone = {}, []
    for j, row in enumerate(nodes):
        own = [v for v in row if not pinned[v]]
        known = [zone_of_vertex[v] for v in own if v in zone_of_vertex]
        zone.append(-1 if not own else min(known, default=j))
        zone_of_vertex.update(dict.fromkeys(own, zone[-1]))
    return zone


def two_passes(nodes, pinned):
    """Spread the smallest number over neighbours twice."""
    zone = [j if any(not pinned[v] for v in row) else -1 for j, row in enumerate(nodes)]
    for _ in range(2):
        least = {}
        for row, z in zip(nodes, zone, strict=True):
            for v in row:
                if not pinned[v]:
                    least[v] = min(least.get(v, z), z)
        for j, row in enumerate(nodes):
            zone[j] = min((least[v] for v in row if v in least), default=-1)
    return zone


def joined_by_pinned(nodes, pinned):
    return groups.zones(nodes, [0] * len(pinned))


def at_most_100(nodes, pinned):
    return [min(z, 99) for z in groups.zones(nodes, pinned)]


def numbers_in_a_byte(nodes, pinned):
    return [z % 256 if z >= 0 else -1 for z in groups.zones(nodes, pinned)]


def one_block(nodes, pinned):
    zone = groups.zones(nodes[:1024], pinned)
    return zone + [-1] * (len(nodes) - len(zone))


def first_vertices_only(nodes, pinned):
    return groups.zones([[row[0]] * 4 for row in nodes], pinned)


@pytest.mark.parametrize(
    ("flag", "wrong", "least"),
    [
        ("zone-transitive", one_pass, 5),
        ("zone-transitive", two_passes, 4),
        ("zone-transitive", first_vertices_only, 10),
        ("zone-pinned", joined_by_pinned, 7),
        ("zone-capacity", at_most_100, 2),
        ("zone-capacity", numbers_in_a_byte, 1),
        ("zone-capacity", one_block, 1),
    ],
    ids=lambda part: getattr(part, "__name__", str(part)),
)
def test_mistakes_are_caught(flag, wrong, least):
    assert len(caught(flag, CASES, passes(wrong))) >= least

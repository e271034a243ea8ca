"""Selection and zones in plain Python: the references of stages S4 and S5."""

from __future__ import annotations

from collections.abc import Sequence

SOON = 1.5  # in a deep zone, an impact may be later than the first of a main vertex by this factor
Quads = Sequence[Sequence[int]]


def select(
    toi: Sequence[float],
    nodes: Quads,
    pinned: Sequence[int],
    selection: str,
    weights: Sequence[Sequence[float]] = (),
    edge_edge: Sequence[int] = (),
) -> list[int]:
    """Return which impacts enter the zones.

    Args:
        toi: Time of each impact.
        nodes: The four vertices of each impact.
        pinned: For each vertex, 1 if it is pinned.
        selection: `independent`, `first-of-any`, `all` or `deep`.
        weights: The four weights of each impact; `deep` reads them.
        edge_edge: For each impact, 1 if it is between edges; `deep` reads it.

    Returns:
        For each impact, 1 if it is selected.
    """
    impacts = range(len(toi))
    if selection == "all":
        return [1 for _ in impacts]
    unpinned = [{v for v in row if not pinned[v]} for row in nodes]
    order = sorted(impacts, key=lambda j: toi[j])  # keeps the given order of equal times
    if selection == "independent":
        return _independent(order, unpinned)
    if selection == "first-of-any":
        return _first_of_any(order, unpinned)
    mains = [main_vertices(*pair, pinned) for pair in zip(nodes, weights, strict=True)]
    order = _not_late(sorted(impacts, key=lambda j: (edge_edge[j], toi[j])), toi, mains)
    return _first_of_any(order, mains)


def main_vertices(
    nodes: Sequence[int], weights: Sequence[float], pinned: Sequence[int]
) -> set[int]:
    """Return the unpinned vertex of the largest weight on each side of an impact."""
    result: set[int] = set()
    for sign in (1.0, -1.0):
        side = [k for k in range(4) if sign * weights[k] > 0.0 and not pinned[nodes[k]]]
        if side:
            result.add(nodes[max(side, key=lambda k: sign * weights[k])])
    return result


def zones(nodes: Quads, pinned: Sequence[int]) -> list[int]:
    """Return the zone of each impact, numbered by their first impacts; -1 if all is pinned."""
    by_vertex: dict[int, list[int]] = {}
    for j, row in enumerate(nodes):
        for vertex in row:
            if not pinned[vertex]:
                by_vertex.setdefault(vertex, []).append(j)
    zone = [-1] * len(nodes)
    count = 0
    for first, row in enumerate(nodes):
        if zone[first] >= 0 or all(pinned[vertex] for vertex in row):
            continue
        zone[first], reached = count, [first]
        while reached:
            for vertex in nodes[reached.pop()]:
                for j in by_vertex.pop(vertex, ()):
                    if zone[j] < 0:
                        zone[j] = count
                        reached.append(j)
        count += 1
    return zone


def _independent(order: list[int], unpinned: list[set[int]]) -> list[int]:
    """Take an impact if none of its vertices is in one that was taken before."""
    selected, used = [0] * len(order), set[int]()
    for j in order:
        if not unpinned[j] & used:
            selected[j] = 1
            used |= unpinned[j]
    return selected


def _first_of_any(order: list[int], vertices: list[set[int]]) -> list[int]:
    """Take an impact if it is the first one for one of its vertices."""
    selected, seen = [0] * len(vertices), set[int]()
    for j in order:
        if vertices[j] - seen:
            selected[j] = 1
        seen |= vertices[j]
    return selected


def _not_late(order: list[int], toi: Sequence[float], mains: list[set[int]]) -> list[int]:
    """Leave out the impacts that are much later than the first one at a main vertex."""
    first: dict[int, float] = {}
    for j, vertices in enumerate(mains):
        for vertex in vertices:
            first[vertex] = min(first.get(vertex, toi[j]), toi[j])
    return [j for j in order if toi[j] <= SOON * min(first[v] for v in mains[j])]

"""Vectors of stage S4: which impacts enter the zones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random

from izo_ref.porting.cases import ACCEPTABLE, DTYPES, VALID, Case
from izo_ref.porting.generate.random_numbers import shuffled
from izo_ref.porting.generate.small_zones import some
from izo_ref.porting.reference.groups import select

ULP = 2.0**-52
ULP_F4 = 2.0**-23
IN_A_ROW = ("independent", "first-of-any", "all")
Quads = Sequence[Sequence[int]]


def _case(
    word: str,
    number: int,
    flags: tuple[str, ...],
    grade: str,
    what: str,
    groups: tuple[Sequence[float], Quads, Sequence[int], str],
    deep: tuple[Sequence[Sequence[float]], Sequence[int]] | None = None,
    **changes: object,
) -> Case:
    """Return a case; `groups` are the times, the nodes, the pinned flags and the selection."""
    toi, nodes, pinned, selection = groups
    inputs: dict[str, object] = {
        "toi": [float(t) for t in toi],
        "nodes": [v for row in nodes for v in row],
        "pinned": list(pinned),
        "selection": selection,
    }
    if deep is not None:
        inputs["weights"] = [float(w) for row in deep[0] for w in row]
        inputs["edge_edge_impacts"] = list(deep[1])
    weights, kinds = deep or ((), ())
    selected = select(*groups, weights, kinds)
    expected: Mapping[str, object] = {"selected": {"judge": "equal", "values": selected}}
    case = Case(f"S4-{word}-{number:02}", "S4", flags, VALID, grade, DTYPES, what, inputs, expected)  # pyright: ignore[reportArgumentType]
    return case._replace(**changes)  # pyright: ignore[reportArgumentType]


def _free(count: int) -> list[int]:
    return [0] * count


def _chain(length: int) -> list[list[int]]:
    """Return impacts in a row; each shares one vertex with the next."""
    return [[3 * j, 3 * j + 1, 3 * j + 2, 3 * j + 3] for j in range(length)]


def _random(seed: int, count: int, vertices: int, times: int) -> tuple[list[float], Quads]:
    """Return times, out of a few, and impacts of random vertices."""
    random = Random(seed)
    nodes = [shuffled(random, range(vertices))[:4] for _ in range(count)]
    return [int(times * random.random()) / 64.0 for _ in range(count)], nodes


def _order() -> list[Case]:
    """Return cases in which the order of times decides."""
    own = ("selection-order",)
    pair = [[0, 1, 2, 3], [3, 4, 5, 6]]
    three = _chain(3)
    long = [t / 64.0 for t in shuffled(Random(41), range(40))]
    near = [0.5 + ULP, 0.5]
    cover = [[0, 1, 2, 3], [2, 3, 4, 5], [4, 5, 6, 7]]
    return [
        _case(
            "order", 1, own, "easy",
            "Two impacts share a vertex, and the one that is listed later comes first in time.",
            ([0.75, 0.25], pair, _free(7), "independent"),
        ),
        _case(
            "order", 2, own, "medium",
            "Of three impacts in a chain, the second loses to the first; the third is taken, "
            "because an impact that was not taken holds no vertex.",
            ([0.25, 0.5, 0.75], three, _free(10), "independent"),
        ),
        _case(
            "order", 3, own, "medium",
            "The middle impact of a chain is the earliest, so it alone is taken.",
            ([0.5, 0.25, 0.75], three, _free(10), "independent"),
        ),
        _case(
            "order", 4, own, "hard",
            "A chain of 40 impacts in a shuffled order of times.",
            (long, _chain(40), _free(121), "independent"),
        ),
        _case(
            "order", 5, own, "easy",
            "An impact that shares a vertex with an earlier one is taken by first-of-any, because "
            "it is the first for its other vertices.",
            ([0.25, 0.5], pair, _free(7), "first-of-any"),
        ),
        _case(
            "order", 6, own, "medium",
            "The last of three impacts is the first for none of its vertices.",
            ([0.25, 0.75, 0.5], cover, _free(8), "first-of-any"),
        ),
        _case(
            "order", 7, own, "easy",
            "The selection `all` takes impacts that share vertices too.",
            ([0.75, 0.25], pair, _free(7), "all"),
        ),
        _case(
            "order", 8, own, "hard",
            "The times of two impacts differ by one ulp of float64.",
            (near, pair, _free(7), "independent"),
            dtypes=("f8",),
        ),
        _case(
            "order", 9, own, "hard",
            "The times of two impacts differ by one ulp of float32.",
            ([0.25 + ULP_F4 / 4, 0.25], pair, _free(7), "independent"),
        ),
        _case(
            "order", 10, own, "easy",
            "There are no impacts.",
            ([], [], _free(3), "independent"),
        ),
    ]  # fmt: skip


def _ties() -> list[Case]:
    """Return cases with equal times."""
    own = ("selection-ties", "selection-order")
    pair = [[3, 4, 5, 6], [0, 1, 2, 3]]
    star = [[0, 3 * j + 1, 3 * j + 2, 3 * j + 3] for j in range(30)]
    toi, nodes = _random(42, 60, 40, 3)
    other, more = _random(43, 60, 60, 2)
    random = Random(47)
    lots = [some(random, 4, 1500) for _ in range(1100)]
    ends = [int(64 * random.random()) / 64.0 for _ in lots]
    return [
        _case(
            "ties", 1, own, "easy",
            "Two impacts share a vertex and have equal times, so the first in the list is taken.",
            ([0.5, 0.5], pair, _free(7), "independent"),
        ),
        _case(
            "ties", 2, own, "medium",
            "Thirty impacts at one vertex, all at t = 0. Sorts of many numbers are often not "
            "stable although sorts of few are.",
            ([0.0] * 30, star, _free(91), "independent"),
        ),
        _case(
            "ties", 3, own, "hard",
            "The times are 0 and -0, which are equal, although their bits differ.",
            ([0.0, -0.0], pair, _free(7), "independent"),
        ),
        _case(
            "ties", 4, own, "hard",
            "Sixty random impacts with three different times.",
            (toi, nodes, _free(40), "independent"),
        ),
        _case(
            "ties", 5, own, "hard",
            "Sixty random impacts with two different times.",
            (other, more, _free(60), "first-of-any"),
        ),
        _case(
            "ties", 6, own, "hard",
            "1100 impacts with 64 different times: more than one block of threads sorts.",
            (ends, lots, _free(1500), "independent"),
        ),
    ]  # fmt: skip


def _pinned() -> list[Case]:
    """Return cases with pinned vertices."""
    own = ("zone-pinned", "selection-order")
    pair = [[0, 1, 2, 3], [3, 4, 5, 6]]
    toi, nodes = _random(44, 50, 36, 64)
    flags = [int(v % 3 == 0) for v in range(36)]
    unpinned = [j for j, row in enumerate(nodes) if not all(flags[v] for v in row)]
    mixed = ([toi[j] for j in unpinned], [nodes[j] for j in unpinned], flags)
    blocked = [[0, 1, 2, 3], [2, 3, 4, 5]]
    may_refuse = (
        "Such an impact has no unknowns, so a port may refuse it or leave it out before selection."
    )
    cases = [
        _case(
            "pinned", 1, own, "easy",
            "Two impacts share a pinned vertex alone, so both are taken.",
            ([0.25, 0.5], pair, [0, 0, 0, 1, 0, 0, 0], "independent"),
        ),
        _case(
            "pinned", 2, own, "medium",
            "The only unpinned vertex of the second impact is in the first one, which is earlier.",
            ([0.25, 0.5], pair, [0, 0, 0, 0, 1, 1, 1], "first-of-any"),
        ),
        _case(
            "pinned", 3, own, "hard",
            "Random impacts; every third vertex is pinned.",
            (*mixed, "independent"),
        ),
        _case(
            "pinned", 4, own, "hard",
            "Random impacts; every third vertex is pinned.",
            (*mixed, "first-of-any"),
        ),
    ]  # fmt: skip
    for number, selection in enumerate(IN_A_ROW[:2], len(cases) + 1):
        taken = "taken" if selection == "independent" else "not taken"
        what = (
            f"All vertices of the first impact are pinned: by the words of the rule it is {taken} "
            f"by {selection}. {may_refuse}"
        )
        groups = ([0.25, 0.5], blocked, [1, 1, 1, 1, 0, 0], selection)
        cases.append(_case("pinned", number, own, "hard", what, groups, verdict=ACCEPTABLE))
    return cases


FACE = (1.0, -0.5, -0.25, -0.25)
EDGES = (0.75, 0.25, -0.625, -0.375)


def _deep() -> list[Case]:
    """Return cases of deep zones."""
    own = ("selection-deep",)
    apart = [[0, 1, 2, 3], [4, 5, 6, 7]]
    shared = [[0, 1, 2, 3], [4, 2, 5, 6]]
    same = [[0, 1, 2, 3], [0, 1, 4, 5]]
    stack = [[0, 1, 2, 3], [0, 4, 5, 6], [7, 4, 8, 9], [0, 1, 8, 9]]
    toi, nodes = _random(45, 50, 30, 64)
    random = Random(46)
    kinds = [int(random.random() < 0.5) for _ in range(50)]
    weights = [_weights(random, kind) for kind in kinds]
    flags = [int(v % 5 == 0) for v in range(30)]
    toi = [0.25 + t / 4.0 for t in toi]
    kept = [j for j, row in enumerate(nodes) if not all(flags[v] for v in row)]
    return [
        _case(
            "deep", 1, own, "easy",
            "Two impacts share a vertex that is not a main vertex of either, so both are taken.",
            ([0.25, 0.25], shared, _free(7), "deep"), ([FACE, FACE], [0, 0]),
        ),
        _case(
            "deep", 2, own, "medium",
            "The second impact shares its main vertices with the first one, although its other "
            "vertices are new.",
            ([0.25, 0.3125], same, _free(6), "deep"), ([FACE, FACE], [0, 0]),
        ),
        _case(
            "deep", 3, own, "medium",
            "The second impact is later than 1.5 times the first time of its main vertex, so it "
            "waits, although its other main vertex is new.",
            ([0.25, 0.4375, 0.5, 0.375], stack, _free(10), "deep"), ([FACE] * 4, [0] * 4),
        ),
        _case(
            "deep", 4, own, "medium",
            "An impact of edges is earlier, but the impact of a vertex with a face comes first.",
            ([0.25, 0.3125], [[0, 1, 4, 5], [0, 4, 2, 3]], _free(6), "deep"),
            ([EDGES, FACE], [1, 0]),
        ),
        _case(
            "deep", 5, own, "hard",
            "The vertex of the largest weight of a face is pinned, so another corner counts.",
            ([0.25, 0.3125], [[0, 1, 2, 3], [0, 2, 1, 5]], [0, 1, 0, 0, 0, 0], "deep"),
            ([(1.0, -0.5, -0.375, -0.125), (1.0, -0.5, -0.125, -0.375)], [0, 0]),
        ),
        _case(
            "deep", 6, own, "hard",
            "The time of the second impact is 1.5 times the first one exactly, so it need not "
            "wait.",
            ([0.25, 0.375], [[0, 1, 2, 3], [0, 4, 5, 6]], _free(7), "deep"),
            ([FACE, FACE], [0, 0]),
        ),
        _case(
            "deep", 7, own, "easy",
            "Two impacts of edges without a common vertex are taken.",
            ([0.25, 0.75], apart, _free(8), "deep"), ([EDGES, EDGES], [1, 1]),
        ),
        _case(
            "deep", 8, own, "hard",
            "Fifty random impacts of both kinds; some vertices are pinned.",
            ([toi[j] for j in kept], [nodes[j] for j in kept], flags, "deep"),
            ([weights[j] for j in kept], [kinds[j] for j in kept]),
        ),
    ]  # fmt: skip


def _weights(random: Random, kind: int) -> tuple[float, ...]:
    """Return weights in 64ths; no two on one side are equal."""
    if kind:
        b, c = (33 + int(30 * random.random()) for _ in range(2))
        return (1.0 - b / 64.0, b / 64.0, c / 64.0 - 1.0, -c / 64.0)
    b = 1 + int(14 * random.random())
    c = 17 + int(10 * random.random())
    return (1.0, -b / 64.0, -c / 64.0, (b + c) / 64.0 - 1.0)


def cases() -> list[Case]:
    """Return the cases of stage S4."""
    return [*_order(), *_ties(), *_pinned(), *_deep()]

"""Vectors of stage S5: which impacts are in one zone."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from izo_ref.porting.cases import ACCEPTABLE, DTYPES, VALID, Case
from izo_ref.porting.generate.random_numbers import shuffled
from izo_ref.porting.reference.groups import zones

Quads = Sequence[Sequence[int]]


def _case(
    word: str,
    number: int,
    flags: tuple[str, ...],
    grade: str,
    what: str,
    nodes: Quads,
    pinned: Sequence[int],
    verdict: str = VALID,
) -> Case:
    inputs = {"nodes": [v for row in nodes for v in row], "pinned": list(pinned)}
    zone = {"judge": "partition", "values": zones(nodes, pinned)}
    name = f"S5-{word}-{number:02}"
    return Case(name, "S5", flags, verdict, grade, DTYPES, what, inputs, {"zone_of_impact": zone})


def _free(nodes: Quads) -> list[int]:
    """Return flags of vertices that are not pinned, up to the highest one in use."""
    return [0] * (1 + max((v for row in nodes for v in row), default=0))


def _pinned(nodes: Quads, vertices: Sequence[int]) -> list[int]:
    return [int(v in set(vertices)) for v in range(len(_free(nodes)))]


def chain(length: int) -> list[list[int]]:
    """Return impacts in a row; each shares one vertex with the next."""
    return [[3 * j, 3 * j + 1, 3 * j + 2, 3 * j + 3] for j in range(length)]


def star(length: int, center: int = 0) -> list[list[int]]:
    """Return impacts that all share one vertex, and no other."""
    return [[center, *(center + 3 * j + k for k in (1, 2, 3))] for j in range(length)]


def _bridges(levels: int) -> list[list[int]]:
    """Return single impacts, then impacts that join them by twos, by fours, and so on."""
    count = 2**levels
    nodes = [[4 * j, 4 * j + 1, 4 * j + 2, 4 * j + 3] for j in range(count)]
    own = 4 * count
    for level in range(levels):
        width = 2**level
        for first in range(0, count, 2 * width):
            nodes.append([4 * first + 3, own, own + 1, 4 * (first + width) + level % 3])
            own += 2
    return nodes


def _random(seed: int, count: int, vertices: int) -> list[list[int]]:
    random = Random(seed)
    return [shuffled(random, range(vertices))[:4] for _ in range(count)]


def _transitive() -> list[Case]:
    """Return cases of zones that chains connect."""
    own = ("zone-transitive",)
    mixed = shuffled(Random(51), chain(60))
    ring = [[*row[:3], row[3] % 90] for row in chain(30)]
    joined = [*star(6), *star(6, 19), [5, 38, 39, 24]]
    every = _random(52, 24, 120)
    comb = [[4 * j, 4 * j + 1, 4 * j + 2, 4 * j + 3] for j in range(20)]
    comb += [[4 * j + 3, 80 + 2 * j, 81 + 2 * j, 4 * j + 4] for j in reversed(range(19))]
    lots: list[tuple[str, str, Quads]] = [
        ("easy", "Two impacts share a vertex, and a third one shares none.",
         [[0, 1, 2, 3], [4, 5, 6, 7], [3, 8, 9, 10]]),
        ("easy", "The first and the last of three impacts share no vertex, but the second links "
         "them.", chain(3)),
        ("medium", "The impact that links two others comes last in the list.",
         [[0, 1, 2, 3], [6, 7, 8, 9], [3, 4, 5, 6]]),
        ("medium", "A chain of ten impacts, given backwards: one pass that takes over the number "
         "of a neighbour does not reach the end.", chain(10)[::-1]),
        ("hard", "A chain of 60 impacts in a shuffled order.", mixed),
        ("hard", "A chain of 300 impacts, given backwards: a search that calls itself goes 300 "
         "levels deep.", chain(300)[::-1]),
        ("medium", "Twenty impacts share one vertex.", star(20)),
        ("medium", "Two stars, and an impact of the last line that links them.", joined),
        ("medium", "A closed chain of 30 impacts.", ring),
        ("hard", "Impacts that link others by twos, then by fours, up to all 32, so zones merge "
         "with zones.", _bridges(5)),
        ("hard", "Single impacts, then impacts that link neighbours from the last to the first.",
         comb),
        ("hard", "Random impacts: some form zones of several, some are alone.", every),
    ]  # fmt: skip
    return [
        _case("transitive", number, own, grade, what, nodes, _free(nodes))
        for number, (grade, what, nodes) in enumerate(lots, 1)
    ]


def _with_pinned() -> list[Case]:
    """Return cases in which pinned vertices must not join zones."""
    own = ("zone-pinned", "zone-transitive")
    three, ring = chain(3), [[*row[:3], row[3] % 36] for row in chain(12)]
    every = _random(53, 40, 90)
    some = [v for v in range(90) if v % 3 != 1]
    lots: list[tuple[str, str, Quads, Sequence[int], str]] = [
        ("easy", "The only vertex that two impacts share is pinned, so they are two zones.",
         [[0, 1, 2, 3], [3, 4, 5, 6]], [3], VALID),
        ("easy", "Ten impacts share one vertex, which is pinned, so they are ten zones.",
         star(10), [0], VALID),
        ("medium", "Two impacts share a pinned and an unpinned vertex, so they are one zone.",
         [[0, 1, 2, 3], [2, 3, 4, 5]], [3], VALID),
        ("medium", "One link of a chain is pinned, so the chain is two zones.",
         three, [3], VALID),
        ("medium", "Two links of a closed chain are pinned, so it is two zones.",
         ring, [6, 24], VALID),
        ("hard", "Vertices against one pinned face: each is a zone of its own.",
         [[3 + j, 0, 1, 2] for j in range(12)], [0, 1, 2], VALID),
        ("hard", "Random impacts; two of three vertices are pinned, and some impacts have "
         "no other ones.", every, some, VALID),
        ("medium", "All vertices of the middle impact are pinned, so it is in no zone (-1) and "
         "joins nothing.", [[0, 1, 2, 3], [2, 3, 4, 5], [4, 5, 6, 7]], [2, 3, 4, 5], VALID),
        ("hard", "All vertices are pinned, so no impact is in a zone. A port may refuse this.",
         three, range(10), ACCEPTABLE),
    ]  # fmt: skip
    return [
        _case("pinned", number, own, grade, what, nodes, _pinned(nodes, pinned), verdict)
        for number, (grade, what, nodes, pinned, verdict) in enumerate(lots, 1)
    ]


def _capacity() -> list[Case]:
    """Return cases with many zones, large zones, and vertices of high numbers."""
    own = ("zone-capacity", "zone-transitive")
    single = [[4 * j, 4 * j + 1, 4 * j + 2, 4 * j + 3] for j in range(150)]
    pairs = [[7 * j + k + i for i in range(4)] for j in range(140) for k in (0, 3)]
    gaps = [[17 * v for v in row] for row in shuffled(Random(54), chain(9))]
    apart = [[30 * j + 7 * k for k in range(4)] for j in range(45)]
    lots_of_zones = [
        [7 * j + k + i for i in range(4)] for j in range(1100) for k in (0, 3)[: 1 + j % 2]
    ]
    few = [[1800, 3, 900, 17], [900, 40, 41, 42], [5, 6, 7, 8]]
    lots: list[tuple[str, str, Quads]] = [
        ("easy", "There are no impacts, so there are no zones.", []),
        ("easy", "A few vertices of a large mesh are in impacts.", few),
        ("medium", "There are 150 zones of one impact each.", single),
        ("medium", "Vertex numbers have gaps.", [*gaps, *apart]),
        ("hard", "There are 140 zones of two impacts each, in a shuffled order.",
         shuffled(Random(55), pairs)),
        ("hard", "One zone has 400 impacts at one vertex.", star(400)),
        ("hard", "There are 1100 zones, every other one of two impacts: more than a byte counts,"
         " and more than threads of a block.", shuffled(Random(56), lots_of_zones)),
    ]  # fmt: skip
    return [
        _case("capacity", number, own, grade, what, nodes, _free(nodes))
        for number, (grade, what, nodes) in enumerate(lots, 1)
    ]


def cases() -> list[Case]:
    """Return the cases of stage S5."""
    return [*_transitive(), *_with_pinned(), *_capacity()]

"""Pairs that turn past each other closely: proving them apart takes many steps.

They come from a search over 400,000 random pairs on coarse grids, in which 14 pairs that are apart
needed more than eight steps of izo_ref's proof. A test holds the numbers of steps in the sentences.
"""

from __future__ import annotations

from izo_ref.porting.generate.pairs import Named
from izo_ref.porting.reference.contact import Pair

WHAT = "{} that turn past each other and stay apart; izo_ref proves it in {} steps."


def _named(grade: str, steps: int, pair: Pair) -> Named:
    sides = "Two edges" if pair.is_edge_edge else "A vertex and a face"
    return Named("turning-past", ("step-cap",), grade, pair, WHAT.format(sides, steps))


MISSES = (
    _named(
        "easy",
        11,
        Pair(
            False,
            [
                (-0.625, -0.75, -1.625),
                (0.25, -0.5, -1.5),
                (1.375, -0.875, 1.25),
                (-1.5, -1.125, -0.625),
            ],
            [(1.75, -0.75, 2.0), (-1.375, -1.0, -0.375), (-1.25, 0.5, -1.0), (1.75, -0.875, -2.0)],
        ),
    ),
    _named(
        "medium",
        12,
        Pair(
            True,
            [(-1.0, 1.0, -0.75), (0.5, -0.25, 1.75), (1.5, 1.0, 1.0), (-0.75, -0.25, 0.25)],
            [(1.25, 1.5, 0.25), (0.75, 1.5, -1.5), (-1.25, 0.0, -1.0), (-1.75, 1.25, 0.0)],
        ),
    ),
    _named(
        "medium",
        18,
        Pair(
            True,
            [(0.125, 0.25, -1.625), (1.0, 0.25, 0.5), (-1.125, -0.125, -2.0), (1.0, 0.625, -0.375)],
            [(-1.75, 0.0, 1.375), (1.875, 1.5, -0.625), (0.5, -1.375, 0.5), (-1.75, -0.875, -0.25)],
        ),
    ),
    _named(
        "hard",
        25,
        Pair(
            True,
            [(-0.5, -1.25, -0.5), (0.0, 1.0, -0.5), (0.5, 0.5, 1.0), (-0.75, -1.75, -0.75)],
            [(-0.75, -0.75, 1.75), (1.25, 1.25, 0.75), (-0.75, -0.25, -1.25), (-0.5, 0.25, 1.75)],
        ),
    ),
)

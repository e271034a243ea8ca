"""Search for slow steps: change the slowest recipes at random, and keep what takes longest.

Each try is a row. A try begins from a recipe among the slowest of one kind, so that no kind drives
out the others. What a try draws depends on the seed and on its number alone, and the recipes come
from the rows, so a search that was stopped goes on where it was.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from validation.rows import Row, Rows
from validation.study.parts import Say
from validation.study.stability_time.measure import measured, warm_up
from validation.study.stability_time.recipe import (
    KINDS,
    Recipe,
    described,
    mutated,
    recipe_of,
)

STUDY, KEYS = "time-search", ("seed", "number")
SEED, TRIES = 21, 240
TRIANGLES, MAX_SECONDS = 2000, 6.0
PARENTS = 3  # slowest recipes of a kind that are changed


def search(
    folder: Path,
    say: Say,
    *,
    seed: int = SEED,
    tries: int = TRIES,
    triangles: int = TRIANGLES,
    max_seconds: float = MAX_SECONDS,
) -> None:
    """Add the rows that a search lacks.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line of text for each try.
        seed: Seed of the search.
        tries: Number of tries; the first ones are the plain recipe of each kind.
        triangles: Triangles of each step, about.
        max_seconds: Time limit of each step [s]; a step that is cut counts with what it took.
    """
    rows = Rows(folder, STUDY, KEYS)
    missing = [k for k in range(tries) if not rows.has(seed=seed, number=k)]
    if missing:
        warm_up()
    for number in missing:
        rng = np.random.default_rng([seed, number])
        recipe = _next_recipe(rows.all(), seed, number, rng)
        row = measured(recipe, triangles, max_seconds)
        rows.add(seed=seed, number=number, **recipe._asdict(), **row)
        say(
            f"search {number}: {row.get('us_per_nlogn', 0.0):.1f} us/(n log n): {described(recipe)}"
        )


def _next_recipe(rows: list[Row], seed: int, number: int, rng: np.random.Generator) -> Recipe:
    """Return the recipe of a try: plain ones first, then changed ones of one kind after another."""
    kind = KINDS[number % len(KINDS)]
    if number < len(KINDS):
        return Recipe(kind)
    parents = slowest(rows, seed, kind)[:PARENTS]
    parent = recipe_of(parents[int(rng.integers(len(parents)))]) if parents else Recipe(kind)
    return mutated(parent, rng)


def slowest(rows: list[Row], seed: int, kind: str) -> list[Row]:
    """Return the tries of a kind that did not fail, the slowest for its size first.

    Args:
        rows: Rows of the search.
        seed: Seed of the search.
        kind: One of KINDS.
    """
    own = [row for row in rows if row["seed"] == seed and row["kind"] == kind]
    own = [row for row in own if row["outcome"] != "failed"]
    return sorted(own, key=lambda row: (-row["us_per_nlogn"], row["number"]))

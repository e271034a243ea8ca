"""Recipes of steps: what a search for slow steps changes, one gene at a time."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from validation.rows import Row

KINDS = ("sheets", "fan", "soup", "weave", "hub", "balls")


class Gene(NamedTuple):
    """A number of a recipe.

    Attributes:
        low: Least value.
        high: Largest value.
        by_factor: Whether it changes by a factor; else by a difference.
        zero: Whether it may also be exactly 0, where degenerate cases are.
    """

    low: float
    high: float
    by_factor: bool = True
    zero: bool = False


GENES = {
    "layers": Gene(2.0, 60.0),
    "aspect": Gene(1.0, 1e4),
    "depth": Gene(0.05, 100.0),
    "slide": Gene(0.01, 100.0, zero=True),
    "noise": Gene(0.01, 10.0, zero=True),
    "uneven": Gene(1e-6, 0.3, zero=True),
    "gap": Gene(1e-3, 3.0),
    "thickness": Gene(1e-6, 0.3),
    "mass_ratio": Gene(1.0, 1e12),
    "pinned": Gene(0.0, 0.9, by_factor=False),
}


class Recipe(NamedTuple):
    """How a step is made; a length of 1 is the edge of a cell.

    Attributes:
        kind: What the mesh is made of, one of KINDS; `shapes.py` says what each is.
        layers: Layers above one another, rounded.
        aspect: Length of a cell over its width: large ones are slivers.
        depth: How far layers are pressed together, over the height of all layers.
        slide: How far a layer slides in its plane.
        noise: How far each vertex is thrown at random.
        uneven: How uneven a layer is, over the gap; 0 is exactly plane.
        gap: Distance of neighbouring layers.
        thickness: Thickness.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.
        pinned: Share of the vertices that are pinned, and stay at rest.
    """

    kind: str
    layers: float = 4.0
    aspect: float = 1.0
    depth: float = 0.6
    slide: float = 0.3
    noise: float = 0.0
    uneven: float = 0.1
    gap: float = 0.5
    thickness: float = 1e-3
    mass_ratio: float = 1.0
    pinned: float = 0.0


def mutated(recipe: Recipe, rng: np.random.Generator) -> Recipe:
    """Return a recipe with one to three other genes.

    Args:
        recipe: The recipe that is changed.
        rng: Draws the genes and how they change.
    """
    for name in rng.choice(list(GENES), int(rng.integers(1, 4)), replace=False).tolist():
        recipe = recipe._replace(**{name: _changed(GENES[name], getattr(recipe, name), rng)})
    return recipe


def _changed(gene: Gene, value: float, rng: np.random.Generator) -> float:
    if gene.zero and rng.random() < 0.15:
        return 0.0
    if rng.random() < 0.25:  # anywhere
        if gene.by_factor:
            return math.exp(rng.uniform(math.log(gene.low), math.log(gene.high)))
        return float(rng.uniform(gene.low, gene.high))
    if gene.by_factor:
        value = max(value, gene.low) * math.exp(rng.normal())
    else:
        value += 0.2 * (gene.high - gene.low) * rng.normal()
    return float(min(max(value, gene.low), gene.high))


def recipe_of(row: Row) -> Recipe:
    """Return the recipe in the columns of a row."""
    return Recipe(row["kind"], *(float(row[name]) for name in Recipe._fields[1:]))


def described(recipe: Recipe) -> str:
    """Return the genes of a recipe that differ from those of a plain one, as a name."""
    plain = Recipe(recipe.kind)
    parts = [
        f"{name} {value:.3g}"
        for name, value in recipe._asdict().items()
        if name != "kind" and value != getattr(plain, name)
    ]
    return ", ".join([recipe.kind, *parts])

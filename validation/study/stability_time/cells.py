"""How the time of the slowest recipes grows with the size, and what is the cause."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from validation.rows import Row, Rows, read
from validation.study.parts import Say
from validation.study.stability_time.measure import measured, warm_up
from validation.study.stability_time.recipe import KINDS, described, recipe_of
from validation.study.stability_time.slow_search import SEED, STUDY, TRIANGLES, slowest

GROWTH, CELLS = "time-growth", "time-cells"
# Sizes over the size of the search. Recipes that take a minute at that size grow below it.
FACTORS, MAX_SECONDS = (0.125, 0.25, 0.5, 1, 2, 4, 8), 60.0
# Time that is not explained by a count is the rest. The counts of a stage say why it grows: pairs
# are what detection looks at, and the largest zone is what the solvers factor.
COUNTS = {
    "detect_s": "candidates",
    "certify_s": "candidates",
    "solve_s": "largest_zone",
    "judge_s": "impacts",
}
NAMES = {
    "detect_s": "detection",
    "certify_s": "the certificate",
    "solve_s": "solving zones",
    "judge_s": "judging zones",
    "candidates": "candidate pairs of all iterations",
    "largest_zone": "the largest zone",
    "impacts": "impacts",
    "iterations": "iterations",
}
# An exponent counts as larger than that of n log n if it is so by more than this many standard
# errors, and by more than a tenth.
SURE, CLEARLY = 2.0, 0.1


class Fit(NamedTuple):
    """A power law of some sizes."""

    exponent: float
    spread: float  # standard error of the exponent; NaN for two sizes


def fit_power(sizes: Sequence[float], values: Sequence[float]) -> Fit:
    """Fit value = c size^exponent by least squares of the logarithms.

    Args:
        sizes: At least two different sizes.
        values: A positive value for each.
    """
    x, y = np.log(np.asarray(sizes, float)), np.log(np.asarray(values, float))
    x = x - x.mean()
    exponent = float(x @ y / (x @ x))
    rest = y - y.mean() - exponent * x
    if len(x) < 3:
        return Fit(exponent, math.nan)
    return Fit(exponent, float(np.sqrt(rest @ rest / (len(x) - 2) / (x @ x))))


def exponent_of_nlogn(sizes: Sequence[float]) -> float:
    """Return the exponent that `fit_power` finds for n log n at some sizes."""
    return fit_power(sizes, [n * math.log(n) for n in sizes]).exponent


def measure_growth(
    folder: Path,
    say: Say,
    *,
    seed: int = SEED,
    triangles: int = TRIANGLES,
    max_seconds: float = MAX_SECONDS,
) -> None:
    """Add the rows of the slowest recipe of each kind at each size, as far as they are missing.

    Args:
        folder: Folder of the CSV files, with the rows of a search.
        say: Is called with a line of text for each step.
        seed: Seed of the search.
        triangles: Triangles of the steps of the search, about.
        max_seconds: Time limit of a step [s]. A kind that is cut is not made larger.
    """
    rows, found, warm = Rows(folder, GROWTH, ("cell", "size")), read(folder, STUDY), False
    for kind in KINDS:
        for row in slowest(found, seed, kind)[:1]:
            recipe = recipe_of(row)
            for size in (round(triangles * factor) for factor in FACTORS):
                if not rows.has(cell=described(recipe), size=size):
                    if not warm:
                        warm_up()
                    warm, own = True, measured(recipe, size, max_seconds)
                    rows.add(cell=described(recipe), size=size, **recipe._asdict(), **own)
                    say(f"growth: {kind}, {size}: {own.get('cpu_s')} CPU s")
                last = [
                    r for r in rows.all() if (r["cell"], r["size"]) == (described(recipe), size)
                ]
                if last[-1]["outcome"] == "failed" or last[-1]["cut"]:
                    break


def judge_cells(folder: Path, say: Say) -> None:
    """Add a row for each recipe whose growth was measured: its exponents and the cause.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line of text for each cell.
    """
    rows, measured_rows = Rows(folder, CELLS, ("cell",)), read(folder, GROWTH)
    for cell in dict.fromkeys(row["cell"] for row in measured_rows):
        if not rows.has(cell=cell):
            row = cell_of([row for row in measured_rows if row["cell"] == cell])
            rows.add(cell=cell, **row)
            say(f"cell: {cell}: {row['verdict']}; {row['cause']}")


def cell_of(rows: list[Row]) -> Row:
    """Return the columns of a cell: how its time grows, and why.

    Args:
        rows: Rows of the growth of one recipe.
    """
    whole = [row for row in rows if row["outcome"] != "failed" and not row["cut"]]
    cut = [row for row in rows if row["outcome"] != "failed" and row["cut"]]
    failed = [row for row in rows if row["outcome"] == "failed"]
    columns: Row = {
        "sizes": len(whole),
        "largest_size": max((row["size"] for row in whole), default=None),
        "cut_at_size": min((row["size"] for row in cut), default=None),
        "failed_at_size": min((row["size"] for row in failed), default=None),
        "all_free": all(row["free"] for row in whole + cut if row["status"] != "BLOCKED"),
    }
    if len(whole) < 2:
        last = (whole or cut or rows)[-1]
        return columns | {"verdict": "too slow to say how it grows", "cause": _cause([last])}
    sizes = [row["triangles"] for row in whole]
    fit, plain = fit_power(sizes, [row["cpu_s"] for row in whole]), exponent_of_nlogn(sizes)
    margin = max(CLEARLY, SURE * fit.spread if math.isfinite(fit.spread) else 0.0)
    faster = fit.exponent > plain + margin
    return columns | {
        "exponent": fit.exponent,
        "exponent_spread": None if math.isnan(fit.spread) else fit.spread,
        "exponent_of_nlogn": plain,
        "faster_than_nlogn": faster,
        "us_per_nlogn": whole[-1]["us_per_nlogn"],
        "verdict": f"time grows {'faster than' if faster else 'no faster than'} n log n",
        "cause": _cause(whole),
    }


def _cause(rows: list[Row]) -> str:
    """Say which stage takes most of the time at the largest size, and what its count does."""
    last = rows[-1]
    if last["outcome"] == "failed":
        return last["message"]
    stages = {name: last[name] for name in COUNTS}
    stage = max(stages, key=lambda name: stages[name])
    share = stages[stage] / max(last["wall_s"], 1e-12)
    text = f"{NAMES[stage]} takes {100.0 * min(share, 1.0):.0f} % of the time"
    for count in (COUNTS[stage], "iterations"):
        text += f"; {NAMES[count]}: {last[count]}"
        values = [row[count] for row in rows]
        if len(rows) > 1 and min(values) > 0:
            sizes = [row["triangles"] for row in rows]
            text += f", as n^{fit_power(sizes, values).exponent:.2f}"
    return text

"""Study of bad input: strange arrays, options and files, and what the program says of them.

Each family of inputs (`validation/fuzz/families.py`) is one row: how many inputs there were, how
many were accepted and refused, by which errors, and how many crashed, hung, were accepted in spite
of the contract, refused in spite of it, or refused with a message that does not name the offender.
"""

from pathlib import Path

from validation.fuzz.families import COUNT, FAMILIES, SEED, count_of
from validation.fuzz.run import run_family
from validation.fuzz.trial import PROBLEMS
from validation.fuzz.warm import warm_up
from validation.rows import Rows
from validation.study.parts import Part, Say

KEYS = ("family", "inputs", "seed")


def measure(folder: Path, say: Say, total: int = COUNT, seed: int = SEED) -> None:
    """Run all families that have no row yet.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line for each problem and for each family.
        total: Number of inputs of all families.
        seed: The seed.
    """
    rows = Rows(folder, "fuzz", KEYS)
    missing = {
        name: family
        for name, family in FAMILIES.items()
        if not rows.has(family=name, inputs=count_of(family, total), seed=seed)
    }
    if missing:
        warm_up()
    for name, family in missing.items():
        row = run_family(name, family, seed, count_of(family, total), say)
        rows.add(**row)
        n_problems = sum(row[kind.replace(" ", "_")] for kind in PROBLEMS)
        say(f"{name}: {row['inputs']} inputs, {row['accepted']} accepted, {n_problems} problems")


def _all(folder: Path, say: Say) -> None:
    measure(folder, say)


PARTS: dict[str, Part] = {"input": _all}

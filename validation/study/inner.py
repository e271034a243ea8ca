"""Study of zones: error against run time of each solver, one row for each cell of `cells.plan`.

A cell is a family of zones, a solver and a tolerance. Its row has the median time of the family's
problems and their worst residuals and errors, which are computed outside the solver. It is one of
the studies of `python -m validation report`.
"""

import math
import time
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats, Multipliers
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.residuals import residuals
from validation.oracles.answer import scaled_zone
from validation.rows import Rows
from validation.scenes.zones import random_zone
from validation.study import own
from validation.study.cells import BATCH, LIBRARY, Cell, plan
from validation.study.families import SEED, Family, families
from validation.study.parts import Say
from validation.study.timing import measure, threads
from validation.study.truth import Truth

ASKED = (1e-3, 1e-6, 1e-9, 1e-12)


class Limits(NamedTuple):
    """How much work a cell may take."""

    call_s: float  # if a call takes longer than this, larger sizes are left out
    cell_s: float  # after this time a cell starts with no further problem
    repeats_s: float  # for the calls of one problem
    compared_s: float  # the same for dual methods and libraries, whose times are compared
    repeats: int
    visits: float  # steps times impacts of all problems of a cell, for methods that count steps
    problems: int  # largest number of problems, for methods that count steps


# a visit takes 75 ns, so a cell of 1e7 visits takes about a second
FULL = Limits(
    call_s=20.0, cell_s=1.0, repeats_s=0.1, compared_s=12.0, repeats=5, visits=1e7, problems=3
)
QUICK = Limits(
    call_s=0.5, cell_s=0.2, repeats_s=0.02, compared_s=0.02, repeats=3, visits=5e6, problems=2
)


class Outcome(NamedTuple):
    """The answer of a solver to one problem."""

    seconds: float  # for this problem; a share of the call if it solved several
    displacements: Floats  # (n, 3) f8 [m], from the proposed positions
    multipliers: Multipliers  # (n_impacts,) f8 [kg]
    steps: int | None  # None for libraries
    says: str  # message of a library


class Bench:
    """The problems of a family and their optima, made when they are first used.

    Args:
        family: The family.
    """

    def __init__(self, family: Family) -> None:
        """Keep the family; nothing is computed yet."""
        self.family = family

    @cached_property
    def problems(self) -> list[ZoneProblem]:
        """The problems of the family."""
        return self.family.problems()

    @cached_property
    def truths(self) -> list[Truth]:
        """The optimum of each problem."""
        return [Truth(problem) for problem in self.problems]

    @cached_property
    def many(self) -> list[ZoneProblem]:
        """As many problems as a step may have zones; the first ones are those of the family."""
        return [self.family.make(number) for number in range(BATCH)]


def run(rows_folder: Path, quick: bool, say: Say) -> None:
    """Add the rows that are missing.

    Args:
        rows_folder: Folder of `inner.csv`.
        quick: Measure a few families with little work.
        say: Is called with a line of text as the work goes on.
    """
    rows = Rows(rows_folder, "inner", Cell._fields)
    limits = QUICK if quick else FULL
    past = Past(limits, rows.all())
    compiled: set[tuple[str, ...]] = set()
    for family in families(quick):
        missing = [cell for cell in plan([family], quick) if not rows.has(**cell._asdict())]
        begin, bench = time.perf_counter(), Bench(family)
        for cell in missing:
            row = cell._asdict() | cell_row(cell, bench, limits, past, compiled)
            rows.add(**row)
            past.rows.append(row)
        if missing:
            say(f"inner: {family.name}, {len(missing)} rows, {time.perf_counter() - begin:.1f} s")


class Past:
    """The rows so far. They decide which cells are left out.

    If a solver took too long, it is not tried at larger sizes or smaller tolerances. If a method
    that counts steps did not converge, it is not tried at smaller tolerances.

    Args:
        limits: How much work a cell may take.
        rows: The rows so far.
    """

    def __init__(self, limits: Limits, rows: Iterable[dict[str, Any]]) -> None:
        """Keep the limits and a list of the rows."""
        self.limits, self.rows = limits, list(rows)

    def reason(self, cell: Cell, family: Family) -> str | None:
        """Return the reason why a cell is left out; None if it is measured."""
        for row in self.rows:
            same = tuple(row[name] for name in Cell._fields[1:6]) == cell.variant
            same = same and row["mode"] == cell.mode and row["series"] == family.series
            looser = row["tolerance"] > cell.tolerance
            here = row["family"] == cell.family
            if not same or row["outcome"] == "failed" or row["size"] > family.size:
                continue
            if here and not looser and row["tolerance"] != cell.tolerance:
                continue
            if (row["call_s"] or 0.0) > self.limits.call_s and (looser or not here):
                return f"took {row['call_s']:.1f} s at {row['size']} impacts"
            counts = cell.kind == "lagrangian" or cell.solver in own.FIRST_ORDER
            if here and looser and counts and row["outcome"] == "not converged":
                return f"not converged at {row['tolerance']:.0e}"
        return None


def cell_row(
    cell: Cell, bench: Bench, limits: Limits, past: Past, compiled: set[tuple[str, ...]]
) -> dict[str, Any]:
    """Measure a cell.

    Args:
        cell: The cell.
        bench: Problems of the cell's family.
        limits: How much work the cell may take.
        past: The rows so far.
        compiled: Variants of our solvers that were called before; this one is added.

    Returns:
        The columns beside the key.
    """
    family = bench.family
    row: dict[str, Any] = {
        "kind": cell.kind,
        "series": family.series,
        "size": family.size,
        "outcome": "not converged",
        "message": None,
        "reached": None,
        "seconds": None,
        "gap": None,
        "violation": None,
        "error": None,
        "truth": None,
        "problems": 0,
        "solved": 0,
        "steps": None,
        "max_steps": None,
        "call_s": None,
        "compile_s": None,
    }
    reason = past.reason(cell, family)
    if reason:
        return row | {"message": f"left out: {reason}"}
    try:
        if cell.kind == "library":
            outcomes = list(_library(cell, bench, limits))
        else:
            row["compile_s"] = _compile(cell, compiled)
            row["max_steps"] = _max_steps(cell, family, limits)
            outcomes = list(_own(cell, bench, limits, row["max_steps"]))
    except Exception as error:  # an exception of a solver is recorded in its row
        return row | {"outcome": "failed", "message": f"{type(error).__name__}: {error}"[:200]}
    return row | _judged(cell, bench, outcomes)


def _library(cell: Cell, bench: Bench, limits: Limits) -> Iterator[Outcome]:
    """Yield the answers of a library, until the time of the cell is spent."""
    library, spent = LIBRARY[cell.solver], 0.0
    for problem in bench.problems:
        zone = scaled_zone(problem)
        call, read = library.prepare(zone, cell.tolerance, limits.call_s)
        timing = measure(call, limits.repeats, limits.compared_s)
        found = read(timing.result)
        if found.z is None or found.multipliers is None:
            raise ArithmeticError(f"no answer: {found.says}")
        moves, multipliers = zone.displacements(found.z), zone.multipliers(found.multipliers)
        yield Outcome(timing.seconds, moves, multipliers, None, found.says)
        spent += timing.spent_s
        if spent > limits.cell_s:
            return


def _own(cell: Cell, bench: Bench, limits: Limits, max_steps: int | None) -> Iterator[Outcome]:
    """Yield the answers of one of our solvers, until the time of the cell is spent."""
    options = cell.setting.options(cell.tolerance, max_steps or 100_000)
    problems = bench.problems[: limits.problems if max_steps else None]
    groups = [bench.many] if cell.mode == "batch" else [[problem] for problem in problems]
    spent = 0.0
    budget_s = limits.compared_s if cell.kind == "dual" else limits.repeats_s
    with threads(cell.threads):
        for group in groups:
            call, read = own.prepare(group, options)
            timing = measure(call, limits.repeats, budget_s)
            for solved in read(timing.result):
                seconds = timing.seconds / len(group)
                yield Outcome(seconds, solved.displacements, solved.multipliers, solved.steps, "")
            spent += timing.spent_s
            if spent > limits.cell_s:
                return


def _max_steps(cell: Cell, family: Family, limits: Limits) -> int | None:
    """Return the limit of steps that bounds the work of a cell; None if steps are not counted."""
    if not cell.setting.counts_steps:
        return None
    problems = BATCH if cell.mode == "batch" else min(family.count, limits.problems)
    return max(10, int(limits.visits / (family.size * problems)))


def _compile(cell: Cell, compiled: set[tuple[str, ...]]) -> float | None:
    """Measure how much longer the first call of a variant takes than the second [s].

    Returns:
        The difference; None if the variant was called before.
    """
    if cell.variant in compiled:
        return None
    compiled.add(cell.variant)
    problem = random_zone(np.random.default_rng(SEED), 4)
    call, _ = own.prepare([problem], cell.setting.options(1e-3, 1000))
    begin = time.perf_counter()
    call()
    between = time.perf_counter()
    call()
    return max(0.0, 2.0 * between - begin - time.perf_counter())


def _judged(cell: Cell, bench: Bench, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Compute the worst residuals and errors of all problems, and the median of their times."""
    problems = bench.many if cell.mode == "batch" else bench.problems
    judged = [
        residuals(problem, problem.proposed + outcome.displacements, outcome.multipliers)
        for problem, outcome in zip(problems, outcomes, strict=False)
    ]
    # in a batch only the first problems, those of the family, have a known optimum
    errors = [
        truth.error(outcome.displacements)
        for truth, outcome in zip(bench.truths, outcomes, strict=False)
    ]
    solved = sum(r.solved(cell.tolerance, cell.tolerance) for r in judged)
    reached = [asked for asked in ASKED if all(r.solved(asked, asked) for r in judged)]
    said = sorted({outcome.says for outcome in outcomes} - {"", "solved"})
    calls = len(outcomes) if cell.mode == "batch" else 1
    steps = [outcome.steps for outcome in outcomes if outcome.steps is not None]
    return {
        "outcome": "converged" if solved == len(outcomes) else "not converged",
        "message": "; ".join(said)[:200] or None,
        "reached": min(reached, default=None),
        "seconds": float(np.median([outcome.seconds for outcome in outcomes])),
        "gap": _worst(r.gap for r in judged),
        "violation": _worst(r.violation for r in judged),
        "error": _worst(errors),
        "truth": bench.truths[0].says,
        "problems": len(outcomes),
        "solved": solved,
        "steps": float(np.median(steps)) if steps else None,
        "call_s": calls * max(outcome.seconds for outcome in outcomes),
    }


def _worst(values: Iterable[float]) -> float | None:
    """Return the largest value; NaN counts as infinity, and None means that there is no value."""
    return max((v if math.isfinite(v) else math.inf for v in values), default=None)

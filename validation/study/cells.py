"""The cells of the study of zones (`inner.py`): every combination that it measures.

The list is complete before anything is measured, so no cell can be missing without notice.
"""

from collections.abc import Iterable
from typing import NamedTuple

from validation.study.contestants import LIBRARIES
from validation.study.families import Family
from validation.study.own import (
    DIRECTIONS,
    DUAL,
    FIRST_ORDER,
    LINE_SEARCHES,
    PRESETS,
    Setting,
)
from validation.study.timing import thread_counts

BATCH = 256  # zones in one call, as a step may have them
BATCH_IMPACTS = 64  # largest number of impacts of a zone for which calls with many zones are timed
LARGE_IMPACTS = 1024  # least number of impacts of a zone that is timed alone on two threads
ACTIVE_SET_IMPACTS = 1024  # limit of the active set, which is dense: 8 n^2 bytes, n^3 operations
TOLERANCES = (1e-3, 1e-6, 1e-9)
QUICK_TOLERANCE = 1e-6
QUICK_LIBRARY = (1e-6, 1e-10)
HUGE_IMPACTS = 2048  # from this number of impacts on, a call takes seconds: few tolerances then


class Cell(NamedTuple):
    """The key columns of one row of the study."""

    family: str
    solver: str  # one of our methods, "preset ...", or the name of a library
    line_search: str = "-"
    update: str = "-"
    penalty: str = "-"
    precision: str = "float64"
    tolerance: float = 1e-9
    mode: str = "alone"  # one zone in a call, or "batch": BATCH zones in a call
    threads: int = 1

    @property
    def kind(self) -> str:
        """The kind of the solver: "library", "dual" or "lagrangian"."""
        if self.solver in LIBRARY:
            return "library"
        return "dual" if self.solver in DUAL else "lagrangian"

    @property
    def variant(self) -> tuple[str, ...]:
        """The columns that do not depend on size, tolerance and number of threads."""
        return self[1:6]

    @property
    def setting(self) -> Setting:
        """The setting of one of our solvers."""
        if self.solver.startswith("preset "):
            return Setting(preset=self.solver.removeprefix("preset "))
        if self.kind == "dual":
            return Setting(self.solver, precision=self.precision)
        return Setting(
            self.solver, self.line_search, self.update, self.penalty, None, self.precision
        )


LIBRARY = {contestant.name: contestant for contestant in LIBRARIES}


def plan(families: Iterable[Family], quick: bool) -> list[Cell]:
    """Return every cell of some families.

    Args:
        families: The families.
        quick: Fewer tolerances, variants and numbers of threads.

    Returns:
        The cells, family by family, looser tolerances first.
    """
    cells = []
    for family in families:
        cells += _dual(family, quick)
        cells += lagrangian_cells(family.name, quick)
        cells += _variants(family, quick)
        cells += _libraries(family, quick)
    return cells


def lagrangian_cells(family: str, quick: bool) -> list[Cell]:
    """Return the cells of one family with every direction and every line search."""
    return [
        Cell(family, direction, search, "every-step", "fixed", tolerance=tolerance)
        for direction in DIRECTIONS
        for search in LINE_SEARCHES
        for tolerance in ((QUICK_TOLERANCE,) if quick else TOLERANCES)
    ]


def _dual(family: Family, quick: bool) -> list[Cell]:
    """Return the cells of the dual methods."""
    cells = []
    for method in DUAL:
        if method == "active-set" and family.size > ACTIVE_SET_IMPACTS:
            continue
        if quick or family.size >= HUGE_IMPACTS:
            tolerances = (1e-9, 1e-12) if method == "auto" else (1e-9,)
        else:
            tolerances = (*TOLERANCES, 1e-12)
        for tolerance in tolerances:
            for mode, threads in _modes(family, method, quick):
                cells.append(
                    Cell(family.name, method, tolerance=tolerance, mode=mode, threads=threads)
                )
    if not quick:
        for method in FIRST_ORDER:
            for tolerance in TOLERANCES[:2]:
                cells.append(Cell(family.name, method, precision="float32", tolerance=tolerance))
    return cells


def _modes(family: Family, method: str, quick: bool) -> list[tuple[str, int]]:
    """Return each (mode, threads) in which a dual method is timed."""
    # the interior point solves zones one by one, however many a call has
    many = method != "interior-point"
    small, large = many and family.size <= BATCH_IMPACTS, many and family.size >= LARGE_IMPACTS
    modes = []
    for threads in thread_counts():
        if threads == 1 or large:
            modes.append(("alone", threads))
        if small and not (quick and threads > 1):
            modes.append(("batch", threads))
    return modes


def _variants(family: Family, quick: bool) -> list[Cell]:
    """Return cells with other updates and penalties, presets, and float32.

    Each of them has only one line search.
    """
    name, cells = family.name, []
    if quick:
        cells.append(Cell(name, "newton", "exact", "inner-solve", "grown", tolerance=1e-6))
    else:
        for direction in DIRECTIONS:
            # With 24,000 impacts, the other directions do not finish an inner solve in the allowed
            # steps, so mu would never grow.
            grows = direction == "newton" or family.size < HUGE_IMPACTS
            for penalty in ("fixed", "grown") if grows else ("fixed",):
                for tolerance in (1e-6, 1e-9) if direction == "newton" else (1e-6,):
                    cells.append(
                        Cell(name, direction, "exact", "inner-solve", penalty, tolerance=tolerance)
                    )
            for tolerance in TOLERANCES[:2]:
                cells.append(
                    Cell(name, direction, "exact", "every-step", "fixed", "float32", tolerance)
                )
    for preset in PRESETS:
        cells.append(Cell(name, f"preset {preset}", tolerance=1e-3))
    return cells


def _libraries(family: Family, quick: bool) -> list[Cell]:
    """Return the cells of the libraries of other authors."""
    few = quick or family.size >= HUGE_IMPACTS
    return [
        Cell(family.name, library.name, tolerance=tolerance)
        for library in LIBRARIES
        if family.size <= library.most
        for tolerance in library.tolerances
        if not few or tolerance in QUICK_LIBRARY or len(library.tolerances) == 1
    ]

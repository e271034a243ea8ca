"""What the study of zones runs: every cell, so that none can be missing without notice."""

from typing import NamedTuple

from validation.study.contestants import LIBRARIES
from validation.study.own import (
    DIRECTIONS,
    DUAL,
    FIRST_ORDER,
    LINE_SEARCHES,
    PRESETS,
    Setting,
)
from validation.study.timing import thread_counts

BATCH = 256  # zones in one call, as a step has them
BATCH_IMPACTS = 64  # of a zone, up to which calls with many zones are timed
LARGE_IMPACTS = 1024  # of a zone, from which one zone alone is timed on two threads
ACTIVE_SET_IMPACTS = 1024  # it is dense: 8 n^2 bytes, and n^3 operations
TOLERANCES = (1e-3, 1e-6, 1e-9)
QUICK_TOLERANCE = 1e-6
QUICK_LIBRARY = (1e-6, 1e-10)
HUGE_IMPACTS = 2048  # of a zone, from which few tolerances are asked for: seconds a call


class Cell(NamedTuple):
    """One row of the study: the key columns."""

    family: str
    solver: str  # a method of ours, "preset ...", or a library
    line_search: str = "-"
    update: str = "-"
    penalty: str = "-"
    precision: str = "float64"
    tolerance: float = 1e-9
    mode: str = "alone"  # one zone a call, or "batch": BATCH zones in one
    threads: int = 1

    @property
    def kind(self):
        if self.solver in LIBRARY:
            return "library"
        return "dual" if self.solver in DUAL else "lagrangian"

    @property
    def variant(self):
        """What is the same at every size, tolerance and number of threads."""
        return self[1:6]

    @property
    def setting(self) -> Setting:
        """Of one of our solvers."""
        if self.solver.startswith("preset "):
            return Setting(preset=self.solver.removeprefix("preset "))
        if self.kind == "dual":
            return Setting(self.solver, precision=self.precision)
        return Setting(
            self.solver, self.line_search, self.update, self.penalty, None, self.precision
        )


LIBRARY = {contestant.name: contestant for contestant in LIBRARIES}


def plan(families, quick) -> list[Cell]:
    """Every cell, family by family, looser tolerances first."""
    cells = []
    for family in families:
        cells += _dual(family, quick)
        cells += lagrangian_cells(family.name, quick)
        cells += _variants(family, quick)
        cells += _libraries(family, quick)
    return cells


def lagrangian_cells(family: str, quick) -> list[Cell]:
    """Directions times line searches, of one family."""
    return [
        Cell(family, direction, search, "every-step", "fixed", tolerance=tolerance)
        for direction in DIRECTIONS
        for search in LINE_SEARCHES
        for tolerance in ((QUICK_TOLERANCE,) if quick else TOLERANCES)
    ]


def _dual(family, quick):
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


def _modes(family, method, quick):
    """(mode, threads) in which a dual method is timed."""
    # the interior point takes zones one by one, however many a call has
    many = method != "interior-point"
    small, large = many and family.size <= BATCH_IMPACTS, many and family.size >= LARGE_IMPACTS
    modes = []
    for threads in thread_counts():
        if threads == 1 or large:
            modes.append(("alone", threads))
        if small and not (quick and threads > 1):
            modes.append(("batch", threads))
    return modes


def _variants(family, quick):
    """Other updates and penalties, presets, and float32, each with one line search."""
    name, cells = family.name, []
    if quick:
        cells.append(Cell(name, "newton", "exact", "inner-solve", "grown", tolerance=1e-6))
    else:
        for direction in DIRECTIONS:
            # on 24,000 impacts no inner solve of the others ends in the steps allowed: mu stays
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


def _libraries(family, quick):
    few = quick or family.size >= HUGE_IMPACTS
    return [
        Cell(family.name, library.name, tolerance=tolerance)
        for library in LIBRARIES
        if family.size <= library.most
        for tolerance in library.tolerances
        if not few or tolerance in QUICK_LIBRARY or len(library.tolerances) == 1
    ]

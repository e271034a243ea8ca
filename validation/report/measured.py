"""What the rows of the study of zones say: the times to an error, by family and solver."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from validation.rows import Row, read
from validation.study.cells import BATCH_IMPACTS, Cell
from validation.study.own import DIRECTIONS, DUAL

FIXED = tuple(method for method in DUAL if method != "auto")
NEARLY_FASTEST = 1.2  # times the fastest; a solver within it counts as among the fastest
# Errors to which solvers are compared.
ERROR, SMALL_ERROR = 1e-9, 1e-12


class Family(str):
    """The name of a family of zones, with the impacts of a zone in `size`."""

    size: int = 0


class Target(NamedTuple):
    """How fast the default has to be in a family."""

    ratio: float  # the largest of the default's time to the library's
    library: str | None  # None: the fastest


class Measured:
    """The rows of the study; only the last row of each key counts.

    Attributes:
        rows: The rows.
        families: The families, in the order of the rows.
    """

    rows: list[Row]
    families: list[Family]

    def __init__(self, folder: Path) -> None:
        """Read the rows from the folder of `inner.csv`."""
        by_key = {tuple(row[k] for k in Cell._fields): row for row in read(folder, "inner")}
        self.rows = list(by_key.values())
        self.families = []
        for row in self.rows:
            if row["family"] not in self.families:
                family = Family(row["family"])
                family.size = row["size"]
                self.families.append(family)

    def of(self, family: str, **columns: Any) -> list[Row]:
        """Return the rows of a family that have these values in these columns."""
        return [
            row
            for row in self.rows
            if row["family"] == family and all(row[k] == v for k, v in columns.items())
        ]

    def best(
        self,
        family: str,
        tolerance: float,
        mode: str | None = None,
        threads: int = 1,
        **columns: Any,
    ) -> Row | None:
        """Return the fastest row that reached a tolerance; None if none did.

        Args:
            family: The family of zones.
            tolerance: Error that the residuals have to reach.
            mode: "alone" or "batch", how many zones a call takes; None takes both.
            threads: Number of threads.
            columns: Further columns and their values.
        """
        rows = (
            row
            for row in self.of(family, threads=threads, **columns)
            if row["reached"] is not None
            and row["reached"] <= tolerance
            and (mode is None or row["mode"] == mode)
        )
        return min(rows, key=_seconds_of, default=None)

    def library(self, family: str, tolerance: float) -> Row | None:
        """Return the fastest row of a library, as `best`."""
        return self.best(family, tolerance, kind="library")

    def own(
        self, family: Family, tolerance: float, mode: str | None = None, **columns: Any
    ) -> Row | None:
        """Return the fastest row of our solvers, as `best`.

        If no mode is given, zones are called as a step calls them.
        """
        return self.best(family, tolerance, mode or own_mode(family), **columns)

    def fixed(self, family: Family, tolerance: float) -> dict[str, Row | None]:
        """Return the fastest row of each method but the default; None if it misses the error."""
        found = {}
        for method in (*FIXED, *DIRECTIONS):
            # only methods that gain by it are timed with many zones a call
            mode = "alone" if method in (*DIRECTIONS, "interior-point") else None
            found[method] = self.own(family, tolerance, mode, solver=method, precision="float64")
        return found


def own_mode(family: Family) -> str:
    """Return how a step calls zones of this size: "batch", many a call, or "alone"."""
    return "batch" if family.size <= BATCH_IMPACTS else "alone"


def target(family: Family) -> Target | None:
    """Return how fast the default has to be in a family; None if nothing is asked for."""
    if family.startswith("random-"):
        if family.size <= 64:
            return Target(0.2, None)
        return Target(0.5, None) if family.size <= 1024 else None
    return Target(0.5, "PIQP") if family.startswith("armadillo-") else None


def default_rows(measured: Measured) -> list[Row]:
    """Return a row for each family: the default next to a library and to each fixed method."""
    return [_default_row(measured, family) for family in measured.families]


def _default_row(measured: Measured, family: Family) -> Row:
    wanted = target(family)
    library = measured.library(family, ERROR)
    if wanted and wanted.library:
        library = measured.best(family, ERROR, solver=wanted.library)
    default = measured.own(family, ERROR, solver="auto")
    closer = measured.own(family, SMALL_ERROR, solver="auto")
    alone = measured.own(family, ERROR, "alone", solver="auto")
    most = max((row["threads"] for row in measured.of(family, solver="auto")), default=1)
    threaded = measured.own(family, ERROR, threads=most, solver="auto") or default
    ratio, ratio_12 = _ratio(default, library), _ratio(closer, library)
    ratio_many = _ratio(threaded, library)
    return {
        "family": str(family),
        "impacts": family.size,
        "default": _seconds(default),
        "default_12": _seconds(closer),
        "alone": _seconds(alone),
        "library": library and library["solver"],
        "library_s": _seconds(library),
        "ratio": ratio,
        "ratio_12": ratio_12,
        "ratio_alone": _ratio(alone, library),
        "target": wanted and wanted.ratio,
        "met": _met(ratio, wanted),
        "threads": threaded and threaded["threads"],
        "ratio_many": ratio_many,
        "met_many": _met(ratio_many, wanted),
        "met_12": _met(ratio_12, wanted),
        **_against_fixed(default, measured.fixed(family, ERROR).values(), library),
        "run": (default or library or {}).get("run"),
    }


def _against_fixed(default: Row | None, fixed: Iterable[Row | None], library: Row | None) -> Row:
    """Return how the default compares with the fastest fixed method, and with all others."""
    reached = [row for row in fixed if row]
    fastest = min(reached, key=_seconds_of, default=None)
    rivals = [row["seconds"] for row in (*reached, library) if row]
    among_fastest = None
    if rivals:
        among_fastest = bool(default) and default["seconds"] <= NEARLY_FASTEST * min(rivals)
    return {
        "fixed": fastest and fastest["solver"],
        "fixed_s": _seconds(fastest),
        "against_fixed": _ratio(default, fastest),
        "among_fastest": among_fastest,
    }


def _seconds_of(row: Row) -> float:
    return row["seconds"]


def _seconds(row: Row | None) -> float | None:
    return row["seconds"] if row else None


def _ratio(own: Row | None, other: Row | None) -> float | None:
    return own["seconds"] / other["seconds"] if own and other else None


def _met(ratio: float | None, wanted: Target | None) -> bool | None:
    return ratio <= wanted.ratio if wanted and ratio is not None else None


def label(row: Row) -> str:
    """Return the short name of a solver with its choices."""
    name = row["solver"]
    if row["kind"] == "lagrangian" and not name.startswith("preset"):
        name = f"{name}, {row['line_search']}"
        if row["update"] != "every-step":
            name += f", {row['update']}"
        if row["penalty"] != "fixed":
            name += f", mu {row['penalty']}"
    return name if row["precision"] == "float64" else f"{name}, {row['precision']}"


def duration(seconds: float | None) -> str:
    """Return a time with a unit that makes it readable; an empty string for None."""
    if seconds is None:
        return ""
    for unit, scale in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= 0.9995 * scale:
            return f"{seconds / scale:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"

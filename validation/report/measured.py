"""What the rows of the study of zones say: times at an error, by family and solver."""

from validation.rows import read
from validation.study.cells import BATCH_IMPACTS, Cell
from validation.study.own import DIRECTIONS, DUAL

FIXED = tuple(method for method in DUAL if method != "auto")
PARETO = 1.2  # within 20 % of the fastest


class Family(str):
    """A family's name, with its size."""

    size: int = 0


class Measured:
    """The rows, the last one of each key.

    Attributes:
        rows: list of dictionaries.
        families: `Family`s in the order of the rows.
    """

    def __init__(self, folder):
        by_key = {tuple(row[k] for k in Cell._fields): row for row in read(folder, "inner")}
        self.rows = list(by_key.values())
        self.families = []
        for row in self.rows:
            if row["family"] not in self.families:
                family = Family(row["family"])
                family.size = row["size"]
                self.families.append(family)

    def of(self, family, **columns):
        """Rows of a family with these values."""
        return [
            row
            for row in self.rows
            if row["family"] == family and all(row[k] == v for k, v in columns.items())
        ]

    def best(self, family, tolerance, mode=None, threads=1, **columns):
        """The fastest row that reached a tolerance; None if none did."""
        rows = [
            row
            for row in self.of(family, threads=threads, **columns)
            if row["reached"] is not None
            and row["reached"] <= tolerance
            and (mode is None or row["mode"] == mode)
        ]
        return min(rows, key=lambda row: row["seconds"], default=None)

    def library(self, family, tolerance):
        return self.best(family, tolerance, kind="library")

    def own(self, family, tolerance, mode=None, **columns):
        """As `best`, of one of ours, timed as a step solves zones unless a mode is given."""
        return self.best(family, tolerance, mode or own_mode(family), **columns)

    def fixed(self, family, tolerance):
        """{method: fastest row or None}, of each choice but the default."""
        found = {}
        for method in (*FIXED, *DIRECTIONS):
            # many zones a call are timed only of methods that gain by it
            mode = "alone" if method in (*DIRECTIONS, "interior-point") else None
            found[method] = self.own(family, tolerance, mode, solver=method, precision="float64")
        return found


def own_mode(family):
    """How zones of this size come: many in a call, or one."""
    return "batch" if family.size <= BATCH_IMPACTS else "alone"


def target(family):
    """(largest ratio wanted of the default to the fastest library, library), or None."""
    if family.startswith("random-"):
        if family.size <= 64:
            return 0.2, None
        return (0.5, None) if family.size <= 1024 else None
    return (0.5, "PIQP") if family.startswith("armadillo-") else None


def default_rows(measured) -> list[dict]:
    """A row a family: the default against the fastest library and every fixed choice."""
    rows = []
    for family in measured.families:
        wanted = target(family)
        default = measured.own(family, 1e-9, solver="auto")
        closer = measured.own(family, 1e-12, solver="auto")
        alone = measured.own(family, 1e-9, "alone", solver="auto")
        library = measured.library(family, 1e-9)
        if wanted and wanted[1]:
            library = measured.best(family, 1e-9, solver=wanted[1])
        fixed = {m: r for m, r in measured.fixed(family, 1e-9).items() if r}
        rivals = [row["seconds"] for row in (*fixed.values(), library) if row]
        best_fixed = min(fixed.values(), key=lambda row: row["seconds"], default=None)
        many = max((r["threads"] for r in measured.of(family, solver="auto")), default=1)
        together = measured.own(family, 1e-9, threads=many, solver="auto") or default
        ratio, ratio_many = _ratio(default, library), _ratio(together, library)
        row = {
            "family": str(family),
            "impacts": family.size,
            "default": _seconds(default),
            "default_12": _seconds(closer),
            "alone": _seconds(alone),
            "library": library and library["solver"],
            "library_s": _seconds(library),
            "ratio": ratio,
            "ratio_12": _ratio(closer, library),
            "ratio_alone": _ratio(alone, library),
            "target": wanted and wanted[0],
            "met": _met(ratio, wanted),
            "threads": together and together["threads"],
            "ratio_many": ratio_many,
            "met_many": _met(ratio_many, wanted),
            "met_12": _met(_ratio(closer, library), wanted),
            "fixed": best_fixed and best_fixed["solver"],
            "fixed_s": _seconds(best_fixed),
            "against_fixed": _ratio(default, best_fixed),
            "on_front": None,
            "run": (default or library or {}).get("run"),
        }
        if default and rivals:
            row["on_front"] = default["seconds"] <= PARETO * min(rivals)
        elif rivals:
            row["on_front"] = False
        rows.append(row)
    return rows


def _seconds(row):
    return row and row["seconds"]


def _ratio(own, other):
    return own["seconds"] / other["seconds"] if own and other else None


def _met(ratio, wanted):
    return ratio <= wanted[0] if wanted and ratio is not None else None


def label(row) -> str:
    """A solver with its choices, in short."""
    name = row["solver"]
    if row["kind"] == "lagrangian" and not name.startswith("preset"):
        name = f"{name}, {row['line_search']}"
        if row["update"] != "every-step":
            name += f", {row['update']}"
        if row["penalty"] != "fixed":
            name += f", mu {row['penalty']}"
    return name if row["precision"] == "float64" else f"{name}, {row['precision']}"


def duration(seconds) -> str:
    """With a unit that makes it readable; empty for None."""
    if seconds is None:
        return ""
    for unit, scale in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= 0.9995 * scale:
            return f"{seconds / scale:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"

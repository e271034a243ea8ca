"""The list of reports: what each shows, where its rows and page are, which commands make them."""

from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from validation import json_rows
from validation.rows import RUNS, Row, read, runs_of

PROGRAM = "python -m validation"


class Headline(NamedTuple):
    """A figure that stands for a report."""

    label: str  # what the figure is
    figure: str  # with its unit
    sentence: str  # what it was measured on, and what it does not say


class Report(NamedTuple):
    """A report; its module in `validation/report/` has `page` and `headlines`."""

    name: str  # of its module
    title: str
    question: str  # what it answers, one sentence
    command: str  # measures the rows that are missing, and writes the page
    rows: tuple[str, ...]  # patterns of its files, from the folder of the reports
    page: str  # from the folder of the reports

    @property
    def module(self) -> ModuleType:
        """The module that makes the page and the headlines from the rows."""
        return import_module(f"validation.report.{self.name}")

    @property
    def pages_command(self) -> str:
        """The command that measures nothing and writes the page from the rows."""
        return f"{self.command} --pages-only"

    def rows_folder(self, reports: Path) -> Path:
        """Return the folder of the rows, which `page` and `headlines` take."""
        return (reports / self.rows[0]).parent


def _study(name: str, title: str, question: str) -> Report:
    """Return one of the four reports that `python -m validation report` makes."""
    command = f"{PROGRAM} report --only {name}"
    return Report(name, title, question, command, (f"rows/{name}.csv",), f"{name}.html")


STUDIES = (
    _study(
        "inner",
        "Zones: error against run time",
        "How long each method takes to solve one zone to an error, next to other solvers.",
    ),
    _study(
        "outer",
        "Steps: objective against CPU time",
        "What a whole step costs, and how close it stays to the proposed positions, by selection, "
        "thickness and tolerance.",
    ),
    _study(
        "convergence",
        "Convergence",
        "How objective, violation and the number of new impacts change with each iteration.",
    ),
    _study(
        "scaling",
        "Scaling",
        "How time and memory grow with the triangles of a step and the impacts of a zone.",
    ),
)
OTHERS = (
    Report(
        "evidence",
        "Evidence",
        "Whether the result of every step file is free of contact and optimal, by four judges.",
        f"{PROGRAM} evidence",
        ("evidence/*.json",),
        "evidence/README.md",
    ),
    Report(
        "zones",
        "Zones: solvers against oracles",
        "How far each solver of zones is from the exact optimum.",
        f"{PROGRAM} zones",
        ("zones.json",),
        "zones.md",
    ),
    Report(
        "speed",
        "Speed",
        "How long detection and whole steps take, what each rule of the plan saves, and how fast a "
        "new process starts.",
        f"{PROGRAM} study speed",
        ("speed/rows/*.csv",),
        "speed/README.md",
    ),
    Report(
        "cuda",
        "On a GPU",
        "What the kernels need of a GPU, whether a GPU finds the same as the CPU, and how long it "
        "takes.",
        f"{PROGRAM} study cuda",
        ("cuda/rows/*.csv",),
        "cuda/README.md",
    ),
    Report(
        "stability",
        "Stability",
        "How far the method holds on stiff and extreme cases, and what the program says beyond.",
        f"{PROGRAM} study stability",
        ("stability/rows/*.csv",),
        "stability/README.md",
    ),
    Report(
        "sequences",
        "Animations",
        "What is written in every format, how tangled starts come apart, frames a second, memory.",
        f"{PROGRAM} study sequences",
        ("sequences/rows/*.csv",),
        "sequences/README.md",
    ),
    Report(
        "mutants",
        "Deliberate faults",
        "Whether the tests notice faults that were put into the code on purpose.",
        f"{PROGRAM} mutants",
        ("mutants.json",),
        "mutants.md",
    ),
    Report(
        "random_mutants",
        "Drawn faults",
        "Whether the tests notice faults that a seed drew by operator.",
        f"{PROGRAM} mutants --random 300 --seed 21",
        ("random_mutants.json",),
        "random_mutants.md",
    ),
    Report(
        "vectors",
        "Vectors",
        "Whether the vectors of the porting kit alone notice these faults.",
        f"{PROGRAM} mutants --vectors",
        ("vectors.json",),
        "vectors.md",
    ),
)
REPORTS = (*STUDIES, *OTHERS)


def commits(report: Report, reports: Path) -> list[str]:
    """Return the commits at which the rows of a report were measured, the oldest run first.

    Args:
        report: One of REPORTS.
        reports: The folder of the reports.
    """
    found: list[str] = []
    folders: dict[Path, list[Row]] = {}
    for path in (path for pattern in report.rows for path in sorted(reports.glob(pattern))):
        if path.suffix == ".csv" and path.stem != RUNS:
            folders.setdefault(path.parent, []).extend(read(path.parent, path.stem))
        elif path.suffix == ".json":
            loaded = json_rows.load(path)
            found += [loaded.made.commit] if loaded else []
    for folder, rows in folders.items():
        found += [run["commit"] for run in runs_of(folder, rows)]
    return list(dict.fromkeys(found))

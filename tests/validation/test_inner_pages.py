"""The pages of zones and of convergence show the figures of the rows and no others."""

import pytest

from validation.report import cells_table, convergence, inner
from validation.report.inner_plots import work_precision
from validation.report.measured import Family, Measured, default_rows, duration, target
from validation.rows import Rows
from validation.study.cells import Cell
from validation.study.convergence import KEYS

BASE = {
    "kind": "dual",
    "series": "random",
    "size": 64,
    "outcome": "converged",
    "message": None,
    "reached": 1e-12,
    "seconds": 1e-3,
    "gap": 1e-13,
    "violation": 1e-13,
    "error": 1e-13,
    "truth": "exact",
    "problems": 5,
    "solved": 5,
    "steps": 3.0,
    "max_steps": None,
    "call_s": 1e-3,
    "compile_s": None,
}


@pytest.fixture
def folder(tmp_path):
    """Write rows of one zone by several solvers, and return their folder."""
    rows = Rows(tmp_path, "inner", Cell._fields)

    def add(solver, seconds, **columns):
        names = {k: columns.pop(k) for k in Cell._fields if k in columns}
        cell = Cell("random-64", solver, **names)
        rows.add(**cell._asdict() | BASE | {"kind": cell.kind, "seconds": seconds} | columns)

    add("auto", 1e-4, mode="batch", compile_s=0.5)
    add("auto", 5e-5, mode="batch", threads=2)
    add("auto", 1e-3, mode="alone")
    add("active-set", 0.9e-4, mode="batch")
    add("DAQP", 1e-3, tolerance=1e-12)
    add("PIQP", 1e-5, tolerance=1e-6, reached=1e-6)
    add("gradient", 2e-2, line_search="exact", update="every-step", penalty="fixed",
        tolerance=1e-3, reached=1e-3)  # fmt: skip
    add("gradient", None, line_search="exact", update="every-step", penalty="fixed",
        tolerance=1e-6, reached=None, outcome="not converged",
        message="left out: took 60.0 s at 16 impacts")  # fmt: skip
    add("newton", None, line_search="wolfe", update="every-step", penalty="fixed",
        tolerance=1e-3, reached=None, outcome="failed", message="ValueError: no")  # fmt: skip
    return tmp_path


def test_the_default_is_compared_with_what_reached_the_tolerance(folder):
    (row,) = default_rows(Measured(folder))
    assert row["library"] == "DAQP", "PIQP is faster, but not to 1e-9"
    assert row["ratio"] == pytest.approx(0.1)
    assert row["ratio_alone"] == pytest.approx(1.0)
    assert row["target"] == 0.2
    assert row["met"]
    assert row["fixed"] == "active-set"
    assert row["against_fixed"] == pytest.approx(1.0 / 0.9)
    assert row["among_fastest"], "11 % slower than the fastest"


def test_a_default_that_is_too_slow_misses_its_target(folder):
    rows = Rows(folder, "inner", Cell._fields)
    slow = Cell("random-64", "auto", mode="batch")
    rows.add(**slow._asdict() | BASE | {"seconds": 3e-4})  # replaces the row of the same key
    (row,) = default_rows(Measured(folder))
    assert row["met"] is False
    assert row["among_fastest"] is False
    assert row["met_many"] is True  # the row of two threads is fast
    assert "1 of 1 targets are met, 0 on one thread" in inner.headlines(folder)[0][2]


def test_a_default_that_misses_the_tolerance_is_not_on_the_front(folder):
    rows = Rows(folder, "inner", Cell._fields)
    missed = Cell("random-64", "auto", mode="batch")
    rows.add(**missed._asdict() | BASE | {"reached": 1e-6, "outcome": "not converged"})
    (row,) = default_rows(Measured(folder))
    assert row["default"] is None
    assert row["ratio"] is None
    assert row["among_fastest"] is False


def test_cells_say_their_outcome(folder):
    cells = cells_table.outcomes(Measured(folder))
    assert len(cells) == 18
    said = {key[1:]: cells_table.cell_outcome(rows) for key, rows in cells.items()}
    assert said["gradient", "exact"] == ("1e-3 in 20 ms", 1e-3)
    assert said["newton", "wolfe"] == ("failed", None)
    assert said["cg", "exact"] == ("missing", None)
    counted = cells_table.counts(Measured(folder))
    assert (counted.cells, counted.missing, counted.failed) == (18, 16, 1)
    assert counted.reached == {1e-3: 1, 1e-6: 0, 1e-9: 0}


def test_the_page_of_zones_shows_rows_and_missing_cells(folder, tmp_path):
    path = inner.page(folder, tmp_path / "pages")
    text = path.read_text()
    assert text.count("<svg") == 6
    assert "There are 18 cells; 16 are missing and 1 failed." in text
    assert "Not measured in this run" in text
    plot = work_precision(Measured(folder), "gap")
    _, _, drawn = plot.partition('role="img"')
    assert drawn in text, "the same rows make the same plot"
    assert [label for label, _, _ in inner.headlines(folder)] == [
        "The default against the fastest library",
        "Combinations of direction, line search and family that reach 1e-6",
    ]


def test_pages_without_rows_say_so(tmp_path):
    for module in (inner, convergence):
        assert "Not measured yet" in module.page(tmp_path / "none", tmp_path).read_text()
        assert module.headlines(tmp_path / "none") == []


def test_the_page_of_convergence_shows_curves_and_failures(tmp_path):
    rows = Rows(tmp_path, "convergence", KEYS)
    for method, steps in (("newton", 3), ("gradient", 40)):
        for step in (steps, 1, 0):
            rows.add(
                part="zone", name="random-64", method=method, line_search="exact",
                update="every-step", step=step, outcome="converged", message=None,
                excess=-(10.0**-step), violation=10.0**-step, steps=steps, seconds=0.1,
                error=1e-9, gap=1e-9,
            )  # fmt: skip
    rows.add(
        part="zone", name="random-64", method="cg", line_search="wolfe", update="every-step",
        step=0, outcome="failed", message="ValueError: no",
    )  # fmt: skip
    for step, found in ((1, 0), (0, 7)):
        rows.add(
            part="step", name="demo", method="auto", line_search="-", update="-", step=step,
            outcome="converged", message="FREE", round=0, objective=1e-6, found=found,
            added=found, impacts=7, zones=2, seconds=1.0,
        )  # fmt: skip
    text = convergence.page(tmp_path, tmp_path / "pages").read_text()
    assert text.count("<svg") == 2
    assert "ValueError: no" in text
    ((_, figure, sentence),) = convergence.headlines(tmp_path)
    assert figure == "3"
    assert sentence.startswith("newton with exact line search")


def _family(name, size):
    """Return a measured family of a given size, without rows."""
    family = Family(name)
    family.size = size
    return family


def test_targets_and_durations_are_formatted():
    assert target(_family("random-256", 256)) == (0.5, None)
    assert target(_family("random-4096", 4096)) is None
    assert target(_family("armadillo-last", 43036)) == (0.5, "PIQP")
    said = [duration(seconds) for seconds in (2.0, 0.9999, 0.02, 3.21e-6, None)]
    assert said == ["2 s", "1 s", "20 ms", "3.21 µs", ""]

"""The pages of the report: all are written, none is broken, and figures come from rows."""

import math
import re
import subprocess
import sys

import pytest

from tests.helpers.pages import check_page, look, needs_browser
from validation.__main__ import main
from validation.provenance import ROOT
from validation.report import outer as outer_page
from validation.report import scaling as scaling_page
from validation.report import start
from validation.rows import OUTCOMES, Rows, begin_run, read
from validation.study import outer, scaling, steps

WIDTHS = "[document.documentElement.scrollWidth, window.innerWidth]"


def sizes_rows(folder):
    """Write rows of steps whose time grows with n, and of zones whose time grows with n^1.5."""
    rows = Rows(folder, "scaling", scaling.KEYS)
    for size in (1_000, 10_000, 100_000, 1_000_000):
        stages = {f"{name}_s": size * 1e-6 for name in ("total", "detect", "certify", "door")}
        memory = {"import_mib": 100.0, "warm_mib": 150.0, "peak_mib": 150.0 + 3e-3 * size}
        counts = {"triangles": size, "impacts": size // 100, "solve_s": 1e-9 * size**1.5}
        rows.add(family="sheets", size=size, outcome="converged", **counts, **stages, **memory)
        time = 1e-6 * size**1.5
        rows.add(
            **{"family": "chain", "size": size, "impacts": size, "outcome": "converged"},
            **{"method": "active-set", "solve_s": time, "total_s": time},
            **memory,
        )
    rows.add(family="random", size=4096, outcome="failed", message="the process died")


def steps_rows(folder):
    """Write rows of a step with a peer, one without, one that is blocked and one that failed."""
    rows = Rows(folder, "outer", outer.KEYS)
    for name, factor in (("sheets", 1.0), ("cloth <b>", 3.0)):
        for setting in outer.settings(quick=False):
            worse = 1.0 + 0.01 * (5 - setting.relinearize) + 1e3 * setting.thickness
            rows.add(
                step=name,
                **setting._asdict(),
                **{"triangles": 10, "outcome": "converged", "message": "FREE", "wall_s": 2.0},
                **{"objective": factor * worse, "cpu_s": factor * (1.0 + setting.relinearize)},
            )
    peer = {"outcome": "converged", "message": "recorded elsewhere", "objective": 2.2, "cpu_s": 8.0}
    rows.add(**outer._peer_key("sheets"), **peer, triangles=10)
    blocked = {"outcome": "not converged", "message": "BLOCKED", "objective": 1e-9, "cpu_s": 0.1}
    rows.add(step="pinch", **outer.DEFAULT._asdict(), **blocked, triangles=10)
    failed = {"outcome": "failed", "message": "InitialIntersectionError: no <start>"}
    rows.add(step="bad", **outer.DEFAULT._asdict(), **failed)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Write a report of made-up rows, once for all tests, and return its folder."""
    folder = tmp_path_factory.mktemp("report")
    begin_run(folder / "rows", "python -m validation report", False)
    sizes_rows(folder / "rows")
    steps_rows(folder / "rows")
    (folder / "zones.md").write_text("# Zones\n")
    assert main(["report", "--pages-only", "-o", str(folder)]) == 0
    return folder


def test_every_page_is_written_and_none_is_broken(report):
    pages = {path.stem: check_page(path) for path in report.glob("*.html")}
    assert set(pages) == {"index", *start.STUDIES}
    for name in ("outer", "scaling"):
        assert len(pages[name].figures) == 2
    links = re.findall(r'href="([^"#]+)"', pages["index"].source)
    assert "zones.md" in links
    for link in links:
        assert link == "data:," or (report / link).is_file(), link


def test_the_start_page_has_five_figures_and_says_what_is_missing(report):
    text = check_page(report / "index.html").text
    assert (report / "index.html").read_text().count('class="value"') == 5
    assert text.count("Not measured yet.") == 2  # of the two pages without rows here
    assert "Not in this folder; python -m validation evidence --pages-only makes" in text
    assert "A step of 1,000,000 triangles" in text
    assert "1 s" in text


def test_a_report_without_rows_says_so(tmp_path):
    assert main(["report", "--quick", "--pages-only", "-o", str(tmp_path)]) == 0
    for name in ("index", *start.STUDIES):
        assert "Not measured yet." in check_page(tmp_path / f"{name}.html").text


@needs_browser
@pytest.mark.parametrize("name", ["index", *start.STUDIES])
def test_pages_load_and_fit_a_phone(report, tmp_path, name):
    (needed, given), console = look(report / f"{name}.html", tmp_path, WIDTHS)
    assert console == []
    assert given == 390
    assert needed <= 390


def test_exponents_are_those_of_the_rows(report):
    sheets = scaling_page.sheet_rows(read(report / "rows", "scaling"))
    slope, said = scaling_page.exponent(sheets, "triangles", "total_s")
    assert math.isclose(slope, 1.0, rel_tol=1e-9)
    assert said == "over 100,000 to 1,000,000"
    slope, _ = scaling_page.exponent(sheets, "triangles", "solve_s")
    assert math.isclose(slope, 1.5, rel_tol=1e-9)
    assert scaling_page.exponent(sheets[:1], "triangles", "total_s") is None
    assert "random 4096 (the process died)" in check_page(report / "scaling.html").text


def test_objectives_are_compared_within_step_and_thickness(report):
    rows = outer_page.compared(read(report / "rows", "outer"))
    default = {row["step"]: row for row in rows if outer_page.setting(row) == outer.DEFAULT}
    assert default["sheets"]["excess"] == 0.0
    assert default["pinch"]["excess"] is None, "lower, but not free"
    (loose,) = [
        row
        for row in rows
        if row["step"] == "sheets"
        and outer_page.setting(row) == outer.DEFAULT._replace(relinearize=0)
    ]
    assert math.isclose(loose["excess"], 0.05 / 1.1)
    thick = outer.DEFAULT._replace(thickness=3e-4)
    assert all(row["excess"] == 0.0 for row in rows if outer_page.setting(row) == thick)
    ((own, peer),) = outer_page.peer_pairs(rows)
    assert math.isclose(own["objective"] / peer["objective"], 0.5)
    (headline, resolved) = outer_page.headlines(report / "rows")
    assert headline[1] == "0.500"
    assert resolved[1] == "2 of 3"


def test_a_step_study_writes_every_row_and_resumes(tmp_path, monkeypatch):
    monkeypatch.setattr(steps, "available", lambda: False)
    monkeypatch.setattr(steps, "peers", lambda: {})
    name = "generated: two tetrahedra"
    monkeypatch.setattr(outer, "GENERATED", {name: outer.GENERATED[name]})
    monkeypatch.setattr(outer, "_warm_up", lambda: None)
    for limit in ("LONG_S", "QUICK_LIMIT_S"):
        monkeypatch.setattr(outer, limit, math.inf)  # the first step may have to compile
    said = []
    outer.run(tmp_path, True, said.append)
    rows = read(tmp_path, "outer")
    assert len(rows) == len(outer.settings(quick=True)) == 9
    assert {row["outcome"] for row in rows} == {"converged"}
    assert all(row["cpu_s"] > 0.0 and row["objective"] > 0.0 for row in rows)
    outer.run(tmp_path, True, said.append)
    assert len(said) == 1
    assert len(read(tmp_path, "outer")) == 9


def test_a_step_that_takes_too_long_or_is_refused_leaves_a_row(tmp_path, monkeypatch):
    monkeypatch.setattr(steps, "available", lambda: False)
    monkeypatch.setattr(steps, "peers", lambda: {})
    monkeypatch.setattr(outer, "_warm_up", lambda: None)
    monkeypatch.setattr(outer, "QUICK_LIMIT_S", -1.0)
    crossing = {"generated: crossing": crossing_scene}
    slow = {name: outer.GENERATED[name] for name in ("generated: edge on edge",)}
    monkeypatch.setattr(outer, "GENERATED", slow | crossing)
    outer.run(tmp_path, True, str)
    rows = read(tmp_path, "outer")
    found = {row["step"]: row for row in rows if outer_page.setting(row) == outer.DEFAULT}
    assert found["generated: edge on edge"]["message"].startswith("stopped after")
    assert found["generated: edge on edge"]["outcome"] == "not converged"
    assert found["generated: crossing"]["outcome"] == "failed"
    assert "InitialIntersectionError" in found["generated: crossing"]["message"]
    assert outer_page.page(tmp_path, tmp_path).is_file()


def crossing_scene():
    """Make a scene that intersects at its start, which raises an error."""
    from izo_ref import Scene

    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [2, 2, 1]]
    return Scene(points, points, [[0, 1, 2], [3, 4, 5]])


def test_a_long_step_is_run_with_each_selection_only(tmp_path, monkeypatch):
    rows = Rows(tmp_path, "outer", outer.KEYS)
    monkeypatch.setattr(outer, "_scene", lambda name: crossing_free)
    monkeypatch.setattr(
        outer, "_measured", lambda *args: {"outcome": "converged", "cpu_s": 2 * outer.LONG_S}
    )
    crossing_free = type("Scene", (), {"faces": [0]})
    assert outer._add_step(rows, "long", outer.settings(quick=False), quick=False) == 3
    found = [outer_page.setting(row) for row in rows.all()]
    assert found == [outer.DEFAULT._replace(selection=s) for s in outer.SELECTIONS]


def test_sizes_are_measured_in_a_process_and_resumed(tmp_path, monkeypatch):
    monkeypatch.setattr(scaling, "QUICK", {"chain": (1, 8)})
    said = []
    scaling.run(tmp_path, True, said.append)
    rows = read(tmp_path, "scaling")
    assert [(row["size"], row["outcome"]) for row in rows] == [(1, "converged"), (8, "converged")]
    for row in rows:
        assert 10.0 < row["import_mib"] <= row["warm_mib"] <= row["peak_mib"] < 4000.0
        assert row["gap"] <= 1e-9
    scaling.run(tmp_path, True, said.append)
    assert len(said) == 2


@pytest.mark.parametrize(
    ("family", "limit", "message"),
    [("no such family", 60.0, "the process died"), ("chain", 1e-3, "stopped at 1 after 0.001 s")],
)
def test_a_process_that_dies_or_hangs_leaves_failures(family, limit, message, monkeypatch, capfd):
    monkeypatch.setattr(scaling, "COMPILE_LIMIT_S", limit)
    rows = list(scaling.measured(family, (1, 2), limit))
    assert [row["size"] for row in rows] == [1, 2]
    assert {row["outcome"] for row in rows} == {"failed"} <= set(OUTCOMES)
    assert {row["message"] for row in rows} == {message}


def test_the_log_keeps_what_a_run_said_and_how_long_it_took(tmp_path, monkeypatch):
    monkeypatch.setattr(scaling, "run", lambda folder, quick, say: say("a size is measured"))
    lines = []
    for _ in range(2):
        start.write_report(tmp_path, "the command", True, "scaling", False, lines.append)
    kept = (tmp_path / "rows" / start.LOG).read_text().splitlines()
    assert kept == lines
    assert kept[:2] == ["run 1: the command", "a size is measured"]
    assert re.fullmatch(r"scaling: done in \d+ s", kept[2])


def test_the_peak_of_memory_is_seen():
    """A new process measures it, because the peak of this one may be far above by now."""
    code = (
        "from validation.study.growth import peak_mib; before = peak_mib();"
        "block = bytearray(64 * 2**20); block[::4096] = b'x' * len(block[::4096]);"
        "print(peak_mib() - before)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert 40.0 < float(run.stdout) < 80.0

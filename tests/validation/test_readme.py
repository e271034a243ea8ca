"""`reports/README.md` shows the figures of the committed rows, and pages are made from them."""

import shutil

import pytest

from validation.__main__ import main
from validation.report import catalogue, mutants, readme

# Pages that a report makes are committed only if they are named here.
COMMITTED = (
    "README.md",
    "evidence/README.md",
    "speed/README.md",
    "cuda/README.md",
    "sequences/README.md",
)


def test_the_figures_are_those_of_the_rows():
    text = readme.README.read_text()
    assert text == readme.with_figures(text), "run: python -m validation readme"


def test_every_report_has_figures_and_names_its_commits():
    for report in catalogue.REPORTS:
        folder = report.rows_folder(readme.FOLDER)
        assert report.module.headlines(folder), report.name
        assert catalogue.commits(report, readme.FOLDER), report.name
        assert report.module.headlines(folder / "nowhere") == [], report.name


def test_other_rows_give_other_figures(tmp_path):
    """The first test can fail."""
    shutil.copytree(readme.FOLDER, tmp_path / "reports", ignore=shutil.ignore_patterns("rows"))
    text = readme.with_figures(readme.README.read_text(), tmp_path / "reports")
    assert text != readme.README.read_text()
    (headline,) = mutants.headlines(readme.FOLDER)  # their file was copied
    assert f"| {headline.figure} | {headline.label}" in text
    assert "Not measured yet." in text


@pytest.mark.parametrize("report", catalogue.OTHERS, ids=lambda report: report.name)
def test_a_page_is_made_from_its_rows_alone(report, tmp_path):
    """The pages that are committed do not change, to the last byte."""
    folder = report.rows_folder(readme.FOLDER)
    page = report.module.page(folder, tmp_path)
    assert page.read_text().startswith("# ")
    if report.page in COMMITTED:
        expected = (readme.FOLDER / report.page).read_text()
        assert page.read_text() == expected, f"run: {report.pages_command}"


def test_the_command_writes_pages_without_step_files(tmp_path, monkeypatch):
    monkeypatch.setattr("validation.study.steps.available", lambda: False)
    shutil.copytree(readme.FOLDER, tmp_path / "reports")
    for report in catalogue.OTHERS:
        page = tmp_path / "reports" / report.page
        page.unlink(missing_ok=True)
        words = report.pages_command.removeprefix(catalogue.PROGRAM).split()
        assert main([*words, "-o", str(tmp_path / "reports")]) == 0
        assert page.read_text().startswith("# "), report.name
    assert (tmp_path / "reports" / "evidence" / "wrong.md").is_file()

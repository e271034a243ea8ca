"""The report as a whole: run the studies, write every page and the start page."""

import html
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TextIO

from validation import rows
from validation.report import catalogue, site
from validation.report.catalogue import Headline
from validation.rows import Columns

STUDIES = {report.name: report for report in catalogue.STUDIES}
HEADLINES = 5
# Beside the rows: the lines of progress of the runs, and how long each study took.
LOG = "report.log"


def write_report(
    output: Path,
    command: str,
    quick: bool,
    only: str | None,
    pages_only: bool,
    say: Callable[[str], None],
) -> Path:
    """Run the studies for the rows that are missing, and write the pages.

    Args:
        output: Folder of the pages; the rows are in `rows/` there.
        command: Command that the rows and the pages name.
        quick: Measure fewer and smaller cases.
        only: The name of one of STUDIES; None means all of them.
        pages_only: Measure nothing.
        say: Called with each line of progress.

    Returns:
        Path of the start page.
    """
    import_module("matplotlib")  # if it is missing, this fails before anything is measured
    folder = output / "rows"
    wanted = [only] if only else list(STUDIES)
    if not pages_only:
        _measure(folder, wanted, command, quick, say)
    for name, report in STUDIES.items():
        if name in wanted or not (output / report.page).is_file():
            report.module.page(folder, output)
    _start_page(folder, output)
    return output / "index.html"


def _measure(
    folder: Path, names: list[str], command: str, quick: bool, say: Callable[[str], None]
) -> None:
    """Run studies; what they say is also written to the log."""
    run = rows.begin_run(folder, command, quick)
    with (folder / LOG).open("a") as log:
        say_and_log = _logging(say, log)
        say_and_log(f"run {run}: {command}")
        for name in names:
            begin = time.perf_counter()
            import_module(f"validation.study.{name}").run(folder, quick, say_and_log)
            say_and_log(f"{name}: done in {time.perf_counter() - begin:.0f} s")


def _logging(say: Callable[[str], None], log: TextIO) -> Callable[[str], None]:
    """Return a function that says a line and writes it to a file."""

    def say_and_log(line: str) -> None:
        say(line)
        print(line, file=log, flush=True)

    return say_and_log


def _start_page(folder: Path, output: Path) -> None:
    known = rows.runs(folder)
    sections = [
        ("Five figures", _tiles(folder)),
        ("Pages", _study_links()),
        ("Other reports", _other_links(output)),
        ("Runs", _runs(folder) + site.paragraph(f"The log of the runs is in rows/{LOG}.")),
    ]
    limits = [
        "The figures are taken from the pages, which also state their limits.",
        "Times were measured on the machine that is named; other work may have run on it.",
    ]
    if any(run["quick"] for run in known):
        limits.append("This is a quick report: its few and small cases only show that it works.")
    site.write_page(
        output / "index.html",
        "Error against run time",
        "How close izo_ref comes to the optimum, and how long it takes: for one zone, for a whole "
        "step, by iteration and by size.",
        sections,
        limits,
        known,
    )


def _study_links() -> str:
    items = (
        f'<li><a href="{report.page}">{site.PAGES[name]}</a>: {html.escape(report.question)}</li>'
        for name, report in STUDIES.items()
    )
    return "<ul>" + "\n".join(items) + "</ul>"


def _other_links(output: Path) -> str:
    """Return links to the reports that other commands make; a page that is missing has no link."""
    items = []
    for report in catalogue.OTHERS:
        question, page = html.escape(report.question), report.page
        if (output / page).is_file():
            items.append(f'<li><a href="{page}">{report.title}</a>: {question}</li>')
        else:
            made = f"<code>{report.pages_command}</code> makes {page}"
            items.append(f"<li>{report.title}: {question} Not in this folder; {made}.</li>")
    return "<ul>" + "\n".join(items) + "</ul>"


def _tiles(folder: Path) -> str:
    """Return five headlines: the first one of each page, then second ones."""
    first: list[tuple[str, Headline]] = []
    later: list[tuple[str, Headline]] = []
    for name, report in STUDIES.items():
        found = report.module.headlines(folder)
        missing = Headline(site.PAGES[name], "–", "Not measured yet.")
        first.append((name, found[0] if found else missing))
        later += [(name, headline) for headline in found[1:]]
    tiles = first + later[: HEADLINES - len(first)]
    return '<div class="tiles">\n' + "\n".join(_tile(*tile) for tile in tiles) + "\n</div>"


def _tile(name: str, headline: Headline) -> str:
    return (
        f'<div><div class="label">{html.escape(headline.label)}</div>'
        f'<div class="value">{html.escape(headline.figure)}</div>'
        f'<p class="said">{html.escape(headline.sentence)} '
        f'<a href="{STUDIES[name].page}">{site.PAGES[name]}</a></p></div>'
    )


def _runs(folder: Path) -> str:
    known = rows.runs(folder)
    columns: Columns = {
        name: name for name in ("run", "command", "commit", "quick", "started", "machine")
    }
    caption = "The runs that measured the rows"
    return site.data_table(columns, known, caption) if known else site.NOT_MEASURED

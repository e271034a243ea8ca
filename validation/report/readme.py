"""The figures in `reports/README.md`, computed from the committed rows."""

from pathlib import Path

from validation.provenance import ROOT
from validation.report.catalogue import REPORTS, commits
from validation.report.tables import NOT_MEASURED, table
from validation.rows import Columns, Row

FOLDER = ROOT / "reports"
README = FOLDER / "README.md"
BEGIN, END = "<!-- figures:begin -->", "<!-- figures:end -->"


def figures(reports: Path = FOLDER) -> str:
    """Return the headline figures of all reports, and the commands that make them, as Markdown.

    Args:
        reports: The folder of the reports.
    """
    lines: list[Row] = []
    commands: list[Row] = []
    for report in REPORTS:
        found = report.module.headlines(report.rows_folder(reports))
        for i, (label, figure, sentence) in enumerate(found):
            title = report.title if i == 0 else ""
            lines.append({"title": title, "figure": figure, "what": f"{label}. {sentence}"})
        commands.append(
            {
                "page": f"`{report.page}`",
                "commits": ", ".join(commits(report, reports)) if found else NOT_MEASURED,
                "command": f"`{report.command}`",
                "pages": f"`{report.pages_command}`",
            }
        )
    headline_columns: Columns = {"report": "title", "figure": "figure", "what it is": "what"}
    command_columns: Columns = {
        "page": "page",
        "measured at commit": "commits",
        "measure again": "command",
        "make the page from the rows": "pages",
    }
    return f"{table(headline_columns, lines)}\n{table(command_columns, commands)}"


def with_figures(text: str, reports: Path = FOLDER) -> str:
    """Return a text whose figures, between the two marks, are those of the rows.

    Args:
        text: The content of `reports/README.md`.
        reports: The folder of the reports.
    """
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{figures(reports)}{END}{after}"

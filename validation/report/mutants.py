"""Rows of `validation.mutants` to `reports/mutants.md`."""

from validation.report.tables import table, write


def mutants_report(path, title, rows):
    """Write the score, the survivors, and who caught what.

    Args:
        path: of the Markdown file; JSON is written beside it.
        title: `header` of the report.
        rows: of `run_mutants`.
    """
    survivors = [row for row in rows if not row["caught"]]
    by_whole = sum(row["caught"] and row["whole"] for row in rows)
    columns = {
        "fault": "name",
        "file": "file",
        "what is wrong": "what",
        "where it was found before": "origin",
        "caught": "caught",
        "by": "by",
        "seconds": lambda row: f"{row['seconds']:.0f}",
    }
    missed = "None." if not survivors else table(columns, survivors)
    content = f"""{title}
Deliberate faults, one at a time, each in a copy of the repository. The tests named for a fault
run first, all others only if those pass. Without any fault they pass.

**{len(rows) - len(survivors)} of {len(rows)} caught**, {by_whole} of them only by the whole suite.

## Survivors

{missed}

## All

{table(columns, rows)}"""
    write(path, content, rows)

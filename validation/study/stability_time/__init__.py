"""Study of what makes a step slow for its size.

A search changes recipes of steps at random and keeps what takes longest (`slow_search.py`). The
slowest recipe of each kind is then made smaller and larger, up to 8 times, which says whether its
time grows faster than n log n, and why (`cells.py`). Each step runs in a process of its own and
with a time limit, so a step that would take hours is a row, too. Start reading with `rows`.
"""

from pathlib import Path

from validation.study.parts import Say
from validation.study.stability_time.cells import judge_cells, measure_growth
from validation.study.stability_time.slow_search import search


def rows(folder: Path, say: Say) -> None:
    """Add the rows that are missing to `time-search.csv`, `time-growth.csv` and `time-cells.csv`.

    Args:
        folder: Folder of the CSV files.
        say: Is called with a line of text as the work goes on.
    """
    search(folder, say)
    measure_growth(folder, say)
    judge_cells(folder, say)

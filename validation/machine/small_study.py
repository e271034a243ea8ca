"""A study of a few seconds with the means of the real ones: rows, rows in JSON, a log, a page.

python -m validation.machine.small_study FOLDER
"""

import sys
import time
from pathlib import Path

import numpy as np

from izo_ref.app.files import replacing
from izo_ref.app.process import run_and_exit
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem
from validation import json_rows
from validation.provenance import Made
from validation.rows import Rows, begin_run

KEYS = ("zone", "part")
ZONES, PARTS = 12, 3
PAUSE_S = 0.02  # as if a row took longer to measure


def main() -> int:
    """Measure the rows that are missing, and write the page."""
    folder = Path(sys.argv[1])
    begin_run(folder, "small study", True)
    table = Rows(folder, "small", KEYS)
    for zone in range(ZONES):
        for part in range(PARTS):
            if not table.has(zone=zone, part=part):
                # a column of its own in later parts, for which the file is written again
                table.add(zone=zone, part=part, **_measured(zone, part))
    every = table.all()
    kept = [[row["zone"], row["part"], row["objective"]] for row in every]
    json_rows.save(folder / "small.json", Made("small study", "", "", ""), kept)
    with replacing(folder / "small.md") as file:  # as pages are written
        file.write(f"# Small\n\n{len(every)} rows\n".encode())
    return 0


def _measured(zone: int, part: int) -> dict[str, float]:
    begin = time.perf_counter()
    time.sleep(PAUSE_S)
    proposed = np.random.default_rng([zone, part]).normal(size=(4, 3))
    problem = ZoneProblem(
        np.arange(4, dtype=np.int32)[None],
        np.array([[0.5, 0.5, -0.5, -0.5]]),
        np.array([[0.0, 0.0, 1.0]]),
        proposed,
        np.ones(4),
        1e-3,
    )
    answer = solve_zone(problem)
    row = {"objective": float(np.sum((answer.positions - proposed) ** 2))}
    if part:
        row["largest"] = float(np.abs(answer.positions).max())
    return row | {"seconds": time.perf_counter() - begin}


if __name__ == "__main__":
    run_and_exit(main, "small_study")

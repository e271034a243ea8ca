"""Sections of the page of stability that are no ladders: random steps, bad input, time, kills."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from validation.report.tables import NOT_MEASURED, section, table
from validation.rows import Columns, Row, read

NAMES = ("random-steps", "fuzz", "time-cells", "kills")
STATUSES = ("FREE", "FREE_BY_FALLBACK", "FREE_EXCEPT_EXCLUDED", "BLOCKED")
COUNTS = (
    *("cases", "steps", *STATUSES, "refused", "slow", "crashed"),
    *("by_oracle", "by_fcl", "exact_zones", "again", "violations"),
)
PROBLEMS = (
    *("crash", "hang", "silent_acceptance", "refusal_of_valid_input"),
    "message_without_the_offender",
)
STEPS: Columns = {
    "kind": "kind",
    "steps": "steps",
    **{name: name for name in STATUSES},
    "refused": "refused",
    "too slow": "slow",
    "crashed": "crashed",
    "judged by the second exact oracle": "by_oracle",
    "ends judged by python-fcl": "by_fcl",
    "zones with their exact optimum": "exact_zones",
    "resolved again": "again",
    "false claims": "violations",
}
STEPS_INTRO = (
    "Small steps of 1 to 200 faces are drawn by family and by kind of trouble, and every claim of "
    "a result is judged: that all numbers are finite, that the path is free, that zones are "
    "solved, that pinned and untouched vertices are where they have to be. A second exact oracle "
    "judges a sample pair by pair."
)
INPUT: Columns = {
    "input": "family",
    "inputs": "inputs",
    "accepted": "accepted",
    "refused": "refused",
    **{name.replace("_", " "): name for name in PROBLEMS},
    "slowest [s]": "slowest_s",
}
INPUT_INTRO = (
    "Arrays, options and files are damaged at random. An input is accepted or refused by a "
    "contract that was written without the code. A warning counts as a crash, 5 s as a hang, and "
    "a refusal has to name the offender."
)
TIME: Columns = {
    "step": "cell",
    "verdict": "verdict",
    "exponent": "exponent",
    "its spread": "exponent_spread",
    "exponent of n log n": "exponent_of_nlogn",
    "where the time goes": "cause",
}
TIME_INTRO = (
    "A search changes recipes of steps at random and keeps what takes longest for its size. The "
    "slowest of each kind is then made larger, which tells how its time grows."
)
KILLS_INTRO = (
    "Commands were killed at random moments: by SIGKILL, SIGINT and SIGTERM, half of them by the "
    "clock and half at a call that changes a file. An output has to be whole, or as it was before."
)


def sections(rows_folder: Path) -> list[str]:
    """Return the sections of everything that is no ladder; Markdown."""
    return [
        _random_steps(read(rows_folder, "random-steps")),
        section("Bad input", INPUT_INTRO, INPUT, _with_sum(read(rows_folder, "fuzz"))),
        section("What makes a step slow", TIME_INTRO, TIME, read(rows_folder, "time-cells")),
        _kills(read(rows_folder, "kills")),
    ]


def other_rows(rows_folder: Path) -> list[Row]:
    """Return the rows of all of them that this folder has."""
    return [row for name in NAMES for row in read(rows_folder, name)]


def random_steps_total(rows_folder: Path) -> dict[str, int]:
    """Return the counts of all random steps; zeros if none were measured."""
    return _total(read(rows_folder, "random-steps"), COUNTS)


def _random_steps(rows: Sequence[Row]) -> str:
    if not rows:
        return f"## Random steps\n\n{NOT_MEASURED}"
    kinds = dict.fromkeys(row["kind"] for row in rows)
    lines: list[Row] = [
        {"kind": kind} | _total([row for row in rows if row["kind"] == kind], COUNTS)
        for kind in kinds
    ]
    lines.append({"kind": "all"} | _total(rows, COUNTS))
    seeds = sorted({row["seed"] for row in rows})
    families = len({row["family"] for row in rows})
    said = f"{STEPS_INTRO} {families} families; seeds {seeds[0]} to {seeds[-1]}."
    return f"## Random steps\n\n{said}\n\n{table(STEPS, lines)}"


def _total(rows: Iterable[Row], names: Sequence[str]) -> dict[str, int]:
    found = list(rows)
    return {name: sum(row.get(name) or 0 for row in found) for name in names}


def _with_sum(rows: list[Row]) -> list[Row]:
    if not rows:
        return rows
    last: Row = {"family": "all", "slowest_s": max(row["slowest_s"] for row in rows)}
    return [*rows, last | _total(rows, ("inputs", "accepted", "refused", *PROBLEMS))]


def _kills(rows: Sequence[Row]) -> str:
    if not rows:
        return f"## Killed commands\n\n{NOT_MEASURED}"
    lines: list[Row] = []
    for command in dict.fromkeys(row["command"] for row in rows):
        own = [row for row in rows if row["command"] == command]
        lines.append({"command": command} | _kill_counts(own))
    lines.append({"command": "all"} | _kill_counts(rows))
    columns: Columns = {name: name for name in lines[0]}
    return f"## Killed commands\n\n{KILLS_INTRO}\n\n{table(columns, lines)}"


def _kill_counts(rows: Sequence[Row]) -> dict[str, int]:
    return {
        "moments": len(rows),
        "killed": sum(row["ended"] == "killed" for row in rows),
        "outputs half written": sum(row["half"] for row in rows),
        "unfinished files left": sum(row["left"] for row in rows),
        "of them after the next write": sum(row["left_after_next"] for row in rows),
        "inputs changed": sum(not row["step_same"] for row in rows),
        "studies that did not resume": sum(row["resumes"] is False for row in rows),
    }

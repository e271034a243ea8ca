"""The pages of the evidence, from the rows of `study/evidence.py`: one a step, and a summary."""

from collections.abc import Callable
from pathlib import Path

from validation import json_rows
from validation.report.catalogue import Headline
from validation.report.tables import NOT_MEASURED, cell_text, header, table, write_page
from validation.rows import Columns, Row

WRONG = "wrong"  # stem of the file of the results that are deliberately wrong
MARKS = {True: "passed", False: "FAILED", None: ""}
ANSWERS = {True: "free", False: "**not free**", None: "not judged"}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `README.md`, a page of each step, and `wrong.md`.

    Args:
        rows_folder: Folder of the JSON files: one a step, and `wrong.json`.
        output: Folder of the pages.

    Returns:
        Path of `README.md`.
    """
    path, loaded = output / "README.md", _loaded(rows_folder)
    if not loaded:
        return write_page(path, ("# Evidence", NOT_MEASURED))
    for stem, (made, rows) in loaded.items():
        if stem == WRONG:
            title = header("Evidence: results that are deliberately wrong", [made])
            sections = [section for row in rows for section in _wrong_result(row)]
        else:
            title, sections = header(f"Evidence: {stem}", [made]), _step(rows[0])
        write_page(output / f"{stem}.md", (title, *sections))
    made = [part.made for part in loaded.values()]
    return write_page(path, (header("Evidence", made), *_summary(*_rows(loaded))))


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    steps, wrong = _rows(_loaded(rows_folder))
    judged = [row for row in steps if "refused" not in row]
    if not judged:
        return []
    return [
        Headline(
            "Steps whose result passes every judge",
            f"{sum(row['verdict']['passed'] for row in judged)} of {len(judged)}",
            "The judges are izo_ref's certificate, ipctk, python-fcl and exact arithmetic. "
            f"{' '.join(_exceptions(steps))}".strip(),
        ),
        Headline(
            "Deliberately wrong results that the check finds",
            f"{sum(not row['verdict']['passed'] for row in wrong)} of {len(wrong)}",
            "One of them swaps two layers and is free of contact at both ends.",
        ),
    ]


def _exceptions(steps: list[Row]) -> list[str]:
    """Return a sentence for each reason why a step does not pass."""
    names: dict[str, list[str]] = {}
    for row in steps:
        if "refused" in row:
            names.setdefault("Refused as input", []).append(row["step"])
        elif row["status"] == "BLOCKED":
            names.setdefault("Blocked, as the result says itself", []).append(row["step"])
        elif not row["verdict"]["passed"]:
            names.setdefault("Failed", []).append(row["step"])
    return [f"{reason}: {', '.join(own)}." for reason, own in names.items()]


def _loaded(folder: Path) -> dict[str, json_rows.MadeRows]:
    """Return the files of the folder by their stems, sorted."""
    found = {path.stem: json_rows.load(path) for path in sorted(folder.glob("*.json"))}
    return {stem: loaded for stem, loaded in found.items() if loaded is not None}


def _rows(loaded: dict[str, json_rows.MadeRows]) -> tuple[list[Row], list[Row]]:
    """Return the rows of the steps, each with its commit, and those of the wrong results."""
    steps = [
        row | {"commit": part.made.commit}
        for stem, part in loaded.items()
        if stem != WRONG
        for row in part.rows
    ]
    return steps, loaded[WRONG].rows if WRONG in loaded else []


def _facts(row: Row) -> str:
    columns: Columns = {
        "": lambda fact: MARKS[fact["passed"]],
        "question": "question",
        "asked": "by",
        "answer": "answer",
        "seconds": lambda fact: f"{fact['seconds']:.2f}",
    }
    return table(columns, row["verdict"]["facts"])


def _step(row: Row) -> tuple[str, ...]:
    if "refused" in row:
        return (f"The step is refused as input, as it has to be: {row['refused']}",)
    return f"**{'passed' if row['verdict']['passed'] else 'failed'}**", _facts(row)


def _wrong_result(row: Row) -> tuple[str, str]:
    return f"## {cell_text(row['result'])}", _facts(row)


def _answer(by: str, question: str) -> Callable[[Row], str]:
    """Return a function that says, in a word or two, how a judge answered a question."""

    def find(row: Row) -> str:
        for fact in row["verdict"]["facts"]:
            if fact["by"].startswith(by) and fact["question"] == question:
                return ANSWERS[fact["passed"]]
        return ""

    return find


JUDGES: Columns = {
    "path: izo_ref": _answer("izo_ref.certify_path", "path is free"),
    "path: ipctk and flint": _answer("ipctk Tight", "path is free"),
    "end: python-fcl": _answer("python-fcl", "end is free"),
    "end: ipctk": _answer("ipctk", "end is free"),
}


def _check(row: Row) -> str:
    if row["verdict"]["passed"]:
        return "passed"
    return "failed, as the result says" if row["status"] == "BLOCKED" else "**failed**"


def _check_of_wrong(row: Row) -> str:
    return "**passed**" if row["verdict"]["passed"] else "failed, rightly"


def _peer_ratio(row: Row) -> str | None:
    peer = row.get("peer_objective_m2")
    return None if peer is None else f"{row['objective_m2'] / peer:.4f}"


def _summary(steps: list[Row], wrong: list[Row]) -> list[str]:
    judged = [row for row in steps if "refused" not in row]
    answers: Columns = {
        "step": "step",
        "triangles": "triangles",
        "status": "status",
        **JUDGES,
        "check": _check,
        "objective over ARCSim 0.2.1": _peer_ratio,
    }
    if len({row["commit"] for row in judged}) > 1:
        answers["measured at commit"] = "commit"
    cost: Columns = {
        "step": "step",
        "candidate pairs": "candidates",
        "decided exactly": "exact",
        "resolving [s]": "resolve_s",
        "certifying [s]": "certify_s",
        "candidate pairs of the proposed path": "proposal_candidates",
        "that meet": "proposal_meeting",
        "decided exactly there": "proposal_exact",
        "in 10,000": lambda row: 1e4 * row["proposal_exact"] / max(row["proposal_candidates"], 1),
        "certifying it [s]": "proposal_certify_s",
    }
    wrong_columns: Columns = {"result": "result", **JUDGES, "check": _check_of_wrong}
    refused = [f"{row['step']} ({row['refused']})" for row in steps if "refused" in row]
    return [
        "`python -m validation check` was run on every step file, with a thickness of 1e-4 m. Four "
        "judges say whether the result of `izo_ref.resolve` is free of contact; residuals and "
        "oracles say whether its zones are optimal. `python -m validation evidence --pages-only` "
        "writes a page of each step into this folder.",
        table(answers, judged),
        *(f"Refused as input: {step}" for step in refused),
        "## What the certificate costs",
        "Floating-point bounds prove most candidate pairs apart, or prove that they meet. All "
        "other pairs are decided in exact arithmetic. The table counts them on the paths to the "
        "results and on the paths to the proposed positions; the proposed paths have pairs that "
        "meet exactly on an edge or at a vertex.",
        table(cost, judged),
        "## Results that are wrong",
        table(wrong_columns, wrong),
    ]

"""Rows of `study.evidence` to `reports/evidence/`: a file a step, and a summary."""

from validation.report.tables import header, table, text, write


def evidence_report(folder, command, rows, wrong):
    """Write `README.md`, and a Markdown and a JSON file for each step.

    Args:
        folder: a `Path`.
        command: that made it.
        rows: of `step_row`.
        wrong: of `wrong_rows`.
    """
    for row in rows:
        write(folder / f"{row['step']}.md", _step(row, command), row)
    write(folder / "README.md", "\n".join((header("Evidence", command), _summary(rows, wrong))))
    write(folder / "wrong.md", _wrong(wrong, command), wrong)


def _facts(verdict):
    columns = {
        "": lambda fact: {True: "passed", False: "FAILED", None: ""}[fact["passed"]],
        "question": "question",
        "asked": "by",
        "answer": "answer",
        "seconds": lambda fact: f"{fact['seconds']:.2f}",
    }
    return table(columns, verdict["facts"])


def _step(row, command):
    title = header(f"Evidence: {row['step']}", command)
    if "refused" in row:
        return f"{title}\nRefused as input, as it has to be: {row['refused']}\n"
    word = "passed" if row["verdict"]["passed"] else "failed"
    return f"{title}\n**{word}**\n\n{_facts(row['verdict'])}"


def _answer(by, question):
    """How one judge answered one question, in a word."""

    def find(row):
        for fact in row["verdict"]["facts"]:
            if fact["by"].startswith(by) and fact["question"] == question:
                return {True: "free", False: "**not free**", None: "told"}[fact["passed"]]
        return ""

    return find


JUDGES = {
    "path: izo_ref": _answer("izo_ref.certify_path", "path is free"),
    "path: ipctk and flint": _answer("ipctk Tight", "path is free"),
    "end: python-fcl": _answer("python-fcl", "end is free"),
    "end: ipctk": _answer("ipctk", "end is free"),
}


def _check(row):
    if row["verdict"]["passed"]:
        return "passed"
    return "failed, as the result says" if row["status"] == "BLOCKED" else "**failed**"


def _ratio(row):
    peer = row.get("peer_objective_m2")
    return None if peer is None else f"{row['objective_m2'] / peer:.4f}"


def _summary(rows, wrong):
    judged = [row for row in rows if "refused" not in row]
    refused = [row for row in rows if "refused" in row]
    columns = {
        "step": "step",
        "triangles": "triangles",
        "status": "status",
        **JUDGES,
        "check": _check,
        "objective over ARCSim 0.2.1": _ratio,
    }
    cost = {
        "step": "step",
        "candidate pairs": "candidates",
        "decided exactly": "exact",
        "resolving [s]": "resolve_s",
        "certifying [s]": "certify_s",
        "candidate pairs of the proposal": "proposal_candidates",
        "that meet": "proposal_meeting",
        "decided exactly there": "proposal_exact",
        "in 10,000": lambda row: 1e4 * row["proposal_exact"] / max(row["proposal_candidates"], 1),
        "certifying it [s]": "proposal_certify_s",
    }
    parts = [
        "`python -m validation check` on every step file, thickness 1e-4 m: whether what "
        "`izo_ref.resolve` returns is free, by four judges, and whether its zones are optimal, by "
        "residuals and oracles. Each step has a page of its own here.",
        "",
        table(columns, judged),
        *(f"Refused as input: {row['step']} ({row['refused']})\n" for row in refused),
        "## What the certificate costs",
        "",
        "Pairs that floats can prove neither apart nor to meet are decided in exact arithmetic: of "
        "the results, and of the proposals, where pairs that meet exactly on an edge or at a "
        "vertex are among them.",
        "",
        table(cost, judged),
        "## Results that are wrong",
        "",
        table(
            {
                "result": "result",
                **JUDGES,
                "check": lambda row: (
                    "**passed**" if row["verdict"]["passed"] else "failed, rightly"
                ),
            },
            wrong,
        ),
    ]
    return "\n".join(parts)


def _wrong(wrong, command):
    parts = [header("Evidence: results that are deliberately wrong", command)]
    for row in wrong:
        parts += [f"## {text(row['result'])}", "", _facts(row["verdict"])]
    return "\n".join(parts)

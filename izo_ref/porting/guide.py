"""Tables of the guide for porters, made from `stages.py`, so that the two cannot differ.

`docs/porting-stages.md` holds a pair of marks for each stage; what is between them comes from here.
"""

from __future__ import annotations

import re

from izo_ref.porting.stages import FLAG, FLOAT, INTEGER, STAGE, Field, Stage

KINDS = {FLOAT: "float", INTEGER: "integer", FLAG: "0 or 1"}
MARKS = re.compile(r"(<!-- (S\d+):begin -->\n).*?(<!-- \2:end -->)", re.DOTALL)


def with_tables(text: str) -> str:
    """Return the text of the guide with the tables of today between its marks."""
    return MARKS.sub(lambda marks: f"{marks[1]}{stage_table(STAGE[marks[2]])}{marks[3]}", text)


def stage_table(stage: Stage) -> str:
    """Return what goes into a stage and what comes out, in Markdown."""
    lines = [
        f"`{stage.formula}`",
        "",
        f"In the code: {{source}}`{stage.source}`. Method: {{doc}}`method/{stage.method}`. "
        f"Vectors: `izo vectors list --stage {stage.name}`.",
        "",
        "| | name | shape | kind | meaning |",
        "|---|---|---|---|---|",
        *(_row("in", field) for field in stage.inputs),
        *(_row("out", field) for field in stage.outputs),
    ]
    return "\n".join(lines) + "\n"


def shape_text(field: Field) -> str:
    """Return a shape as the guide writes it; a single value has none."""
    if not field.shape:
        return "one"
    return f"({', '.join(str(size) for size in field.shape)}{',' * (len(field.shape) == 1)})"


def _row(side: str, field: Field) -> str:
    kind = KINDS.get(field.kind, "text") + (f" [{field.unit}]" if field.unit else "")
    side += ", optional" if field.optional else ""
    return f"| {side} | `{field.name}` | {shape_text(field)} | {kind} | {field.what} |"

"""The JSON Schema of the vectors, made from the tables of stages and judges, so it cannot drift.

One schema describes all files: `flags.json` and the file of each stage.
"""

from __future__ import annotations

import json
from math import prod
from typing import Any

from izo_ref.porting import parameters
from izo_ref.porting.cases import DTYPES, GRADES, HEX, INVALID, VERDICTS
from izo_ref.porting.checks import ID
from izo_ref.porting.flags import FLAG, FLAGS, Flag
from izo_ref.porting.parameters import JUDGES, STATUS, STATUSES, Judge
from izo_ref.porting.stages import FLAG as BIT
from izo_ref.porting.stages import FLOAT, INTEGER, STAGES, TEXT, Field, Stage

DIALECT = "https://json-schema.org/draft/2020-12/schema"
ITEMS: dict[str, dict[str, Any]] = {
    FLOAT: {"$ref": "#/$defs/float"},
    INTEGER: {"type": "integer"},
    BIT: {"enum": [0, 1]},
    TEXT: {"type": "string"},
}


def schema_text() -> str:
    """Return the content of `schema.json`."""
    return json.dumps(schema(), indent=1) + "\n"


def schema() -> dict[str, Any]:
    """Return the schema of all files of the vectors."""
    files = [_when("flags", {}, "flags_file")]
    files += [_when("stage", {"const": stage.name}, f"{stage.name}_file") for stage in STAGES]
    defs = _common()
    for stage in STAGES:
        defs[f"{stage.name}_file"] = _file(
            {"stage": {"const": stage.name}}, "cases", f"{stage.name}_case"
        )
        defs[f"{stage.name}_case"] = _case(stage)
    return {
        "$schema": DIALECT,
        "title": "Vectors of izo_ref, version 1",
        "description": "A file of one stage, or flags.json. Arrays are flat, row by row; the "
        "letters of a shape stand for counts that are the same within a case.",
        "type": "object",
        "properties": {"stage": {"enum": [stage.name for stage in STAGES]}},
        "anyOf": [{"required": ["stage"]}, {"required": ["flags"]}],
        "allOf": files,
        "$defs": defs,
    }


def _object(properties: dict[str, Any], optional: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return the schema of an object with these members and no others."""
    return {
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def _when(member: str, value: dict[str, Any], name: str) -> dict[str, Any]:
    """Return a rule: what has this member with this value is described by that definition."""
    condition = {"properties": {member: value}, "required": [member]}
    return {"if": condition, "then": {"$ref": f"#/$defs/{name}"}}


def _file(head: dict[str, Any], name: str, item: str) -> dict[str, Any]:
    items = {"type": "array", "items": {"$ref": f"#/$defs/{item}"}, "minItems": 1}
    return _object({"version": {"const": 1}, **head, name: items})


def _some_of(names: list[str]) -> dict[str, Any]:
    """Return the schema of a list of some of these names."""
    return {"type": "array", "items": {"enum": names}, "minItems": 1, "uniqueItems": True}


def _common() -> dict[str, Any]:
    """Return the definitions that all stages share."""
    names = {name: {"type": "string", "minLength": 1} for name in Flag._fields}
    stages = {"type": "array", "items": {"enum": [stage.name for stage in STAGES]}}
    with_cases = [flag.name for flag in FLAGS if flag.stages]
    defs = {
        "float": {
            "description": "C's hexadecimal notation, which strtod reads",
            "type": "string",
            "pattern": f"^({HEX.pattern})$",
        },
        "npy": {
            "description": "a long array: a file of numpy's format 1.0 beside, <f8 or <i4",
            **_object({"npy": {"type": "string", "pattern": r"^[A-Za-z0-9._-]+\.npy$"}}),
        },
        "flags": _some_of(with_cases),
        "dtypes": _some_of(list(DTYPES)),
        "flags_file": _file({}, "flags", "flag"),
        "flag": _object({**names, "name": {"enum": list(FLAG)}, "stages": stages}),
    }
    defs |= {f"judge_{name}": _judge(name, judge) for name, judge in JUDGES.items()}
    for status in STATUSES:
        values = {"const": [status]}
        defs[f"status_{status}"] = _object({"judge": {"const": "equal"}, "values": values})
    return defs


def _case(stage: Stage) -> dict[str, Any]:
    """Return the schema of a case of a stage."""
    outputs = {field.name: _output(stage, field) for field in stage.outputs}
    status = [{"$ref": f"#/$defs/status_{name}"} for name in STATUSES]
    case = _object(
        {
            "id": {"type": "string", "pattern": f"^{stage.name}{ID}$"},
            "stage": {"const": stage.name},
            "flags": {"$ref": "#/$defs/flags"},
            "verdict": {"enum": list(VERDICTS)},
            "grade": {"enum": list(GRADES)},
            "dtypes": {"$ref": "#/$defs/dtypes"},
            "what": {"type": "string", "pattern": r"^[ -~]+\.$"},
            "input": _object(
                {field.name: _value(field) for field in stage.inputs},
                tuple(field.name for field in stage.inputs if field.optional),
            ),
            "expected": {
                **_object({**outputs, STATUS: {"anyOf": status}}, (*outputs, STATUS)),
                "minProperties": 1,
            },
        }
    )
    is_invalid = {"properties": {"verdict": {"const": INVALID}}}
    refused = {"properties": {STATUS: status[1]}, "required": [STATUS]}
    answered = {"properties": {STATUS: status[0]}}
    return {
        "description": f"{stage.title}: {stage.formula}",
        **case,
        "if": is_invalid,
        "then": {"properties": {"expected": refused}},
        "else": {"properties": {"expected": answered}},
    }


def _described(field: Field) -> str:
    shape = ", ".join(map(str, field.shape))
    unit = f" [{field.unit}]" if field.unit else ""
    return f"({shape}){unit}: {field.what}" if field.shape else f"{field.what}{unit}"


def _value(field: Field) -> dict[str, Any]:
    """Return the schema of an input."""
    described = {"description": _described(field)}
    if not field.shape:
        return described | ITEMS[field.kind]
    array: dict[str, Any] = {"type": "array", "items": ITEMS[field.kind]}
    if all(isinstance(size, int) for size in field.shape):
        length = prod(int(size) for size in field.shape)
        return described | array | {"minItems": length, "maxItems": length}
    return described | {"anyOf": [array, {"$ref": "#/$defs/npy"}]}


def _output(stage: Stage, field: Field) -> dict[str, Any]:
    """Return the schema of what is expected of an output."""
    judges = [
        {"$ref": f"#/$defs/judge_{name}"}
        for name, judge in JUDGES.items()
        if judge.judges(stage.name, field.name, field.kind)
    ]
    return {"description": _described(field), "anyOf": judges}


def _judge(name: str, judge: Judge) -> dict[str, Any]:
    """Return the schema of an expected output with this judge."""
    known = judge.parameters | judge.optional
    members = {member: _member(kind) for member, kind in known.items()}
    described = _object({"judge": {"const": name}, **members}, tuple(judge.optional))
    return {"description": judge.what, **described}


def _member(kind: str) -> dict[str, Any]:
    """Return the schema of what a judge needs to know."""
    number, integer = ITEMS[FLOAT], {"type": "integer"}
    if kind == parameters.NUMBER:
        return number
    if kind == parameters.COUNT:
        return {**integer, "minimum": 1}
    if kind == parameters.PAIR_KIND:
        return {"enum": list(parameters.PAIR_KINDS)}
    item = {
        parameters.INTEGERS: integer,
        parameters.WORDS: {"type": ["integer", "string"]},
    }.get(kind, number)
    arrays = [{"type": "array", "items": item}, {"$ref": "#/$defs/npy"}]
    return {"anyOf": [number, *arrays] if kind == parameters.SCALE else arrays}

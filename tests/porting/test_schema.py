"""The JSON Schema of the vectors accepts every file, and nothing that is broken."""

import copy
import json

import jsonschema
import pytest

from izo_ref.porting.files import CHECKOUT
from izo_ref.porting.generate.build import contents
from izo_ref.porting.parameters import JUDGES
from izo_ref.porting.schema import schema, schema_text
from izo_ref.porting.stages import STAGES
from tests.helpers.fake_vectors import fake_cases


def validator():
    """Return a validator of the schema."""
    jsonschema.Draft202012Validator.check_schema(schema())
    return jsonschema.Draft202012Validator(schema())


def without_arrays(stage):
    """Return a stage's file as a Python object."""
    return json.loads(contents(fake_cases())[f"{stage}.json"])


def test_all_files_are_as_the_schema_says():
    judge = validator()
    for name, content in contents(fake_cases()).items():
        if name.endswith(".json") and name != "schema.json":
            assert not list(judge.iter_errors(json.loads(content))), name


BROKEN = [
    ("S2", ("id",), "S3-face-01"),
    ("S2", ("flags",), ["unknown"]),
    ("S2", ("verdict",), "maybe"),
    ("S2", ("dtypes",), ["f2"]),
    ("S2", ("input", "start"), ["0x1p+0"] * 11),
    ("S2", ("input", "is_edge_edge"), 2),
    ("S2", ("input", "other"), 2),
    ("S2", ("input", "start", 0), "1.5"),
    ("S2", ("input", "start", 0), 1.5),
    ("S2", ("expected", "toi", "judge"), "values"),
    ("S2", ("expected", "toi", "multiple"), 0),
    ("S2", ("expected", "toi", "late"), 0),
    ("S2", ("expected", "status"), {"judge": "equal", "values": ["refused"]}),
    ("S2", ("expected", "other"), {"judge": "equal", "values": [1]}),
    ("S12", ("input", "positions_t0"), {"npy": "../secret"}),
    ("S13", ("verdict",), "valid"),
    ("S13", ("expected", "status", "values"), ["ok"]),
    ("S1", ("expected", "vertex_face", "kind"), "vertex-vertex"),
    ("S3", ("expected", "weights", "judge"), "side"),
]


@pytest.mark.parametrize(("stage", "where", "value"), BROKEN)
def test_the_schema_rejects_a_broken_file(stage, where, value):
    judge = validator()
    content = without_arrays(stage)
    assert judge.is_valid(content)
    at = content["cases"][0]
    for name in where[:-1]:
        at = at[name]
    before = copy.deepcopy(at)
    at[where[-1]] = value
    assert at != before
    assert not judge.is_valid(content)


def test_the_schema_rejects_what_is_missing():
    judge = validator()
    for stage in ("S2", "S12"):
        for member in list(without_arrays(stage)["cases"][0]):
            content = without_arrays(stage)
            del content["cases"][0][member]
            assert not judge.is_valid(content), member
    assert not judge.is_valid({})
    assert not judge.is_valid({"version": 1, "stage": "S14", "cases": [{}]})


def test_a_multiple_of_one_type_of_floats_may_be_added():
    judge = validator()
    content = without_arrays("S2")
    toi = content["cases"][0]["expected"]["toi"]
    toi["multiple_f8"] = 64
    assert judge.is_valid(content)
    toi["multiple_f2"] = 64
    assert not judge.is_valid(content)


def test_the_stored_schema_is_the_current_one():
    assert (CHECKOUT / "schema.json").read_text(encoding="ascii") == schema_text()


def test_every_output_has_a_judge_and_every_judge_an_output():
    outputs = [(stage.name, field) for stage in STAGES for field in stage.outputs]
    for stage, field in outputs:
        assert any(judge.judges(stage, field.name, field.kind) for judge in JUDGES.values())
    for judge in JUDGES.values():
        assert any(judge.judges(stage, field.name, field.kind) for stage, field in outputs)
        names = {f"{stage}.{field.name}" for stage, field in outputs}
        assert set(judge.outputs) <= names


def test_the_stored_files_are_as_the_schema_says():
    judge = validator()
    for path in sorted(CHECKOUT.glob("*.json")):
        if path.name != "schema.json":
            assert not list(judge.iter_errors(json.loads(path.read_text()))), path.name

"""The files of the vectors: what is checked, written, read, and compared."""

import hashlib
import io
import json
import re
import subprocess
import sys

import numpy as np
import pytest

from izo_ref.base import whole_folder
from izo_ref.base.errors import VectorsError
from izo_ref.porting.cases import GRADES, LARGE, case_line, case_of
from izo_ref.porting.checks import check_cases
from izo_ref.porting.files import CHECKOUT, load_case, load_cases, wrong_files
from izo_ref.porting.generate import build
from izo_ref.porting.generate.build import contents, generated_cases, write_folder
from izo_ref.porting.generate.compare import differences
from izo_ref.porting.npy import npy_bytes, npy_numbers
from izo_ref.porting.reading import lines_of, method_page
from izo_ref.porting.stages import STAGES
from tests.helpers.fake_vectors import (
    PAIR,
    ZONE,
    case,
    exactly,
    fake_cases,
    time_of_impact,
)
from validation import house

GOOD = time_of_impact("S2-face-01", PAIR)
TIME = GOOD.expected["toi"]


@pytest.fixture
def folder(tmp_path):
    """Write the made-up cases into a folder, and return it."""
    write_folder(contents(fake_cases()), tmp_path / "v1")
    return tmp_path / "v1"


def with_input(**values):
    """Return a good case with other inputs."""
    return GOOD._replace(inputs={**GOOD.inputs, **values})


def with_toi(**members):
    """Return a good case of which other times are expected."""
    return GOOD._replace(expected={**GOOD.expected, "toi": {**TIME, **members}})


def with_output(**values):
    """Return a good case of which other outputs are expected."""
    return GOOD._replace(expected={**GOOD.expected, **values})


ZONE_AT = {**ZONE, "positions": ZONE["proposed"]}
OBJECTIVE = {"objective": exactly(1.0)}
WRONG = [
    (GOOD._replace(stage="S3"), "expected the stage S2, found 'S3'"),
    (GOOD._replace(id="S2-Face-01"), "expected an id like S2-word-01"),
    (GOOD._replace(id="S3-face-01"), "expected an id like S2-word-01"),
    (GOOD._replace(flags=("linear-cube",)), "a flag with stages, found 'linear-cube'"),
    (GOOD._replace(flags=("thread-race",)), "a flag with stages, found 'thread-race'"),
    (GOOD._replace(flags=()), "at least one"),
    (GOOD._replace(verdict="maybe"), "a verdict of valid, invalid, acceptable"),
    (GOOD._replace(grade="simple"), "a grade of easy, medium, hard, found 'simple'"),
    (GOOD._replace(dtypes=("f4", "f8")), "dtypes f8, f4 or both"),
    (GOOD._replace(dtypes=()), "dtypes f8, f4 or both"),
    (GOOD._replace(what="no full stop"), "a sentence"),
    (with_input(other=1), "inputs of S2, found 'other'"),
    (GOOD._replace(inputs={"is_edge_edge": 0}), "expected the input start, found 'none'"),
    (with_input(start=[1.0] * 11), "12 elements, for start to have the shape 4 x 3, found 11"),
    (with_input(start=[1.0] * 11 + [1]), "a float in start, found 1"),
    (with_input(start=1.0), "start to be a flat list"),
    (with_input(is_edge_edge=[0]), "is_edge_edge to be a single value"),
    (with_input(is_edge_edge=2), "0 or 1 in is_edge_edge, found 2"),
    (with_input(is_edge_edge=True), "0 or 1 in is_edge_edge, found True"),
    (GOOD._replace(expected={}), "something to expect"),
    (with_output(time=TIME), "an output of S2, found 'time'"),
    (with_output(status={"judge": "equal", "values": ["no"]}), "the status ok or refused"),
    (with_output(status={"judge": "equal", "values": ["refused"]}), "if and only if invalid"),
    (GOOD._replace(verdict="invalid"), "if and only if invalid, found False"),
    (with_output(toi={"judge": "times"}), "toi: expected a judge of values, equal"),
    (with_output(toi={"judge": "partition", "values": [1]}), "a judge that can judge toi"),
    (with_output(meets={"judge": "values"}), "a judge that can judge meets"),
    (with_output(meets={"judge": "equal", "values": [2]}), "0 or 1 in meets, found 2"),
    (with_output(meets={"judge": "equal", "values": [1, 1]}), "1 elements, for meets"),
    (with_toi(late=0.5), "time, scale, multiple, early"),
    (with_toi(time=1), "toi.time to be float, found 1"),
    (with_toi(multiple=4.0), "toi.multiple to be count, found 4.0"),
    (with_toi(multiple=0), "toi.multiple to be count, found 0"),
]
WRONG_SHAPES = [
    ({"nodes": [0, 1, 2]}, "nodes to have the shape m x 4, found 3"),
    ({"weights": [1.0] * 8}, "4 elements, for weights to have the shape m x 4 with m = 1, found 8"),
    ({"masses": [1.0] * 3}, "4 elements, for masses to have the shape n with m = 1, n = 4"),
]


@pytest.mark.parametrize(("wrong", "message"), WRONG, ids=[text for _, text in WRONG])
def test_the_first_wrong_case_is_named(wrong, message):
    check_cases([GOOD], "S2")
    with pytest.raises(VectorsError, match=f"^{wrong.id}: .*{re.escape(message)}"):
        check_cases([time_of_impact("S2-other-01", PAIR), wrong], "S2")


@pytest.mark.parametrize(("inputs", "message"), WRONG_SHAPES)
def test_letters_of_shapes_mean_the_same_count_in_all_inputs(inputs, message):
    good = case("S6-zone-01", "node-order", ZONE_AT, OBJECTIVE)
    check_cases([good], "S6")
    with pytest.raises(VectorsError, match=re.escape(message)):
        check_cases([good._replace(inputs={**ZONE_AT, **inputs})], "S6")


def test_expected_values_have_the_length_of_their_shape_and_scales_of_theirs():
    def with_gradient(gradient):
        return case("S6-zone-01", "node-order", ZONE_AT, {"gradient": gradient})

    good = exactly(*[0.0] * 12)
    check_cases(
        [with_gradient(good), with_gradient({**good, "scale": [1.0]})._replace(id="S6-zone-02")],
        "S6",
    )
    with pytest.raises(VectorsError, match="12 elements, for gradient"):
        check_cases([with_gradient(exactly(*[0.0] * 11))], "S6")
    with pytest.raises(VectorsError, match="1 or 12 scales of gradient, found 5"):
        check_cases([with_gradient({**good, "scale": [1.0] * 5})], "S6")


def test_an_id_that_comes_twice_is_named():
    with pytest.raises(VectorsError, match="S2-face-01: expected ids that are unique"):
        check_cases([GOOD, GOOD], "S2")


def test_a_stage_without_a_generator_is_an_error(monkeypatch):
    def not_there(name):
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(build, "import_module", not_there)
    with pytest.raises(VectorsError, match=r"S4: expected a generator .*generate\.s04, found none"):
        generated_cases(["S4"])


def test_a_generator_that_cannot_import_something_is_not_called_missing(monkeypatch):
    def not_there(name):
        raise ModuleNotFoundError(name="other")

    monkeypatch.setattr(build, "import_module", not_there)
    with pytest.raises(ModuleNotFoundError):
        generated_cases(["S4"])


def test_too_many_bytes_are_refused(monkeypatch):
    monkeypatch.setattr(build, "LARGEST", 1000)
    with pytest.raises(VectorsError, match="1,000 bytes in all files"):
        contents(fake_cases())


def test_cases_come_back_as_they_were_written(folder):
    cases = fake_cases()
    for stage, written in cases.items():
        assert load_cases(folder, [stage]) == written
    assert (folder / "S12-still-01.input.positions_t0.npy").is_file()
    assert load_case("S12-still-01", folder) == cases["S12"][0]
    with pytest.raises(VectorsError, match="near ids are: S2-face-01"):
        load_case("S2-fase-01", folder)


def test_each_line_of_a_stage_is_a_case(folder):
    lines = (folder / "S13.json").read_text().splitlines()
    assert json.loads(f"{lines[0]}]}}") == {"version": 1, "stage": "S13", "cases": []}
    assert [json.loads(line.rstrip(","))["id"] for line in lines[1:-1]] == [
        "S13-short-01",
        "S13-fine-01",
    ]
    assert case_of(json.loads(lines[1].rstrip(","))) == fake_cases()["S13"][0]
    assert case_line(fake_cases()["S13"][0]) == lines[1].rstrip(",")


def test_the_bytes_of_an_array_are_those_that_numpy_writes():
    for numbers, dtype in (([0.5, -1.0, 1e300] * 700, "<f8"), ([3, -1] * 5, "<i4"), ([1.5], "<f8")):
        file = io.BytesIO()
        np.lib.format.write_array(file, np.array(numbers, dtype), version=(1, 0))
        assert npy_bytes(numbers) == file.getvalue()
        assert npy_numbers(file.getvalue()) == numbers
    with pytest.raises(VectorsError, match="32 bits"):
        npy_bytes([2**31])
    with pytest.raises(VectorsError, match="flat array"):
        npy_numbers(b"PK")
    with pytest.raises(VectorsError, match="1 numbers of 8 bytes, found 4 bytes"):
        npy_numbers(npy_bytes([0.5])[:-4])
    table = io.BytesIO()
    np.lib.format.write_array(table, np.zeros((2, 2)), version=(1, 0))
    with pytest.raises(VectorsError, match="flat array"):
        npy_numbers(table.getvalue())


def test_damaged_folders_are_named(folder):
    assert wrong_files(folder) == []
    sums = (folder / "SHA256SUMS").read_text()
    digest = hashlib.sha256((folder / "S2.json").read_bytes()).hexdigest()
    assert f"{digest}  S2.json\n" in sums
    (folder / "S2.json").write_text("{}")
    (folder / "S3.json").unlink()
    (folder / "notes.txt").write_text("mine")
    assert wrong_files(folder) == [
        "S2.json: differs from its sum in SHA256SUMS",
        "S3.json: is missing",
        "notes.txt: is not named in SHA256SUMS",
    ]
    with pytest.raises(VectorsError, match=r"S2\.json: is damaged"):
        load_cases(folder, ["S2"])
    with pytest.raises(VectorsError, match=r"S3\.json: cannot be read"):
        load_cases(folder, ["S3"])
    (folder / "S12-still-01.input.positions_t0.npy").write_bytes(b"")
    with pytest.raises(VectorsError, match=r"positions_t0\.npy: expected a flat array"):
        load_cases(folder, ["S12"])


def test_what_the_generators_make_otherwise_is_named(folder):
    files = contents(fake_cases())
    assert differences(files, folder) == []
    other = fake_cases()
    other["S3"][1] = other["S3"][1]._replace(what="It is another one.")
    other["S12"][0].inputs["positions_t1"][-1] += 1.0
    lines = differences(contents(other), folder)
    assert "S3.json: differs from what the generators make, first in line 3, S3-edges-01" in lines
    assert any("positions_t1.npy: differs" in line and "at byte" in line for line in lines)
    (folder / "S2.json").unlink()
    (folder / "S99.json").write_text("")
    lines = differences(files, folder)
    assert lines == [
        "S2.json: is missing; the generators make it",
        "S99.json: is not made by the generators",
    ]


def test_a_folder_is_replaced_whole_or_not_at_all(folder, monkeypatch):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    files = {"SHA256SUMS": b"", "S1.json": b"new"}

    def fails(one, other):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(whole_folder, "_exchange", fails)
    with pytest.raises(VectorsError, match="No space left"):
        write_folder(files, folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in folder.parent.iterdir()] == ["v1"]
    monkeypatch.undo()
    write_folder(files, folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == files
    assert [path.name for path in folder.parent.iterdir()] == ["v1"]


def test_no_file_of_the_user_is_lost(folder, tmp_path):
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(VectorsError, match=r"notes\.txt in it does not belong to vectors"):
        write_folder({}, folder)
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("mine")
    with pytest.raises(VectorsError, match=r"thesis\.tex"):
        write_folder({}, tmp_path / "home")
    with pytest.raises(VectorsError, match="expected a folder, found a file"):
        write_folder({}, tmp_path / "home" / "thesis.tex")
    with pytest.raises(VectorsError, match="create the folder above"):
        write_folder({}, tmp_path / "nowhere" / "v1")


def test_the_readme_counts_all_cases(folder):
    text = (folder / "README.md").read_text()
    cases = [case for found in fake_cases().values() for case in found]
    assert f"{len(cases)} cases." in text
    assert "| S2, time of impact | 2 | 0 | 0 | 2 |" in text
    assert "| `normal-sign` | 0 | 0 | 2 | 2 |" in text
    assert f"more than {LARGE} numbers" in text


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_every_stage_says_where_to_read(stage):
    lines = lines_of(stage)
    source = (house.ROOT / lines.path).read_text().splitlines()
    block = "\n".join(source[lines.first - 1 : lines.last])
    assert re.search(rf"^(def|class) {lines.name}\b", block, re.M)
    assert lines.first < lines.last
    assert (house.ROOT / method_page(stage)).is_file()


def test_vectors_are_made_read_and_shown_without_numba():
    code = (
        "import sys; import izo_ref.app.vectors_command, izo_ref.porting.generate.compare;"
        "import izo_ref.porting.show, izo_ref.porting.picture;"
        "print('numba' in sys.modules)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "False"


def test_the_stored_files_are_those_that_the_generators_make():
    assert wrong_files(CHECKOUT) == []
    assert differences(contents(generated_cases()), CHECKOUT) == []


def test_the_stored_cases_have_every_stage_and_grade():
    cases = load_cases()
    assert len(cases) >= 300
    assert {case.stage for case in cases} == {stage.name for stage in STAGES}
    assert {case.grade for case in cases} == set(GRADES)
    assert len({case.id for case in cases}) == len(cases)

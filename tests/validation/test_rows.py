"""Rows of measurements: they keep their types, resume after a cut, and name their run."""

import math

import numpy as np
import pytest

from validation.rows import Rows, begin_run, read, runs

ROW = {"zone": "a", "size": 4}


def test_rows_come_back_with_their_types(tmp_path):
    rows = Rows(tmp_path, "study", ("zone", "size"))
    values = {"flag": True, "count": -3, "time": 1.5e-9, "text": "to 1e-9, or so", "none": None}
    rows.add(zone="a", size=4, **values, outcome="converged", message="")
    (row,) = Rows(tmp_path, "study", ("zone", "size")).all()
    back = {name: row[name] for name in values}
    assert back == values
    assert [type(back[name]) for name in back] == [type(values[name]) for name in values]
    assert list(row)[:3] == ["zone", "size", "run"]
    assert row["message"] is None


@pytest.mark.parametrize("value", [0.1, 1e-300, -1e300, math.inf, -math.inf, 2.0])
def test_floats_come_back_to_the_last_bit(tmp_path, value):
    rows = Rows(tmp_path, "study", ())
    rows.add(value=np.float64(value))
    assert rows.all()[0]["value"] == value
    assert type(rows.all()[0]["value"]) is float


@pytest.mark.parametrize("text", ["12", "1e5", "True", "inf", "-0.5", '"quoted"', 'a "b", c'])
def test_texts_stay_texts(tmp_path, text):
    Rows(tmp_path, "study", ()).add(value=text)
    assert read(tmp_path, "study")[0]["value"] == text


def test_a_message_of_two_lines_is_one_row(tmp_path):
    rows = Rows(tmp_path, "study", ("zone",))
    rows.add(zone="a", outcome="failed", message="ValueError:\n  no such thing")
    rows.add(zone="b", outcome="converged", message=None)
    assert len((tmp_path / "study.csv").read_text().splitlines()) == 3
    assert rows.all()[0]["message"] == "ValueError: no such thing"


def test_a_run_resumes_where_it_was(tmp_path):
    begin_run(tmp_path, "report", False)
    rows = Rows(tmp_path, "study", ("zone", "size"))
    assert not rows.has(**ROW)
    rows.add(**ROW, seconds=1.0)
    assert rows.has(**ROW)
    assert begin_run(tmp_path, "report", False) == 1
    again = Rows(tmp_path, "study", ("zone", "size"))
    assert again.has(**ROW)
    assert not again.has(zone="a", size=5)
    # Rows of a quick run do not replace those of a full run, nor the other way round.
    begin_run(tmp_path, "report", True)
    assert not Rows(tmp_path, "study", ("zone", "size")).has(**ROW)


def test_a_line_cut_off_is_measured_again(tmp_path):
    rows = Rows(tmp_path, "study", ("zone", "size"))
    rows.add(**ROW, seconds=1.0)
    rows.add(zone="b", size=8, seconds=2.0)
    path = tmp_path / "study.csv"
    path.write_bytes(path.read_bytes()[:-3])
    assert [row["zone"] for row in read(tmp_path, "study")] == ["a"]  # before the file is repaired
    again = Rows(tmp_path, "study", ("zone", "size"))
    assert again.has(**ROW)
    assert not again.has(zone="b", size=8)
    again.add(zone="b", size=8, seconds=3.0)
    assert [row["seconds"] for row in again.all()] == [1.0, 3.0]


def test_a_new_column_is_empty_in_the_rows_before(tmp_path):
    rows = Rows(tmp_path, "study", ("zone", "size"))
    rows.add(**ROW, seconds=1.0)
    rows.add(zone="b", size=8, seconds=2.0, steps=7)
    rows.add(zone="c", size=8, steps=9)
    found = [(row["zone"], row["seconds"], row["steps"]) for row in rows.all()]
    assert found == [("a", 1.0, None), ("b", 2.0, 7), ("c", None, 9)]


def test_rows_name_their_run(tmp_path):
    first = begin_run(tmp_path, "python -m validation report", False)
    Rows(tmp_path, "study", ("zone",)).add(zone="a")
    second = begin_run(tmp_path, "python -m validation report --only outer", False)
    Rows(tmp_path, "study", ("zone",)).add(zone="b")
    assert [row["run"] for row in read(tmp_path, "study")] == [first, second]
    run = runs(tmp_path)[0]
    assert run["command"] == "python -m validation report"
    assert "numba" in run["versions"]
    assert all(run[name] for name in ("commit", "machine", "started"))


def test_wrong_rows_are_refused(tmp_path):
    rows = Rows(tmp_path, "study", ("zone",))
    with pytest.raises(ValueError, match="missing"):
        rows.add(size=4)
    with pytest.raises(ValueError, match="outcome"):
        rows.add(zone="a", outcome="solved")
    with pytest.raises(ValueError, match="expected bool"):
        rows.add(zone="a", value=[1.0])
    assert rows.all() == []


def test_a_study_that_was_not_run_has_no_rows(tmp_path):
    assert read(tmp_path / "nowhere", "study") == []
    assert runs(tmp_path / "nowhere") == []

"""The command `izo vectors`: what it prints, the files that it writes, and its exit codes."""

import xml.etree.ElementTree as ET

import pytest

from izo_ref.app.cli import main
from izo_ref.porting.generate import build
from izo_ref.porting.generate.build import contents, write_folder
from izo_ref.porting.show import case_text
from izo_ref.porting.stages import STAGES
from tests.helpers.fake_vectors import fake_cases

SVG = "{http://www.w3.org/2000/svg}"


def run(*words):
    """Run `izo vectors` in this process and return its exit code."""
    return main(["vectors", *map(str, words)])


def all_stages():
    """Return the made-up cases, with no cases for all other stages."""
    cases = fake_cases()
    return {stage.name: cases.get(stage.name, []) for stage in STAGES}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Write the made-up cases, let the generators make the same ones, and return the folder."""
    monkeypatch.setattr(build, "generated_cases", all_stages)
    write_folder(contents(all_stages()), tmp_path / "v1")
    return tmp_path / "v1"


def test_list_prints_one_line_a_case(folder, capsys):
    assert run("list", "--folder", folder) == 0
    lines = capsys.readouterr().out.splitlines()
    head, _, what = lines[0].partition(": ")
    assert head.split() == ["S1-none-01", "easy", "valid", "f8+f4", "missed-pairs"]
    assert what == "It is made up."
    assert lines[-1] == "10 of 10 cases"
    assert len(lines) == 11


@pytest.mark.parametrize(
    ("words", "ids"),
    [
        (["--stage", "S2"], ["S2-face-01", "S2-edges-01"]),
        (["--flag", "over-strict"], ["S12-still-01", "S13-fine-01"]),
        (["--grade", "hard"], ["S3-face-01", "S3-edges-01"]),
        (["--stage", "2"], ["S2-face-01", "S2-edges-01"]),
        (["--stage", "s13", "--grade", "medium"], ["S13-short-01"]),
        (["--stage", "S4"], []),
    ],
)
def test_list_has_the_cases_asked_for(folder, capsys, words, ids):
    assert run("list", "--folder", folder, *words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == ids
    assert lines[-1].startswith(f"{len(ids)} of ")


def test_an_unknown_flag_or_case_is_answered_with_near_ones(folder, capsys):
    assert run("list", "--folder", folder, "--flag", "zone-transitiv") == 2
    assert "near ones are: zone-transitive" in capsys.readouterr().err
    assert run("show", "--folder", folder, "S2-fase-01") == 2
    assert "near ids are: S2-face-01" in capsys.readouterr().err
    assert run("show", "--folder", folder, "s2") == 2
    assert "`izo vectors list --stage S2` lists the cases" in capsys.readouterr().err
    assert run("list", "--folder", folder / "nowhere") == 2
    assert "expected a folder of vectors" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        run("list", "--grade", "simple")


def test_show_says_what_a_case_is_in_words_and_numbers(folder, capsys):
    assert run("show", "--folder", folder, "S7-kink-01") == 0
    said = capsys.readouterr().out
    for text in (
        "S7-kink-01: augmented Lagrangian (easy, valid, f8 and f4)",
        "It is made up.",
        "S7: L = g + mu/2 sum max(c_j + l_j / mu, 0)^2",
        "Mistake: The maximum in max(c_j",
        "Harm: Line searches fail",
        "proposed (n x 3, n = 4) [m]: y: proposed positions",
        "    0.25 0.25   -1   0x1p-2 0x1p-2 -0x1p+0",
        "    0 0 0 1",
        "thickness [m]: d\n    0.5  0x1p-1",
        "       0  2.25  0x1.2p+1  +- 1e-15 (f8), 5.4e-07 (f4)",
        "docs/method/3-augmented-lagrangian.md",
        "izo_ref/solvers/serial/lagrangian.py:",
    ):
        assert text in said, text
    assert max(map(len, said.splitlines())) <= 100


def test_show_says_what_other_judges_ask_for(folder, capsys):
    assert run("show", "--folder", folder, "S3-face-01") == 0
    assert "least_gap: 0.5  0x1p-1" in capsys.readouterr().out
    assert run("show", "--folder", folder, "S2-face-01") == 0
    assert "early: 0.125  0x1p-3" in capsys.readouterr().out
    assert run("show", "--folder", folder, "S13-short-01") == 0
    assert "status: refused" in capsys.readouterr().out
    assert run("show", "--folder", folder, "S1-none-01") == 0
    assert "    pairs\n    none" in capsys.readouterr().out


def test_show_takes_the_multiple_of_each_type_of_floats():
    case = fake_cases()["S9"][0]
    own = {**case.expected["multipliers"], "multiple_f8": 64}
    text = case_text(case._replace(expected={"multipliers": own}))
    assert "+- 8.9e-15 (f8), 3e-07 (f4)" in text


def test_show_counts_rows_of_long_arrays_or_shows_all(folder, capsys):
    assert run("show", "--folder", folder, "S12-still-01") == 0
    short = capsys.readouterr().out
    assert "... and 688 more rows, which --all shows" in short
    assert run("show", "--folder", folder, "--all", "S12-still-01") == 0
    whole = capsys.readouterr().out
    assert "more rows" not in whole
    assert len(whole.splitlines()) > 2100


@pytest.mark.parametrize(
    ("case_id", "texts"),
    [
        ("S2-face-01", ["t = 0", "t = 1", "t = 0.5, with the closest points"]),
        ("S3-edges-01", ["t = 0", "t = 1", "t = 0.5, with the closest points"]),
        ("S7-kink-01", ["proposed positions", "normals of impacts", "where to evaluate"]),
        ("S12-still-01", ["t = 0", "proposed, t = 1"]),
    ],
)
def test_a_picture_is_a_drawing_with_a_legend(folder, tmp_path, case_id, texts):
    path = tmp_path / "picture.svg"
    assert run("show", "--folder", folder, case_id, "--picture", path) == 0
    root = ET.parse(path).getroot()
    assert root.tag == f"{SVG}svg"
    assert root.find(f"{SVG}title").text == f"{case_id}: It is made up."
    found = {text.text for text in root.iter(f"{SVG}text")}
    assert {*texts, case_id} <= found
    for line in root.iter(f"{SVG}line"):
        assert all(0.0 <= float(line.get(name)) <= 600.0 for name in ("x1", "y1", "x2", "y2"))


def test_the_closest_points_of_a_picture_are_where_the_pair_meets(folder, tmp_path):
    """The edges meet in the middle of both, so both points are drawn at the same place."""
    path = tmp_path / "picture.svg"
    run("show", "--folder", folder, "S3-edges-01", "--picture", path)
    dots = [dot for dot in ET.parse(path).getroot().iter(f"{SVG}circle") if dot.get("r") == "4.0"]
    places = {(dot.get("cx"), dot.get("cy")) for dot in dots}
    assert len(dots) == 2
    assert len(places) == 1


def test_a_case_without_positions_has_no_picture(folder, tmp_path, capsys):
    path = tmp_path / "picture.svg"
    assert run("show", "--folder", folder, "S9-clamp-01", "--picture", path) == 2
    assert "expected a case with positions" in capsys.readouterr().err
    assert not path.exists()


def test_make_writes_what_verify_accepts(folder, tmp_path, capsys):
    assert run("make", "-o", tmp_path / "made") == 0
    assert "10 cases in 19 files" in capsys.readouterr().out
    assert run("verify", "--folder", tmp_path / "made") == 0
    assert "bit for bit" in capsys.readouterr().out


def test_verify_names_a_changed_file_and_exits_with_one(folder, capsys):
    (folder / "S9.json").write_text("{}\n")
    assert run("verify", "--folder", folder) == 1
    assert "S9.json: differs from its sum in SHA256SUMS" in capsys.readouterr().out


def test_verify_names_the_first_case_that_the_generators_make_otherwise(
    folder, capsys, monkeypatch
):
    def other_cases():
        cases = all_stages()
        cases["S3"][1] = cases["S3"][1]._replace(grade="easy")
        return cases

    monkeypatch.setattr(build, "generated_cases", other_cases)
    assert run("verify", "--folder", folder) == 1
    said = capsys.readouterr().out
    assert "all files have the sums" in said
    assert "S3.json: differs from what the generators make, first in line 3, S3-edges-01" in said

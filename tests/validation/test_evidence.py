"""The evidence of whole steps: tables, results that are wrong, and the files written."""

import pytest

from validation.__main__ import main
from validation.oracles import ipc
from validation.report.tables import cell_text, table
from validation.study.evidence import wrong_rows


def test_cells_keep_the_digits_that_matter():
    cells = [None, True, 1234567, 0.0, 0.123456, 1.5e-13, float("inf"), "a|b"]
    assert [cell_text(c) for c in cells] == [
        "",
        "yes",
        "1,234,567",
        "0",
        "0.1235",
        "1.5e-13",
        "none",
        "a/b",
    ]
    rows = [{"a": 1, "b": 2.5}]
    assert table({"A": "a", "twice b": lambda row: 2 * row["b"]}, rows) == (
        "| A | twice b |\n|---|---|\n| 1 | 5 |\n"
    )


@pytest.mark.skipif(bool(ipc.unusable()), reason=f"ipctk: {ipc.unusable()}")
def test_check_finds_what_is_left_in_wrong_results():
    """The proposed positions, a vertex pushed through a face by a nanometre, swapped layers."""
    rows = wrong_rows()
    assert len(rows) == 3
    for row in rows:
        assert not row["verdict"]["passed"], row["result"]
        # Our certificate and the others reject each path; swapped layers are free at the end.
        free = {f["by"]: f["passed"] for f in row["verdict"]["facts"] if "free" in f["question"]}
        path = [free[by] for by in free if by not in ("python-fcl", "ipctk")]
        assert path == [False, False], row["result"]
        at_the_end = free["python-fcl"], free["ipctk"]
        assert at_the_end == ((True, True) if "swapped" in row["result"] else (False, False))


@pytest.mark.parametrize(
    ("free", "triangles", "blocked"),
    [
        ("at-rest", "1,360", "pinch-blocked"),
        pytest.param("ipctd-thick-cloth", "404", "pinch-blocked-10k", marks=pytest.mark.data),
    ],
)
def test_the_evidence_of_a_step_is_written(tmp_path, free, triangles, blocked):
    names = [free, blocked]
    assert main(["evidence", *names, "-o", str(tmp_path)]) == 0
    summary = (tmp_path / "evidence" / "README.md").read_text()
    asked = "not judged" if ipc.unusable() else "free"
    answers = f"free | {asked} | free | {asked} | passed"
    assert f"| {free} | {triangles} | FREE | {answers} |" in summary
    assert "failed, as the result says" in summary
    for name in names:
        assert (tmp_path / "evidence" / f"{name}.json").exists()

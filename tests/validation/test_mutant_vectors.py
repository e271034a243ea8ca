"""Every fault has a flag, and the runner of the vectors tells caught from survived."""

import json

import pytest

from izo_ref.porting.flags import FLAG
from validation.__main__ import main
from validation.mutants.fault import Fault
from validation.mutants.faults import FAULTS
from validation.mutants.vectors import VECTORS, Finding, read_report, run_vectors

# A harness that knows one stage: it asks for twice each number, and writes the report.
HARNESS = """
import json, subprocess, sys
from pathlib import Path
words = sys.argv
port, report = words[words.index("--exec") + 1], Path(words[words.index("--json") + 1])
cases = json.loads(Path("data/vectors/v1/S9.json").read_text())["cases"]
done = subprocess.run([port], input="".join(f"{c['input']}\\n" for c in cases),
                      capture_output=True, text=True)
got = done.stdout.split()
rows = []
for i, case in enumerate(cases):
    right = i < len(got) and got[i] == str(case["expected"])
    result = "passed" if right else "failed" if i < len(got) else "not run"
    rows.append({"id": case["id"], "stage": "S9", "result": result})
notes = [] if done.returncode == 0 else ["the port crashed"]
report.write_text(json.dumps({"cases": rows if got else [], "notes": notes}))
sys.exit(any(row["result"] != "passed" for row in rows))
"""
PORT = """
import sys
from izo_ref.sums import twice
for line in sys.stdin:
    print(twice(int(line)), flush=True)
"""
CASES = [
    {"id": "S9-plain-01", "flags": ["lost-sum"], "input": 1, "expected": 2},
    {"id": "S9-large-01", "flags": ["kink", "lost-sum"], "input": 100, "expected": 200},
]


@pytest.fixture
def repository(tmp_path):
    """Return a small repository with a harness, a port and two vectors."""
    files = {
        "izo_ref/__init__.py": "",
        "izo_ref/sums.py": "LARGE = 50\n\n\ndef twice(a):\n"
        "    if a > LARGE:\n        return 2 * a\n    return a + a\n",
        "izo_ref/app/__init__.py": "",
        "izo_ref/app/cli.py": HARNESS,
        "tests/__init__.py": "",
        "tests/ports/__init__.py": "",
        "tests/ports/own/__init__.py": "",
        "tests/ports/own/__main__.py": PORT,
        f"{VECTORS}/S9.json": json.dumps({"cases": CASES}),
    }
    for name, text in files.items():
        path = tmp_path / "repository" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "repository"


def fault(name, old, new, flag="kink", excuse=""):
    """Return a fault of the small repository."""
    return Fault(name, "izo_ref/sums.py", old, new, "wrong", (), flag=flag, not_by_vectors=excuse)


def test_the_runner_says_at_which_stage_and_with_which_flags(repository, tmp_path, capsys):
    faults = [
        fault("large-ones", "2 * a", "3 * a"),
        fault("small-ones", "a + a", "a"),
        fault("no-start", "def twice(a):\n", "def twice(a):\n    1 / 0\n"),
        fault("harmless", "LARGE = 50", "LARGE = 60"),
        fault("excused", "a + a", "a", excuse="Nobody asks."),
    ]
    path = tmp_path / "rows.json"
    rows = run_vectors(None, path, root=repository, faults=faults)
    assert json.loads(path.read_text()) == rows
    assert [row["name"] for row in rows] == ["large-ones", "small-ones", "no-start", "harmless"]
    assert [row["caught"] for row in rows] == [True, True, True, False]
    assert [row["stages"] for row in rows] == [["S9"], ["S9"], [], []]
    assert [row["flags"] for row in rows] == [["kink", "lost-sum"], ["lost-sum"], [], []]
    assert [row["by_flag"] for row in rows] == [True, False, False, False]
    assert rows[0]["cases"] == ["S9-large-01"]
    said = capsys.readouterr().out
    assert "without fault: conforms" in said
    assert "large-ones: caught at S9 by kink, lost-sum" in said
    assert "small-ones: caught at S9 by lost-sum, but not by its own flag kink" in said
    assert "no-start: caught: no case was judged" in said
    assert "harmless: SURVIVED" in said


def test_a_port_without_end_is_caught(repository):
    hang = fault("hang", "    return a + a\n", "    while True:\n        pass\n")
    (row,) = run_vectors(root=repository, faults=[hang], limit_s=3.0)
    assert row["caught"]
    assert row["notes"] == ["no end within 3 s"]


def test_a_catch_means_nothing_if_vectors_fail_without_fault(repository):
    path = repository / "izo_ref/sums.py"
    path.write_text(path.read_text().replace("a + a", "a"))
    with pytest.raises(RuntimeError, match="without any fault, the vectors fail"):
        run_vectors(root=repository, faults=[fault("large-ones", "2 * a", "3 * a")])


def test_a_harness_without_a_report_is_an_error(repository):
    (repository / "izo_ref/app/cli.py").write_text("raise SystemExit('no such command')\n")
    with pytest.raises(RuntimeError, match=r"(?s)wrote no report, exit code 1.*no such command"):
        run_vectors(root=repository, faults=[])


def test_stages_come_in_the_order_of_the_method(tmp_path):
    cases = [{"id": f"S{i}-a-01", "stage": f"S{i}", "result": "failed"} for i in (10, 2, 9)]
    for case in cases:
        content = {"cases": [{"id": case["id"], "flags": ["kink"]}]}
        (tmp_path / f"{case['stage']}.json").write_text(json.dumps(content))
    found = read_report({"cases": cases, "notes": []}, tmp_path)
    assert found == Finding(("S2", "S9", "S10"), ("kink",), ("S10-a-01", "S2-a-01", "S9-a-01"), ())


def test_names_that_no_vector_can_notice_are_refused(capsys):
    assert main(["mutants", "--vectors", "device-measures-without-masses"]) == 2
    assert "the vectors run on the CPU" in capsys.readouterr().err
    assert main(["mutants", "--vectors", "no-such-fault"]) == 2
    assert "no faults named" in capsys.readouterr().err


def test_every_fault_has_a_flag_and_a_reason_is_a_sentence():
    for one in FAULTS:
        assert one.flag, one.name
        assert one.not_by_vectors == "" or one.not_by_vectors.endswith("."), one.name
    assert sum(not one.not_by_vectors for one in FAULTS) >= 50


def test_every_flag_is_in_the_dictionary():
    assert {one.flag for one in FAULTS} <= set(FLAG)

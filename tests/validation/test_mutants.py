"""The list of faults fits the sources, and the runner finds out which faults are caught."""

import ast
import json

import pytest

from validation.mutants.fault import Fault
from validation.mutants.faults import FAULTS
from validation.mutants.run import ROOT, run_mutants


def test_the_list_covers_many_files_and_its_names_are_unique():
    assert len(FAULTS) >= 25
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)
    assert len({fault.file for fault in FAULTS}) >= 15


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_fits_its_file(fault):
    text = (ROOT / fault.file).read_text()
    assert text.count(fault.old) == 1
    changed = text.replace(fault.old, fault.new)
    assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(text))
    assert fault.file.startswith("izo_ref/")
    assert fault.what


NAMED_TESTS = sorted({test for fault in FAULTS for test in fault.tests})


@pytest.mark.parametrize("name", NAMED_TESTS)
def test_every_test_that_a_fault_names_exists(name):
    """A name is a file of tests, or a function in such a file."""
    path, separator, function = name.partition("::")
    assert path.startswith("tests/")
    nodes = ast.parse((ROOT / path).read_text()).body
    defined = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
    tests = {other for other in defined if other.startswith("test_")}
    assert tests
    assert not separator or function in tests


@pytest.fixture
def repository(tmp_path):
    """Return a small repository in pure Python, with what the runner needs."""
    files = {
        "izo_ref/__init__.py": "",
        "izo_ref/base/compile.py": "CACHE_FOLDER = None\n",
        "izo_ref/sums.py": "def add(a, b):\n    return a + b\n\n\n"
        "def twice(a):\n    return 2 * a\n",
        "tests/__init__.py": "",
        "tests/test_add.py": "from izo_ref.sums import add\n\n\n"
        "def test_add():\n    assert add(1, 2) == 3\n",
        "tests/test_all.py": "from izo_ref.sums import twice\n\n\n"
        "def test_twice():\n    assert twice(2) == 4\n",
    }
    for name, text in files.items():
        path = tmp_path / "repository" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "repository"


def fault(name, old, new, limit_s=60.0):
    """Return a fault of the small repository, in its only module."""
    file, tests = "izo_ref/sums.py", ("tests/test_add.py",)
    return Fault(name, file, old, new, "wrong", tests, limit_s=limit_s)


def test_the_runner_tells_caught_from_survived(repository, tmp_path, capsys):
    faults = [
        fault("minus", "a + b", "a - b"),
        fault("hang", "return a + b", "while True:\n        pass", limit_s=3.0),
        fault("elsewhere", "2 * a", "3 * a"),
        fault("harmless", "2 * a", "a + a"),
    ]
    path = tmp_path / "rows.json"
    rows = run_mutants(None, path, root=repository, faults=faults)
    assert json.loads(path.read_text()) == rows
    assert [row["caught"] for row in rows] == [True, True, True, False]
    assert [row["whole"] for row in rows] == [False, False, True, True]
    assert [row["by"] for row in rows] == [
        "tests/test_add.py::test_add",
        "caught by timeout",
        "tests/test_all.py::test_twice",
        "",
    ]
    assert "harmless: SURVIVED" in capsys.readouterr().out
    assert (repository / "izo_ref/sums.py").read_text().count("a + b") == 1


def test_a_catch_means_nothing_if_tests_fail_without_fault(repository):
    (repository / "tests/test_add.py").write_text("def test_add():\n    assert False\n")
    with pytest.raises(RuntimeError, match="without any fault: tests/test_add"):
        run_mutants(root=repository, faults=[fault("minus", "a + b", "a - b")])


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="no-such-fault"):
        run_mutants(["no-such-fault"])

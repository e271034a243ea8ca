"""Faults are drawn by operator, and the runner finds out what becomes of each."""

import ast

import pytest

from validation import json_rows
from validation.mutants import arguments, random_run, reached
from validation.mutants.draw import GROUPS, draw, group_of
from validation.mutants.operators import changed, changes, is_equivalent
from validation.mutants.run import ROOT
from validation.mutants.survivors import SURVIVORS
from validation.provenance import made_by
from validation.report import random_mutants


def found(text):
    """Return what the operators make of a source: operator, and the text with the change."""
    return {(change.operator, changed(text, change)) for change in changes(text)}


def body(expression):
    return f"def f(a, b, c):\n    return {expression}\n"


@pytest.mark.parametrize(
    ("operator", "before", "after"),
    [
        ("comparison strict or loose", "a < b", "a <= b"),
        ("comparison strict or loose", "a>=b", "a>b"),
        ("comparison turned", "a < b <= c", "a < b >= c"),
        ("comparison turned", "a == b", "a != b"),
        ("constant scaled", "a * 3.0", "a * (1024.0 * 3.0)"),
        ("constant scaled", "a + 7", "a + (7 // 2)"),
        ("sign flipped", "a - b", "a + b"),
        ("sign flipped", "-a * b", "a * b"),
        ("term left out", "a - (b - c)", "a"),
        ("term left out", "c * (a + b)", "c * (a)"),
        ("factor left out", "a - (b + c) * a", "a - (b + c)"),
        ("factor left out", "a / b", "a"),
        ("call left out", "max(a, b)", "a"),
        ("call left out", "abs(a - b)", "(a - b)"),
        ("index off by one", "a[b, 1]", "a[b, 2]"),
        ("index off by one", "a[2 * b]", "a[(2 * b) - 1]"),
        ("and, or swapped", "a and (b or c)", "(a or (b or c))"),
        ("not dropped", "a and not b", "a and b"),
        ("min, max swapped", "np.maximum(a, b)", "np.minimum(a, b)"),
        ("min, max swapped", "a.min()", "a.max()"),
        ("range off by one", "range(b)", "range(1, b)"),
        ("range off by one", "range(a, b)", "range(a, b - 1)"),
        ("bound divided", "a * ROUNDING", "a * (ROUNDING / 8)"),
        ("bound divided", "a * (1.0 + 2.0**-50)", "a * (1.0 + (2.0**-50) / 64)"),
    ],
)
def test_an_operator_changes_one_place_and_leaves_the_rest(operator, before, after):
    results = found(body(before))
    wanted = ast.dump(ast.parse(body(after)))
    assert [one for one, text in results if ast.dump(ast.parse(text)) == wanted and one == operator]


def test_statements_are_left_out_and_constants_of_a_module_are_changed():
    text = "ERROR = 4.0 * U\n\n\ndef f(a):\n    a.sort()\n    a[0] += 1\n"
    results = found(text)
    assert ("call left out", text.replace("a.sort()", "pass")) in results
    assert ("term left out", text.replace("a[0] += 1", "pass")) in results
    assert ("bound divided", text.replace("4.0 * U", "(4.0 * U) / 2")) in results
    assert {change.names for change in changes(text)} == {("ERROR",), ()}


def test_messages_docstrings_and_annotations_stay():
    text = (
        'def f(a: "x[1]" = 3) -> "y[2]":\n    """Return -1 < 2."""\n'
        '    if not a:\n        raise ValueError(f"{a + 1}", 2 * 3)\n    return a\n'
    )
    assert {operator for operator, _ in found(text)} == {"not dropped"}


def test_arrays_of_one_declared_shape_may_be_confused():
    text = (
        "def f(\n    a: Floats,  # (n, 3) f8 [m]\n    b: Floats,  # (n,) f8\n"
        "    c: Floats,  # (n, 3) f8 [kg]\n    d: Ints,  # (n,) i4\n):\n    return a\n"
    )
    assert arguments.twins(text, ast.parse(text).body[0]) == {"a": ("c",), "c": ("a",)}
    assert ("another argument", text.replace("return a", "return c")) in found(text)


def test_a_change_that_compiles_to_the_same_is_equivalent():
    text = body("a * (1.0 + 0.0)")
    same = {change.new for change in changes(text) if is_equivalent(text, change)}
    assert "1.0" in same
    assert not same & {"a", "(1.0 + 0.0)"}  # the other factor alone is something else


def test_a_draw_is_repeated_and_a_longer_one_goes_on():
    first, longer = draw(ROOT, 30, 5), draw(ROOT, 60, 5)
    assert longer[:30] == first
    assert draw(ROOT, 30, 6) != first
    assert {fault.group for fault in first} == set(GROUPS)
    assert len({fault.operator for fault in longer}) > 10
    assert len({fault.key for fault in longer}) == 60
    for fault in longer:
        text = (ROOT / fault.file).read_text()
        assert ast.dump(ast.parse(text)) != ast.dump(ast.parse(fault.text))
        assert fault.old != fault.new
        assert " ".join(text.splitlines()[fault.line - 1].split()) in fault.old


def test_code_of_a_gpu_is_another_lane():
    assert group_of("izo_ref/certificate/certify.py") == "certificate"
    assert group_of("izo_ref/solvers/serial/directions/newton.py") == "solvers"
    assert group_of("izo_ref/zones/gpu_grouping.py") == ""
    assert group_of("izo_ref/zones/cuda/grouping.py") == ""
    assert group_of("izo_ref/app/cli.py") == ""


@pytest.mark.parametrize("one", SURVIVORS, ids=lambda one: f"{one.file}:{one.where}")
def test_the_line_of_each_survivor_is_still_there(one):
    text = " ".join((ROOT / one.file).read_text().split())
    assert one.old in text
    assert one.old != one.new
    assert one.reason.endswith(".")


def test_no_survivor_has_two_reasons():
    assert len({one[:4] for one in SURVIVORS}) == len(SURVIVORS)
    assert all(group_of(one.file) for one in SURVIVORS)


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """Return a small repository in pure Python, of one group with one file."""
    source = (
        "LIMIT = 0\n\n\ndef larger(a, b):\n    return max(a, b)\n\n\n"
        "def is_large(a):\n    return a > LIMIT\n"
    )
    tests = (
        "from izo_ref.zones.sums import is_large, larger\n\n\n"
        "def test_larger():\n    assert larger(1, 2) == 2\n\n\n"
        "def test_is_large():\n    assert is_large(5)\n    assert not is_large(-5)\n"
    )
    files = {
        "izo_ref/__init__.py": "",
        "izo_ref/base/compile.py": "",
        "izo_ref/zones/__init__.py": "",
        "izo_ref/zones/sums.py": source,
        "tests/__init__.py": "",
        "tests/zones/__init__.py": "",
        "tests/zones/test_sums.py": tests,
        "validation/__init__.py": "",
        "validation/mutants/__init__.py": "",
        "validation/mutants/reach.py": (ROOT / "validation/mutants/reach.py").read_text(),
        "validation/mutants/chosen.py": (ROOT / "validation/mutants/chosen.py").read_text(),
    }
    for name, text in files.items():
        path = tmp_path / "repository" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    # a dozen processes of pytest are started, and its plugins are half of their start
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    return tmp_path / "repository"


def test_the_runner_tells_caught_from_survived_and_resumes(repository, tmp_path, capsys):
    path, made = tmp_path / random_mutants.FILE, made_by("test")
    rows = random_run.run_random(99, 1, path, made, root=repository, deep=False)
    by_new = {row["new"]: row for row in rows}
    assert by_new["return a"]["by"] == "tests/zones/test_sums.py::test_larger"
    assert by_new["return min(a, b)"]["caught"]
    assert not by_new["return b"]["caught"]
    assert by_new["return a >= LIMIT"]["stage"] == random_run.TESTS
    assert by_new["return a < LIMIT"]["by"] == "tests/zones/test_sums.py::test_is_large"
    assert json_rows.load(path).rows == rows
    capsys.readouterr()
    assert random_run.run_random(99, 1, path, made, root=repository, deep=False) == rows
    assert capsys.readouterr().out == ""
    # a test that notices a survivor is tried on it alone, as on all survivors
    with (repository / "tests/zones/test_sums.py").open("a") as file:
        file.write("\n\ndef test_left():\n    assert larger(2, 1) == 2\n")
    again = random_run.run_random(99, 1, path, made, root=repository, deep=False)
    assert {row["new"]: row for row in again}["return b"]["caught"]
    said = capsys.readouterr().out
    assert "caught by tests/zones/test_sums.py::test_left" in said
    assert "min, max swapped" not in said
    text = random_mutants.page(tmp_path, tmp_path).read_text()
    assert f"| all | {len(again)} |" in text
    (headline,) = random_mutants.headlines(tmp_path)
    caught = sum(row["caught"] for row in again)
    assert headline.figure.startswith(f"{caught} of {len(again)} ")


def test_a_test_knows_what_it_enters(repository, tmp_path):
    tests = reached.watch_tests(repository, tmp_path / "notes")
    assert {(test.name.split("::")[1], test.passed) for test in tests} == {
        ("test_larger", True),
        ("test_is_large", True),
    }
    (one,) = [test for test in tests if "zones/sums.py:larger" in test.entered]
    assert one.name == "tests/zones/test_sums.py::test_larger"
    assert reached.users_of(repository, ["LIMIT"]) == {"zones/sums.py:is_large"}

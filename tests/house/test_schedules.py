"""Every kernel and every text whose threads share memory is run with its accesses logged.

A *text* is a function that gets a thread group from a kernel. It needs a test file that imports it,
and `Log` of `tests/helpers/logged.py`, and that asks for conflicts and for waits that nobody needs.
A kernel that waits, uses shared memory or uses its thread group itself needs an entry in `RUNS` of
`tests/simulated/test_schedules.py`.
"""

import ast
from functools import cache
from pathlib import Path

import pytest

from validation import house

PACKAGE, TESTS = house.ROOT / "izo_ref", house.ROOT / "tests"
GROUPS = PACKAGE / "base" / "cuda" / "thread_group.py"  # makes the groups; tested by itself
TEXTS_OF_GROUPS = "izo_ref.base.serial.thread_group"
MAKERS = {"block", "grid"}  # functions that return the thread group of a kernel


@cache
def tree_of(path):
    """Return the syntax tree of a file."""
    return ast.parse(path.read_text())


def functions_of(tree):
    """Return `{name: node}` of the functions of a module."""
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def imported(tree):
    """Return `{name: module}` of what a module imports by name."""
    return {
        alias.asname or alias.name: node.module
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def called(node):
    """Return the names of the functions that a function calls."""
    calls = [inner.func for inner in ast.walk(node) if isinstance(inner, ast.Call)]
    return {func.id for func in calls if isinstance(func, ast.Name)}


def shares_memory(node):
    """Return whether a function waits for other threads or uses shared memory, by itself."""
    chains = [ast.unparse(inner) for inner in ast.walk(node) if isinstance(inner, ast.Attribute)]
    return any(
        chain.endswith((".syncthreads", "shared.array", "this_grid", ".syncwarp"))
        for chain in chains
    )


def uses_group(node):
    """Return whether a function calls a method of a thread group, or sums over it."""
    methods = {"wait", "sums", "maxima", "add", "least"}
    chains = {ast.unparse(inner) for inner in ast.walk(node) if isinstance(inner, ast.Attribute)}
    return any(f"group.{name}" in chains for name in methods) or any(
        name.startswith("group_") and name in functions_of(tree_of(path_of(TEXTS_OF_GROUPS)))
        for name in called(node)
    )


def path_of(module):
    """Return the file of a module of the package."""
    return house.ROOT / Path(*module.split(".")).with_suffix(".py")


def is_kernel(node):
    """Return whether a function is a kernel of a GPU."""
    return any(getattr(d, "id", "") == "cuda_kernel" for d in node.decorator_list)


def kernels_that_share(tree):
    """Return the names of the kernels of a module that need an entry in RUNS."""
    functions = functions_of(tree)
    own = {name for name, node in functions.items() if shares_memory(node) or uses_group(node)}
    while True:
        more = {name for name, node in functions.items() if called(node) & own} - own
        if not more:
            return {name for name in own if is_kernel(functions[name])}
        own |= more


def texts_of(tree):
    """Return (module, name) of the texts that get a thread group from a kernel of a module."""
    modules, found = imported(tree), set()
    for node in tree.body:
        if not (isinstance(node, ast.FunctionDef) and called(node) & MAKERS):
            continue
        for name in called(node) & modules.keys():
            module = modules[name]
            is_text = module.startswith("izo_ref.") and module != TEXTS_OF_GROUPS
            if is_text and takes_group(functions_of(tree_of(path_of(module))).get(name)):
                found.add((module, name))
    return found


def takes_group(node):
    """Return whether a function has a parameter that is a thread group."""
    arguments = node.args.args if node is not None else ()
    return any(
        argument.annotation is not None and ast.unparse(argument.annotation) == "ThreadGroup"
        for argument in arguments
    )


def files_with_kernels():
    """Yield the files with kernels, but for the one that makes thread groups."""
    yield from (path for path in sorted(PACKAGE.glob("*/cuda/*.py")) if path != GROUPS)


def all_texts():
    """Return all texts, sorted."""
    return sorted(set().union(*(texts_of(tree_of(path)) for path in files_with_kernels())))


def all_kernels():
    """Return the names of all kernels that need an entry in RUNS, as `stage.file.kernel`."""
    return {
        f"{path.parts[-3]}.{path.stem}.{name}"
        for path in files_with_kernels()
        for name in kernels_that_share(tree_of(path))
    }


def files_that_log(module, name, files):
    """Return the test files that log the accesses of a text, and ask for needless waits."""
    found = []
    for path, text in files.items():
        own = imported(ast.parse(text))
        asks = "conflicts(" in text and ".sites" in text
        if own.get(name) == module and own.get("Log") == "tests.helpers.logged" and asks:
            found.append(path)
    return found


def test_the_texts_are_found():
    names = {name for _, name in all_texts()}
    assert {"group_pivot", "minimise_zone"} <= names


@pytest.mark.parametrize(("module", "name"), all_texts())
def test_texts_of_thread_groups_are_run_with_their_accesses_logged(module, name):
    files = {path: path.read_text() for path in TESTS.rglob("test_*.py")}
    assert files_that_log(module, name, files), f"{module}.{name} has no test with a Log"


def test_kernels_that_share_memory_are_run_in_random_schedules():
    tree = tree_of(TESTS / "simulated" / "test_schedules.py")
    (runs,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "RUNS"
    )
    listed = {key.value for key in runs.keys}
    assert sorted(all_kernels() - listed) == [], "these need an entry in RUNS"
    assert sorted(listed - all_kernels()) == [], "these are no such kernels any more"


KERNELS = """
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.solvers.serial.group_pivot import group_pivot
from izo_ref.base.serial.thread_group import group_sum

@device_function
def shares():
    cuda.syncthreads()

@device_function
def passes_on():
    shares()

@cuda_kernel
def first():
    passes_on()

@cuda_kernel
def second():
    cuda.shared.array(3, float)

@cuda_kernel
def third(parts):
    group = grid(parts)
    group_sum(group, 1.0)

@cuda_kernel
def fourth():
    group_pivot(block(), 1)

@cuda_kernel
def fifth():
    group = block()
    group.wait()

@cuda_kernel
def sixth():
    cuda.grid(1)
"""


def test_kernels_that_share_memory_are_found():
    tree = ast.parse(KERNELS)
    assert kernels_that_share(tree) == {"first", "second", "third", "fifth"}
    assert texts_of(tree) == {("izo_ref.solvers.serial.group_pivot", "group_pivot")}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("import group_pivot", "import factorize"),
        ("tests.helpers.logged", "tests.helpers.dips"),
        ("conflicts(", "print("),
        (".sites", ".accesses"),
    ],
)
def test_a_text_without_its_test_is_noticed(old, new):
    path = TESTS / "simulated" / "test_group_pivot.py"
    files = {path: path.read_text().replace(old, new)} if old else {path: path.read_text()}
    found = files_that_log("izo_ref.solvers.serial.group_pivot", "group_pivot", files)
    assert bool(found) == (old == "")

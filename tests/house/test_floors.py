"""Imports point down: between the stages, and inside each of them."""

import ast
from pathlib import Path

import pytest

from validation import house

README = house.ROOT / "README.md"
PACKAGE = house.ROOT / "izo_ref"
SOURCES = sorted(PACKAGE.rglob("*.py"))
# Floors inside a stage. Kernels of one target never import those of the other: see below.
INNER_FLOOR = {"formulas": 0, "serial": 1, "cpu": 2, "cuda": 2}
HOST_FLOOR = 3


def inner_floor(module):
    """Return the floor of a module inside its stage.

    The files of the host are above the folders of the stage. In `base`, the plain files are
    below the folders.
    """
    parts = module.split(".")
    if len(parts) > 3:
        return INNER_FLOOR.get(parts[2], HOST_FLOOR)
    is_ground = parts[1] == "base" and not parts[-1].startswith("gpu_")
    return -1 if is_ground else HOST_FLOOR


def test_stages_do_not_import_each_other_in_a_circle():
    floor_of = house.floors(house.arrows())  # raises if there is one
    assert floor_of["base"] == 1
    assert floor_of["app"] == max(floor_of.values())


def test_folders_of_validation_do_not_import_each_other_in_a_circle():
    floor_of = house.floors(house.arrows(package="validation"))
    assert floor_of["__main__"] == max(floor_of.values())
    assert floor_of["oracles"] == 1


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_inside_a_stage_point_down(path):
    own = next(module for module, file in house.module_paths().items() if file == path)
    for importer, imported, line in house.imports():
        if importer != own or house.room_of(imported) != house.room_of(own):
            continue
        if house.NAMED.search(path.read_text().splitlines()[line - 1]):
            continue  # the name of a GPU implementation, which is imported when it is used
        assert inner_floor(imported) <= inner_floor(importer), f"{path}:{line}: {imported}"


def test_modules_do_not_import_each_other_in_a_circle():
    graph = {module: set() for module in house.module_paths() if module != "izo_ref"}
    for importer, imported, _ in house.imports():
        graph[importer].add(imported)
    house.floors({module: below - {"izo_ref"} for module, below in graph.items()})


def test_the_picture_in_the_readme_is_what_the_imports_say():
    text = README.read_text()
    assert text == house.with_picture(text), "run: python -m validation house --write"


def test_each_folder_of_the_package_has_a_docstring():
    for path in PACKAGE.rglob("__init__.py"):
        assert ast.get_docstring(ast.parse(path.read_text())), path


def test_named_gpu_implementations_exist():
    found = 0
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            named = isinstance(node, ast.Constant) and house.NAMED.fullmatch(str(node.value))
            if not named:
                continue
            file = house.ROOT / Path(*named[1].split(".")).with_suffix(".py")
            defined = {getattr(thing, "name", "") for thing in ast.parse(file.read_text()).body}
            assert named[2] in defined, f"{path}: {node.value}"
            found += 1
    assert found >= 4


def is_of_a_gpu(module):
    """Return whether a module needs a GPU."""
    return ".cuda" in module or module.split(".")[-1].startswith("gpu_")


def test_gpu_modules_are_imported_through_devices_alone():
    """Files of the CPU name implementations of a GPU; `base/devices.py` imports them."""
    for importer, imported, line in house.imports():
        path = house.module_paths()[importer]
        source = path.read_text().splitlines()[line - 1]
        if is_of_a_gpu(imported) and not is_of_a_gpu(importer):
            assert house.NAMED.search(source), f"{path}:{line} imports {imported}"
    for path in SOURCES:
        module = "izo_ref." + ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        if is_of_a_gpu(module) or path == PACKAGE / "base" / "devices.py":
            continue
        assert "from numba import cuda" not in path.read_text(), path
        assert "numba.cuda" not in _imported(path), path


def _imported(path):
    """Return the names of the modules that a file imports from."""
    nodes = ast.walk(ast.parse(path.read_text()))
    return {getattr(node, "module", None) or "" for node in nodes}


def test_kernels_of_one_target_do_not_import_the_other():
    for importer, imported, line in house.imports():
        if ".cpu." in importer:
            assert ".cuda." not in imported, f"{importer}:{line}"
        if ".cuda." in importer:
            assert ".cpu." not in imported, f"{importer}:{line}"


def test_the_package_imports_neither_tests_nor_validation():
    for path in SOURCES:
        assert not any(name.startswith(("validation", "tests")) for name in _imported(path)), path


def test_oracles_import_nothing_of_the_package():
    oracles = [*(house.ROOT / "tests/naive").glob("*.py")]
    oracles += (house.ROOT / "validation/oracles").glob("*.py")
    assert len(oracles) > 10
    for path in oracles:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in getattr(node, "names", [])]
            names.append(getattr(node, "module", None) or "")
            assert not any(str(name).startswith("izo_ref") for name in names), path


def test_tests_import_helpers_and_no_other_tests():
    for path in (house.ROOT / "tests").rglob("*.py"):
        for name in _imported(path):
            if name.startswith("tests"):
                assert name.startswith(("tests.helpers", "tests.naive", "tests.ports")), (
                    f"{path}: {name}"
                )

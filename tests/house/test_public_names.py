"""The public names, and what importing and installing the package needs."""

import ast
import inspect
import subprocess
import sys
import tomllib

import izo_ref
from validation import house

PACKAGE = house.ROOT / "izo_ref"


def test_import_needs_numpy_and_numba_alone():
    code = (
        # numba itself may import scipy
        "import sys, numba; before = {m.split('.')[0] for m in sys.modules}; import izo_ref;"
        "new = {m.split('.')[0] for m in sys.modules} - before - set(sys.stdlib_module_names);"
        "print(sorted(new))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "['izo_ref']"


def test_every_public_name_has_a_docstring():
    for name in izo_ref.__all__:
        thing = getattr(izo_ref, name)
        if inspect.isfunction(thing) or inspect.isclass(thing):
            assert thing.__doc__, name
            assert not thing.__doc__.startswith(name + "("), name  # generated for a NamedTuple


def test_every_folder_of_the_package_is_installed():
    settings = tomllib.loads((house.ROOT / "pyproject.toml").read_text())
    folders = {path.parent.relative_to(house.ROOT) for path in PACKAGE.rglob("__init__.py")}
    names = {".".join(folder.parts) for folder in folders}
    elsewhere = settings["tool"]["setuptools"]["package-dir"]  # data, without any module
    assert all((house.ROOT / path).is_dir() for path in elsewhere.values())
    assert sorted(settings["tool"]["setuptools"]["packages"]) == sorted(names | elsewhere.keys())


def test_the_type_checker_sees_the_names_that_are_imported_when_they_are_used():
    tree = ast.parse((PACKAGE / "__init__.py").read_text())
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.name: str(node.module).removeprefix("izo_ref.")
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == izo_ref._MODULE_OF
    assert sorted([*seen, "__version__"]) == sorted(izo_ref.__all__)

"""Rules of the house that a program can check."""

import ast
import inspect
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "izo_ref"
FLOORS = [
    {"_jit", "types", "errors", "options", "version"},
    {"scalar", "serial", "checks", "exact", "exact_path", "ranges", "tally"},
    {"cpu", "cuda"},
    {
        "gpu",
        "broad",
        "devices",
        "detect",
        "parts",
        "intersections",
        "scene",
        "selection",
        "zones",
        "problem",
        "solve",
        "step",
        "interior_point",
        "pivoting",
        "large_zone",
        "descent",
        "methods",
        "rows",
        "sparse",
        "sweep",
        "certify",
        "distance",
        "numbering",
        "io",
        "picture",
    },
    {"loop", "fallback", "resolving", "planning", "summary", "demo", "cache"},
    {"cli", "__init__"},
]
SOURCES = sorted(PACKAGE.rglob("*.py"))


def part_of(path):
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return parts[0]


def floor_of(part):
    return next(i for i, floor in enumerate(FLOORS) if part in floor)


def imports_of(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("izo_ref"):
            names = node.module.split(".")[1:]
            yield from ([names[0]] if names else [alias.name for alias in node.names])


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_down(path):
    own = floor_of(part_of(path))
    for part in imports_of(path):
        assert floor_of(part) <= own, f"{path} is on floor {own} and imports {part}"


def test_imports_have_no_circle():
    names = {".".join(p.relative_to(PACKAGE).with_suffix("").parts): p for p in SOURCES}
    graph = {}
    for name, path in names.items():
        modules = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("izo_ref"):
                inner = ".".join(node.module.split(".")[1:])
                prefix = f"{inner}." if inner else ""
                submodules = {prefix + alias.name for alias in node.names} & set(names)
                modules |= submodules or ({inner} if inner else set())
        graph[name] = modules
    done = set()
    while graph:
        ready = {name for name, modules in graph.items() if modules <= done}
        assert ready, f"circle among {sorted(graph)}"
        done |= ready
        graph = {name: modules for name, modules in graph.items() if name not in ready}


def test_oracles_import_nothing_of_the_package():
    oracles = [
        *(ROOT / "tests" / "naive").glob("*.py"),
        *(ROOT / "validation/oracles").glob("*.py"),
    ]
    assert len(oracles) > 10
    for path in oracles:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in getattr(node, "names", [])]
            names.append(getattr(node, "module", None) or "")
            assert not any(str(name).startswith("izo_ref") for name in names), path


def test_the_package_does_not_need_the_evidence():
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            module = getattr(node, "module", None) or ""
            assert not module.startswith(("validation", "tests")), path


def test_import_needs_numpy_and_numba_alone():
    code = (
        # numba looks for scipy by itself
        "import sys, numba; before = {m.split('.')[0] for m in sys.modules}; import izo_ref;"
        "new = {m.split('.')[0] for m in sys.modules} - before - set(sys.stdlib_module_names);"
        "print(sorted(new))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "['izo_ref']"


DECORATORS = ("cpu_kernel", "light_kernel", "cuda_kernel")


def kernels_of(target):
    """(file, source, node) of each kernel."""
    for path in sorted((PACKAGE / target).glob("*.py")):
        text = path.read_text()
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and any(
                getattr(d, "id", "") in DECORATORS for d in node.decorator_list
            ):
                yield path.name, ast.get_source_segment(text, node), node


def kernels():
    for target in ("cpu", "cuda"):
        for file, source, node in kernels_of(target):
            yield pytest.param(source, node, id=f"{target}/{file}-{node.name}")


@pytest.mark.parametrize(("source", "node"), list(kernels()))
def test_kernels_state_their_contract(source, node):
    names = [argument.arg for argument in node.args.args]
    signature = source[: source.index("\n):")]
    inputs, marked, outputs = signature.partition("# Out:")
    assert "# In:" in inputs, "inputs come first"
    assert marked, "then outputs"
    written = {
        target.value.id
        for inner in ast.walk(node)
        for target in getattr(inner, "targets", [getattr(inner, "target", None)])
        if isinstance(target, ast.Subscript) and isinstance(target.value, ast.Name)
    } - {  # shared memory, which a kernel makes itself
        target.id
        for inner in ast.walk(node)
        if isinstance(inner, ast.Assign) and isinstance(inner.value, ast.Call)
        for target in inner.targets
        if isinstance(target, ast.Name)
    }
    assert all(name.endswith("_out") for name in written), written
    for name in names:
        assert f"    {name},  # " in signature, f"{name} has no shape, type or unit"
        assert name.endswith("_out") == (f"    {name}," in outputs)


# what one target has in one launch, and the other not, is none
TWINS = {
    "certain_meetings",
    "closest_frames",
    "find_contacts",
    "find_pairs",
    "morton_codes",
    "scaled_rows",
    "solve_lagrangian",
    "solve_small_zones",
}


def test_twins_have_the_same_contract():
    def contracts(target):
        return {
            (file, node.name): source[: source.index("\n):")].split("\n", 1)[1]
            for file, source, node in kernels_of(target)
        }

    on_cpu, on_gpu = contracts("cpu"), contracts("cuda")
    shared = on_cpu.keys() & on_gpu.keys()
    assert {name for _, name in shared} == TWINS
    for name in shared:
        assert on_cpu[name] == on_gpu[name], name
    # a name of one target in another file of the other would be a twin that is not found
    assert not {name for _, name in on_cpu.keys() ^ shared} & {name for _, name in on_gpu}


def test_a_gpu_is_asked_for_where_it_is_used_alone():
    for path in SOURCES:
        if part_of(path) in ("cuda", "gpu"):
            continue
        for node in ast.parse(path.read_text()).body:  # not inside functions
            module = getattr(node, "module", None) or ""
            assert not module.startswith(("izo_ref.cuda", "izo_ref.gpu", "numba.cuda")), path
        assert "from numba import cuda" not in path.read_text(), path
    for path in (PACKAGE / "cpu").glob("*.py"):
        assert "izo_ref.cuda" not in path.read_text(), path
    for path in (PACKAGE / "cuda").glob("*.py"):
        assert "izo_ref.cpu" not in path.read_text(), path


def test_every_public_name_says_what_it_is():
    import izo_ref

    for name in izo_ref.__all__:
        thing = getattr(izo_ref, name)
        if inspect.isfunction(thing) or inspect.isclass(thing):
            assert thing.__doc__, name
            assert not thing.__doc__.startswith(name + "("), name  # what a NamedTuple makes up


def test_every_folder_of_the_package_is_installed():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    folders = {path.parent.relative_to(ROOT) for path in PACKAGE.rglob("__init__.py")}
    names = sorted(".".join(folder.parts) for folder in folders)
    assert sorted(settings["tool"]["setuptools"]["packages"]) == names

"""Kernels keep the rules that a program can check."""

import ast
import re

import pytest

from validation import house

PACKAGE = house.ROOT / "izo_ref"
DECORATORS = ("cpu_kernel", "light_kernel", "cuda_kernel")


def kernels_of(target):
    """Yield (file, source, node) of each kernel of a target, `cpu` or `cuda`."""
    for path in sorted(PACKAGE.glob(f"*/{target}/*.py")):
        text = path.read_text()
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and any(
                getattr(d, "id", "") in DECORATORS for d in node.decorator_list
            ):
                yield f"{path.parts[-3]}/{path.name}", ast.get_source_segment(text, node), node


def kernels():
    """Yield a case for each kernel of both targets."""
    for target in ("cpu", "cuda"):
        for file, source, node in kernels_of(target):
            yield pytest.param(source, node, id=f"{target}/{file}-{node.name}")


@pytest.mark.parametrize(("source", "node"), list(kernels()))
def test_kernels_state_their_contract(source, node):
    names = [argument.arg for argument in node.args.args]
    signature = source[: source.index("\n) -> None:")]
    inputs, marked, outputs = signature.partition("# Out:")
    assert "# In:" in inputs, "inputs come first"
    assert marked, "then outputs"
    written = {
        target.value.id
        for inner in ast.walk(node)
        for target in getattr(inner, "targets", [getattr(inner, "target", None)])
        if isinstance(target, ast.Subscript) and isinstance(target.value, ast.Name)
    } - {  # shared memory, which the kernel allocates itself
        target.id
        for inner in ast.walk(node)
        if isinstance(inner, ast.Assign) and isinstance(inner.value, ast.Call)
        for target in inner.targets
        if isinstance(target, ast.Name)
    }
    assert all(name.endswith("_out") for name in written), written
    for name in names:
        stated = re.compile(rf"^    {name}(: [\w.]+)?,  # ", re.M)
        assert stated.search(signature), f"{name} has no shape, type or unit"
        assert name.endswith("_out") == bool(stated.search(outputs))


# Work that is one launch on one target and several on the other has no twins.
TWINS = {
    "decide_meetings",
    "compute_closest_frames",
    "find_contacts",
    "find_pairs",
    "compute_morton_codes",
    "scale_constraints",
    "solve_lagrangian",
    "solve_small_zones",
}


def test_twins_have_the_same_contract():
    def contracts(target):
        """Return {(file, name): parameters and comments} of all kernels."""
        return {
            (file, node.name): source[: source.index("\n) -> None:")].split("\n", 1)[1]
            for file, source, node in kernels_of(target)
        }

    on_cpu, on_gpu = contracts("cpu"), contracts("cuda")
    shared = on_cpu.keys() & on_gpu.keys()
    assert {name for _, name in shared} == TWINS
    for name in shared:
        assert on_cpu[name] == on_gpu[name], name
    # A kernel of the same name in another file would be a twin that this test does not compare.
    assert not {name for _, name in on_cpu.keys() ^ shared} & {name for _, name in on_gpu}

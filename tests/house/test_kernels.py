"""Kernels keep the rules that a program can check."""

import ast
import re
import textwrap

import pytest

from validation import house

PACKAGE = house.ROOT / "izo_ref"
DECORATORS = ("cpu_kernel", "light_kernel", "cuda_kernel")
# How the comment behind a parameter begins: with the shape of an array and its dtype, with the
# dtype of a scalar, or with the name of a record.
STATED = r"(?:\(.*?\) )?(?:[fiub][1248]\b|[A-Z]\w+)"


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


def signature_of(source):
    """Return the lines of a kernel from `def` to its last parameter."""
    signature, marked, _ = source.partition("\n) -> None:")
    assert marked, "the line after the last parameter is `) -> None:`"
    return signature


def check_contract(source, node):
    """Check that a kernel states its contract, and that its outputs are named as such."""
    names = [argument.arg for argument in node.args.args]
    shared = any(getattr(d, "id", "") == "cpu_kernel" for d in node.decorator_list)
    assert ("# Share:" in signature_of(source)) == shared, "threads share this kernel, or not"
    assert (names[:2] == ["begin", "end"]) == shared, "the share comes first"
    inputs, marked, outputs = signature_of(source).partition("# Out:")
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
        stated = re.compile(rf"^    {name}: [\w.]+,  # {STATED}", re.M)
        assert stated.search(inputs + outputs), f"{name} has no annotation, shape or dtype"
        assert name.endswith("_out") == bool(stated.search(outputs))
    assert ast.get_docstring(node), "says what it does"


@pytest.mark.parametrize(("source", "node"), list(kernels()))
def test_kernels_state_their_contract(source, node):
    check_contract(source, node)


def test_the_example_for_contributors_states_its_contract():
    text = (house.ROOT / "CONTRIBUTING.md").read_text()
    blocks = re.findall(r"^(        @cuda_kernel\n(?:        .*\n|\n)+)", text, re.M)
    assert len(blocks) == 1
    source = textwrap.dedent(blocks[0]).strip()
    (node,) = ast.parse(source).body
    check_contract(source, node)


ADD = (
    "@cpu_kernel\ndef add(\n    # Share:\n    begin: int,  # i8\n    end: int,  # i8\n"
    "    # In:\n    a: float,  # f8\n    # Out:\n    b_out: Floats,  # (n,) f8\n"
    ') -> None:\n    """Add."""\n    b_out[0] = a\n'
)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("@cpu_kernel\n", "@light_kernel\n", "or not"),
        ("    # Share:\n", "", "or not"),
        ("    begin: int,  # i8\n    end: int,  # i8\n", "", "comes first"),
        (") -> None:", "):", "-> None"),
        ("# In:", "", "inputs come first"),
        ("b_out", "b", "{'b'}"),
        ("a: float,  # f8", "a,  # f8", "a has no annotation"),
        ("# f8", "# a number", "a has no"),
        ('    """Add."""\n', "", "says what it does"),
    ],
)
def test_a_kernel_without_its_contract_is_noticed(old, new, says):
    check_contract(ADD, ast.parse(ADD).body[0])
    assert old in ADD
    wrong = ADD.replace(old, new)
    with pytest.raises(AssertionError, match=says):
        check_contract(wrong, ast.parse(wrong).body[0])


# Work that is one launch on one target and several on the other has no twins.
TWINS = {
    "decide_meetings",
    "renew_tight_frames",
    "solve_lagrangian",
}


def test_twins_have_the_same_contract():
    def contracts(target):
        """Return {(file, name): parameters and comments} of all kernels, without the share."""
        return {
            (file, node.name): signature_of(source).partition("# In:")[2]
            for file, source, node in kernels_of(target)
        }

    on_cpu, on_gpu = contracts("cpu"), contracts("cuda")
    shared = on_cpu.keys() & on_gpu.keys()
    assert {name for _, name in shared} == TWINS
    for name in shared:
        assert on_cpu[name] == on_gpu[name], name
    # A kernel of the same name in another file would be a twin that this test does not compare.
    assert not {name for _, name in on_cpu.keys() ^ shared} & {name for _, name in on_gpu}

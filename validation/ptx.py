"""Compile every CUDA kernel to PTX and to machine code by ptxas; this needs no GPU.

The types of a kernel are read from its contract, which is the comment behind each parameter. A
kernel that compiles for its contract has consistent types, and ptxas reports how many registers and
how much memory it needs.
"""

import inspect
import re
import subprocess
import tempfile
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, TypeAlias
from unittest.mock import patch

import izo_ref
from izo_ref.base.cuda.compile import Kernel
from izo_ref.base.records import Impacts
from izo_ref.detection.serial.records import ContactList, PathArrays, SortSpace
from izo_ref.detection.serial.tree import Tree
from izo_ref.solvers.serial.records import Inputs, Results, WorkSpace
from izo_ref.solvers.serial.settings import Settings
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows
from izo_ref.zones.serial.group_records import (
    GroupWork,
    SelectionWork,
    StepArrays,
    VertexLabels,
    ZoneRule,
)
from izo_ref.zones.serial.listed_zones import ListedZones

CAPABILITIES = ((8, 0), (8, 9), (9, 0), (10, 0))  # of the study
TESTED = (
    CAPABILITIES[0],
    CAPABILITIES[-1],
)  # the oldest and the newest; each takes 70 s of CPU time
DTYPES = {"f8": "float64", "f4": "float32", "i8": "int64", "i4": "int32", "i1": "int8"} | {
    "u1": "uint8",
    "u4": "uint32",
    "u8": "uint64",
    "b1": "boolean",
}
OF_DETECTION = (Impacts, ContactList, PathArrays, SortSpace)
OF_GROUPS = (GroupWork, SelectionWork, StepArrays, VertexLabels, ZoneRule)
OF_ZONES = (ListedZones, ZoneRows, ZoneAnswers)
OF_SOLVERS = (Settings, Limits, Inputs, Results, WorkSpace)
RECORDS = {
    record.__name__: record for record in (Tree, *OF_DETECTION, *OF_GROUPS, *OF_ZONES, *OF_SOLVERS)
}
# Kernels with a stack frame, and the reason for it.
WAITS_BY_CALLS = (
    "it waits for all blocks by calls into the CUDA runtime, and more values live across such a "
    "call than there are registers; the cost is not measured yet"
)
FRAMES = {
    "solvers.lagrangian.solve_lagrangian_by_grid": WAITS_BY_CALLS,
    "solvers.listed_zones.solve_list_by_grid": WAITS_BY_CALLS,
}
# A parameter, and the comment behind it: the shape if it is an array, and then the types in which
# it may come; or the name of a record, and the types of those fields that offer a choice.
PARAMETER = re.compile(
    r"^    (\w+)(?:: [\w.]+)?,  # (?:\((.*?)\) )?(?:([A-Z]\w*)\b(?: in )?)?(\w+(?: or \w+)*)?", re.M
)
# A field of a record, and the comment behind it: the shape if it is an array, and the types.
FIELD = re.compile(r"^    \w+: ([\w.]+)(?:  # \((.*?)\) (\w+(?: or \w+)*))?", re.M)
# An instruction of PTX, which may have a condition, and those of a float type that compute nothing.
INSTRUCTION = re.compile(r"\s+(?:@!?%\w+\s+)?([a-z][\w.]*)\s.*;")
NOT_COMPUTED = ("mov", "ld", "st")
SCALARS = {"int": "i8", "float": "f8", "bool": "b1"}
NumbaType: TypeAlias = Any  # numba has no annotations for its types


class Built(NamedTuple):
    """The resources of a kernel, as ptxas reports them."""

    registers: int  # of one thread
    shared_bytes: int  # of one block, fixed when the kernel is compiled
    stack_bytes: int  # of one thread
    spilled_bytes: int  # of one thread, stores and loads together


def kernels() -> Iterator[tuple[str, Kernel]]:
    """Yield the name of each kernel, such as `detection.tree.path_boxes`, and the kernel."""
    package = Path(izo_ref.__file__).parent
    for path in sorted(package.glob("*/cuda/[a-z]*.py")):
        stage = path.parts[-3]
        module = import_module(f"izo_ref.{stage}.cuda.{path.stem}")
        for name, thing in vars(module).items():
            if isinstance(thing, Kernel) and thing.function.__module__ == module.__name__:
                yield f"{stage}.{path.stem}.{name}", thing


def signatures(kernel: Kernel) -> dict[str, tuple[NumbaType, ...]]:
    """Return the signatures of a kernel, read from its contract.

    A contract may offer a choice of types, such as `f8 or f4`, for some of its parameters. All
    these parameters must then offer the same choice.

    Args:
        kernel: The kernel.

    Returns:
        `{choice: types of all parameters}`; the choice is empty if the contract offers none.

    Raises:
        ValueError: The contract does not fit the parameters, or offers different choices.
    """
    found = PARAMETER.findall(inspect.getsource(kernel.function))
    names = [name for name, *_ in found]
    expected = list(inspect.signature(kernel.function).parameters)
    if names != expected:
        raise ValueError(f"contract: expected parameters {expected}, got {names}")
    choices = {kinds for *_, kinds in found if " or " in kinds} or {""}
    if len(choices) > 1:
        raise ValueError(f"contract: expected the same choice of types, got {sorted(choices)}")
    return {
        choice: tuple(
            _type(shape, record, choice if " or " in kinds else kinds)
            for _, shape, record, kinds in found
        )
        for choice in choices.pop().split(" or ")
    }


def _type(shape: str, record: str, kind: str) -> NumbaType:
    """Return the type of a parameter of a shape and a dtype, or of a record.

    Args:
        shape: The shape, or an empty string.
        record: The name of a record, or an empty string.
        kind: The dtype; of a record, the dtype of the fields that offer a choice.
    """
    if not record:
        return _array(shape, kind)
    from numba import types

    members = []
    for own, axes, kinds in FIELD.findall(inspect.getsource(RECORDS[record])):
        if " or " in kinds:
            if kind not in kinds.split(" or "):
                raise ValueError(f"{record}: expected one of {kinds}, got {kind!r}")
            members.append(_array(axes, kind))
        else:
            members.append(_array(axes, kinds or SCALARS[own]))
    return types.BaseTuple.from_types(tuple(members), RECORDS[record])


def _array(shape: str, kind: str) -> NumbaType:
    """Return the type of an array, or of a scalar if the shape is empty."""
    from numba import types

    scalar = getattr(types, DTYPES[kind])
    n_axes = len([axis for axis in shape.split(",") if axis.strip()])
    return types.Array(scalar, n_axes, "C") if n_axes else scalar


def build(kernel: Kernel, signature: tuple[NumbaType, ...], capability: tuple[int, int]) -> Built:
    """Compile a kernel for a compute capability.

    Args:
        kernel: The kernel.
        signature: Types of its parameters, as `signatures` returns them.
        capability: Major and minor number.

    Returns:
        What ptxas reports.

    Raises:
        RuntimeError: ptxas is not installed or fails; the message holds its output.
    """
    program = ptxas()
    if program is None:
        raise RuntimeError("ptxas: the package nvidia-cuda-nvcc is not installed")

    ptx = _ptx_of(kernel, signature, capability)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "kernel.ptx")
        source.write_text(ptx)
        arch = f"-arch=sm_{capability[0]}{capability[1]}"
        # a kernel that waits for all blocks calls the CUDA runtime, which is linked on loading
        whole = [] if ".extern .func" not in ptx else ["-c"]
        command = [program, "-v", *whole, arch, source, "-o", Path(folder, "kernel.cubin")]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"ptxas: {done.stderr}")
    return _report(done.stderr)


def instructions(
    kernel: Kernel, signature: tuple[NumbaType, ...], capability: tuple[int, int]
) -> dict[str, int]:
    """Count the instructions of a kernel in PTX that compute in float32 and in float64.

    Moves and constants do not count, loads and stores neither. An instruction in a loop counts
    once.

    Returns:
        The numbers of `f32` and `f64`; a conversion counts for both types.
    """
    counts = {"f32": 0, "f64": 0}
    for line in _ptx_of(kernel, signature, capability).splitlines():
        found = INSTRUCTION.match(line)
        if found and found[1].split(".")[0] not in NOT_COMPUTED:
            for kind in counts:
                counts[kind] += kind in found[1].split(".")
    return counts


def _ptx_of(kernel: Kernel, signature: tuple[NumbaType, ...], capability: tuple[int, int]) -> str:
    """Compile a kernel to PTX."""
    from numba import cuda

    gpu = SimpleNamespace(compute_capability=capability)
    with patch("numba.cuda.dispatcher.get_current_device", lambda: gpu):
        # numba-cuda fills the module numba.cuda on import, which the type checker cannot see
        ptx, _ = cuda.compile_ptx(kernel.function, signature, cc=capability)  # pyright: ignore[reportPrivateImportUsage]
    return ptx


def ptxas() -> Path | None:
    """Return the path of ptxas from the package nvidia-cuda-nvcc; None if it is not installed."""
    if find_spec("nvidia") is None:
        return None
    import nvidia

    found = (path for folder in nvidia.__path__ for path in Path(folder).rglob("bin/ptxas"))
    return next(found, None)


def _report(text: str) -> Built:
    """Read the numbers that ptxas prints."""

    def number(pattern: str) -> int:
        return sum(int(value) for value in re.findall(pattern, text))

    return Built(
        registers=number(r"Used (\d+) registers"),
        shared_bytes=number(r"(\d+) bytes smem"),
        stack_bytes=number(r"(\d+) bytes stack frame"),
        spilled_bytes=number(r"(\d+) bytes spill"),
    )

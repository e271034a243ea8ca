"""Every kernel of the device compiled to PTX and through ptxas, which takes no GPU.

A kernel's signature is read from its contract: the comment behind each parameter.
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
from typing import NamedTuple
from unittest.mock import patch

import izo_ref
from izo_ref.base.cuda.compile import Kernel
from izo_ref.detection.serial.tree import Tree
from izo_ref.solvers.serial.descent import Settings
from izo_ref.solvers.serial.small_zone import Limits

CAPABILITIES = ((8, 0), (9, 0), (10, 0))
DTYPES = {"f8": "float64", "f4": "float32", "i8": "int64", "i4": "int32", "i1": "int8"} | {
    "u1": "uint8",
    "u4": "uint32",
    "u8": "uint64",
    "b1": "boolean",
}
RECORDS = {"Tree": Tree, "Settings": Settings, "Limits": Limits}
# Kernels with a stack frame, and why.
FRAMES = {
    "solvers.lagrangian.solve_lagrangian_by_grid": "its waits for all blocks are calls into the "
    "runtime of the device, and more values are kept over a call than there are registers; "
    "the cost is not measured yet",
}
# A parameter, and behind it: shape, if it is an array; types that it comes in; or a record.
PARAMETER = re.compile(r"^    (\w+)(?:: [\w.]+)?,  # (?:\((.*?)\) )?(\w+(?: or \w+)*)", re.M)
FIELD = re.compile(r"^    \w+: ([\w.]+)(?:  # \((.*?)\) (\w+))?", re.M)
SCALARS = {"int": "i8", "float": "f8", "bool": "b1"}


class Built(NamedTuple):
    """What ptxas says of a kernel."""

    registers: int
    shared_bytes: int
    stack_bytes: int
    spilled_bytes: int  # stores and loads


def kernels() -> Iterator[tuple[str, Kernel]]:
    """Name, as `detection.tree.path_boxes`, and kernel."""
    package = Path(izo_ref.__file__).parent
    for path in sorted(package.glob("*/cuda/[a-z]*.py")):
        stage = path.parts[-3]
        module = import_module(f"izo_ref.{stage}.cuda.{path.stem}")
        for name, thing in vars(module).items():
            if isinstance(thing, Kernel) and thing.function.__module__ == module.__name__:
                yield f"{stage}.{path.stem}.{name}", thing


def signatures(kernel) -> dict[str, tuple]:
    """Those of a kernel, of numba's types, by the types that its contract gives a choice of."""
    found = PARAMETER.findall(inspect.getsource(kernel.function))
    names = [name for name, _, _ in found]
    expected = list(inspect.signature(kernel.function).parameters)
    if names != expected:
        raise ValueError(f"contract: expected parameters {expected}, got {names}")
    choices = {kinds for _, _, kinds in found if " or " in kinds} or {""}
    if len(choices) > 1:
        raise ValueError(f"contract: expected the same choice of types, got {sorted(choices)}")
    return {
        choice: tuple(
            _type(shape, choice if " or " in kinds else kinds) for _, shape, kinds in found
        )
        for choice in choices.pop().split(" or ")
    }


def _type(shape, kind):
    if kind in DTYPES:
        return _array(shape, kind)
    from numba import types

    fields = FIELD.findall(inspect.getsource(RECORDS[kind]))
    members = [_array(shape, dtype or SCALARS[own]) for own, shape, dtype in fields]
    return types.NamedTuple(members, RECORDS[kind])


def _array(shape, kind):
    from numba import types

    scalar = getattr(types, DTYPES[kind])
    n_axes = len([axis for axis in shape.split(",") if axis.strip()])
    return types.Array(scalar, n_axes, "C") if n_axes else scalar


def build(kernel, signature, capability) -> Built:
    """Compile for a compute capability.

    Raises:
        RuntimeError: ptxas fails, with what it says.
    """
    from numba import cuda

    device = SimpleNamespace(compute_capability=capability)
    with patch("numba.cuda.dispatcher.get_current_device", lambda: device):
        ptx, _ = cuda.compile_ptx(kernel.function, signature, cc=capability)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "kernel.ptx")
        source.write_text(ptx)
        arch = f"-arch=sm_{capability[0]}{capability[1]}"
        # what waits for all blocks calls the device's runtime, which is linked when it is loaded
        whole = [] if ".extern .func" not in ptx else ["-c"]
        command = [ptxas(), "-v", *whole, arch, source, "-o", Path(folder, "kernel.cubin")]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"ptxas: {done.stderr}")
    return _said(done.stderr)


def ptxas() -> Path | None:
    """Where it is, of the package nvidia-cuda-nvcc; None if that is not installed."""
    if find_spec("nvidia") is None:
        return None
    import nvidia

    found = (path for folder in nvidia.__path__ for path in Path(folder).rglob("bin/ptxas"))
    return next(found, None)


def _said(text):
    def number(pattern):
        return sum(int(value) for value in re.findall(pattern, text))

    return Built(
        registers=number(r"Used (\d+) registers"),
        shared_bytes=number(r"(\d+) bytes smem"),
        stack_bytes=number(r"(\d+) bytes stack frame"),
        spilled_bytes=number(r"(\d+) bytes spill"),
    )

"""Every CUDA kernel compiles for the oldest capability, and its numbers fit into registers.

The slow tests compile for the newest one, too, and the study of CUDA for all of `ptx.CAPABILITIES`:
each takes about 75 s of CPU time, most of it for the four largest kernels.
"""

from importlib.util import find_spec

import pytest

if find_spec("numba_cuda") is None:
    pytest.skip("needs numba-cuda: izo-ref[cuda]", allow_module_level=True)

from tests.helpers.sample import sample
from validation import ptx

if ptx.ptxas() is None:
    pytest.skip("needs ptxas: nvidia-cuda-nvcc", allow_module_level=True)

pytestmark = pytest.mark.first
FRAME_BYTES, SPILLED_BYTES = 512, 4096
CASES = [
    pytest.param(name, kernel, signature, id=f"{name} {types}".strip())
    for name, kernel in ptx.kernels()
    for types, signature in ptx.signatures(kernel).items()
]


@pytest.mark.parametrize("capability", sample(ptx.TESTED, 2, lambda c: f"{c[0]}.{c[1]}"))
@pytest.mark.parametrize(("name", "kernel", "signature"), CASES)
def test_kernels_need_no_memory_of_a_thread(name, kernel, signature, capability):
    built = ptx.build(kernel, signature, capability)
    assert built.registers > 0
    # Kernels in FRAMES have a reason to keep a few hundred numbers of a thread in memory.
    assert built.stack_bytes <= (FRAME_BYTES if name in ptx.FRAMES else 0)
    assert built.spilled_bytes <= (SPILLED_BYTES if name in ptx.FRAMES else 0)


def test_the_filter_computes_nothing_in_float64():
    """On many GPUs one instruction in float64 takes as long as 64 in float32."""
    (kernel,) = (k for name, k in ptx.kernels() if name == "detection.contacts.list_open_pairs")
    (signature,) = ptx.signatures(kernel).values()
    for capability in ptx.TESTED:
        counts = ptx.instructions(kernel, signature, capability)
        assert counts["f64"] == 0
        assert counts["f32"] > 300


# Contracts are read with the indentation of a function at the top level of a module.
def forgetful(
    # In:
    values,  # (n,) f8
    other,
):
    pass


def undecided(
    # In:
    inputs,  # Inputs
):
    pass


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (forgetful, r"expected parameters \['values', 'other'\], got \['values'\]"),
        (undecided, "Inputs: expected one of f8 or f4, got ''"),
    ],
)
def test_a_contract_that_does_not_say_all_types_is_refused(function, message):
    from izo_ref.base.cuda.compile import Kernel

    with pytest.raises(ValueError, match=message):
        ptx.signatures(Kernel(function))

"""Every CUDA kernel compiles for two capabilities, and its numbers fit into registers.

The study of CUDA compiles for all of `ptx.CAPABILITIES`. Three of them took 200 s of CPU time here,
two take 143, most of it for the four largest kernels.
"""

from importlib.util import find_spec

import pytest

if find_spec("numba_cuda") is None:
    pytest.skip("needs numba-cuda: izo-ref[cuda]", allow_module_level=True)

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


@pytest.mark.parametrize("capability", ptx.TESTED, ids=lambda c: f"{c[0]}.{c[1]}")
@pytest.mark.parametrize(("name", "kernel", "signature"), CASES)
def test_kernels_need_no_memory_of_a_thread(name, kernel, signature, capability):
    built = ptx.build(kernel, signature, capability)
    assert built.registers > 0
    # Kernels in FRAMES have a reason to keep a few hundred numbers of a thread in memory.
    assert built.stack_bytes <= (FRAME_BYTES if name in ptx.FRAMES else 0)
    assert built.spilled_bytes <= (SPILLED_BYTES if name in ptx.FRAMES else 0)


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

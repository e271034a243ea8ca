"""Every CUDA kernel compiles for each capability, and its numbers fit into registers."""

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


@pytest.mark.parametrize("capability", ptx.CAPABILITIES, ids=lambda c: f"{c[0]}.{c[1]}")
@pytest.mark.parametrize(("name", "kernel", "signature"), CASES)
def test_kernels_need_no_memory_of_a_thread(name, kernel, signature, capability):
    built = ptx.build(kernel, signature, capability)
    assert built.registers > 0
    # Kernels in FRAMES have a reason to keep a few hundred numbers of a thread in memory.
    assert built.stack_bytes <= (FRAME_BYTES if name in ptx.FRAMES else 0)
    assert built.spilled_bytes <= (SPILLED_BYTES if name in ptx.FRAMES else 0)


def test_a_contract_that_forgets_a_parameter_is_refused():
    def kernel(
        # In:
        values,  # (n,) f8
        other,
    ):
        pass

    from izo_ref.base.cuda.compile import Kernel

    with pytest.raises(ValueError, match="other"):
        ptx.signatures(Kernel(kernel))


def test_a_contract_must_say_the_types_of_a_record_that_offers_a_choice():
    def kernel(
        # In:
        inputs,  # Inputs
    ):
        pass

    from izo_ref.base.cuda.compile import Kernel

    with pytest.raises(ValueError, match="Inputs: expected one of f8 or f4, got ''"):
        ptx.signatures(Kernel(kernel))

"""Blocks that wait for each other all run at the same time."""

from importlib.util import find_spec

import pytest

if find_spec("numba_cuda") is None:
    pytest.skip("needs numba-cuda: izo-ref[cuda]", allow_module_level=True)

from validation import ptx

if ptx.ptxas() is None:
    pytest.skip("needs ptxas: nvidia-cuda-nvcc", allow_module_level=True)

from izo_ref.detection import gpu_detector
from izo_ref.detection.cuda import contacts, tree

# CUDA C++ Programming Guide, table of technical specifications: the same for all capabilities.
REGISTERS, UNIT = 65536, 8


@pytest.mark.parametrize("capability", [ptx.CAPABILITIES[0], ptx.CAPABILITIES[-1]])
@pytest.mark.parametrize(
    ("kernel", "n_threads"),
    [
        (tree.fit_trees, gpu_detector.FIT_THREADS),
        (contacts.list_impacts, gpu_detector.LIST_THREADS),
    ],
)
def test_a_multiprocessor_has_registers_for_one_block(kernel, n_threads, capability):
    (signature,) = ptx.signatures(kernel).values()
    registers = ptx.build(kernel, signature, capability).registers
    assert n_threads * -(-registers // UNIT) * UNIT <= REGISTERS

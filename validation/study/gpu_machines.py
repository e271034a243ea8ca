"""Published and measured constants of GPUs, from which lower bounds of times are computed."""

from typing import NamedTuple


class Machine(NamedTuple):
    """What bounds the time of work on a GPU from below."""

    bytes_per_s: float  # to and from the memory of the GPU
    float64_per_s: float  # operations; a fused product and sum are two
    link_bytes_per_s: float  # between the host and the GPU, in one direction
    launch_s: float  # of the host, for a launch
    node_s: float  # of a kernel in a program, besides its work
    read_s: float  # of the host, to read some bytes
    array_s: float  # of the host, to make an array
    n_multiprocessors: int


# Launches by C++ are published as 3 to 5 us. NVIDIA's "Getting Started with CUDA Graphs" (2019)
# has a kernel of 2.9 us that takes 3.4 us in a graph.
LAUNCH_S, NODE_S = 3e-6, 0.5e-6
# A read takes at least a round trip of PCIe. No published figure was at hand, so it counts as
# nothing except on the machine where it was measured.
READ_S = 0.0
PCIE_4, PCIE_5 = 31.5e9, 63e9  # bytes/s of 16 lanes in one direction, after their line code
GRID_WAIT_S = 1.3e-6  # of all blocks for each other, measured on an H200 on 2026-11-29

MACHINES = {
    # A100 80 GB SXM: NVIDIA A100 Tensor Core GPU Datasheet
    "A100": Machine(2.039e12, 9.7e12, PCIE_4, LAUNCH_S, NODE_S, READ_S, 0.0, 108),
    # H100 SXM: NVIDIA H100 Tensor Core GPU Datasheet
    "H100": Machine(3.35e12, 34e12, PCIE_5, LAUNCH_S, NODE_S, READ_S, 0.0, 132),
    # NVIDIA Ada GPU Architecture: float64 has a 64th of the rate of float32, which is 82.6e12
    "RTX 4090": Machine(1.008e12, 82.6e12 / 64, PCIE_4, LAUNCH_S, NODE_S, READ_S, 0.0, 128),
    # The rates are those of NVIDIA's H200 Tensor Core GPU Datasheet. The other times were measured
    # on 2026-11-29: 0.7 us a node of a graph, 21 us a read of 64 bytes, 26 us an array of
    # numba-cuda, which is a block of the driver as those of `base/cuda/memory.py` are. A launch by
    # our launcher was not measured, so it takes 3 us, too.
    "H200": Machine(4.8e12, 34e12, PCIE_5, LAUNCH_S, 0.7e-6, 21e-6, 26e-6, 132),
}

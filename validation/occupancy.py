"""How many threads of a kernel a multiprocessor of a GPU holds at the same time.

Source: NVIDIA, CUDA C++ Programming Guide 13.0, table "Technical Specifications per Compute
Capability"; the units in which registers and shared memory are given away are those of
`cuda_occupancy.h` of the CUDA toolkit.
"""

from typing import NamedTuple

WARP = 32  # threads
REGISTER_UNIT = 256  # a warp gets registers in multiples of this number
WARP_UNIT = 4  # a multiprocessor has four parts, and each has a fourth of the registers
SHARED_UNIT = 128  # bytes; a block gets shared memory in multiples of this number
RESERVED_BYTES = 1024  # shared memory of each block that the system uses


class Multiprocessor(NamedTuple):
    """What a multiprocessor has, and how many blocks and threads it holds at most."""

    threads: int
    blocks: int
    registers: int
    shared_bytes: int


class Occupancy(NamedTuple):
    """What a multiprocessor holds of one kernel."""

    blocks: int
    threads: int
    share: float  # of the threads that it could hold


MULTIPROCESSORS = {
    (8, 0): Multiprocessor(2048, 32, 65536, 164 << 10),
    (8, 9): Multiprocessor(1536, 24, 65536, 100 << 10),
    (9, 0): Multiprocessor(2048, 32, 65536, 228 << 10),
    (10, 0): Multiprocessor(2048, 32, 65536, 228 << 10),
}


def occupancy(
    capability: tuple[int, int], n_threads: int, registers: int, shared_bytes: int
) -> Occupancy:
    """Return how many blocks and threads of a kernel a multiprocessor holds.

    Args:
        capability: Compute capability, a key of MULTIPROCESSORS.
        n_threads: Threads of a block.
        registers: Registers of a thread.
        shared_bytes: Shared memory of a block, fixed and dynamic together [bytes].

    Returns:
        The occupancy; no blocks if not even one fits.
    """
    own = MULTIPROCESSORS[capability]
    warps = -(-n_threads // WARP)
    of_a_warp = -(-max(registers, 1) * WARP // REGISTER_UNIT) * REGISTER_UNIT
    resident_warps = own.registers // of_a_warp // WARP_UNIT * WARP_UNIT
    shared = -(-(shared_bytes + RESERVED_BYTES) // SHARED_UNIT) * SHARED_UNIT
    limits = own.blocks, own.threads // WARP // warps, resident_warps // warps
    blocks = min(*limits, own.shared_bytes // shared)
    return Occupancy(blocks, blocks * n_threads, blocks * warps * WARP / own.threads)

"""What a fault is."""

from typing import NamedTuple


class Fault(NamedTuple):
    """One deliberate fault: a piece of text that is replaced."""

    name: str
    file: str  # from the root of the repository
    old: str  # occurs exactly once in the file
    new: str
    what: str  # what is wrong now
    tests: tuple  # pytest arguments of the tests most likely to notice
    origin: str = ""  # where it was found before; empty: made up for this list
    limit_s: float = 600.0  # seconds for these tests; a fault may make them hang


CPU_SIMULATOR = "found in a CPU simulator"
GPU_SIMULATOR = "found in a GPU simulator"
ELSEWHERE = "found in another implementation"

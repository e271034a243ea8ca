"""The record of a deliberate fault."""

from typing import NamedTuple


class Fault(NamedTuple):
    """One deliberate fault: a piece of text that is replaced by another."""

    name: str
    file: str  # path from the root of the repository
    old: str  # text that occurs exactly once in the file
    new: str
    what: str  # a sentence that says what the fault does
    tests: tuple[str, ...]  # pytest arguments of the tests that are most likely to notice
    origin: str = ""  # where the fault was found before; empty if it was made up for this list
    limit_s: float = 600.0  # seconds for these tests, since a fault may make them hang


CPU_SIMULATOR = "found in a CPU simulator"
GPU_SIMULATOR = "found in a GPU simulator"
ELSEWHERE = "found in another implementation"

"""The record of a flag, and the sources that many flags share."""

from __future__ import annotations

from typing import NamedTuple

TYPICAL = "A typical slip."
CPU_SIMULATOR = "Found in a CPU simulator (validation/mutants)."
GPU_SIMULATOR = "Found in a GPU simulator (validation/mutants)."
ELSEWHERE = "Found in another implementation (validation/mutants)."
CCD_BENCHMARK = (
    "Several published CCD codes miss degenerate pairs: Wang et al., A large-scale benchmark and "
    "an inclusion-based algorithm for continuous collision detection (2021)."
)


class Flag(NamedTuple):
    """A typical mistake of ports, with a name.

    Attributes:
        name: Name in the vectors and in the reports of `izo conform`.
        stages: The stages whose vectors catch it, the most telling one first; none if no single
            case can show it.
        mistake: What the port does wrong.
        harm: What a user sees because of it.
        seen: Where it was or is seen.
    """

    name: str
    stages: tuple[str, ...]
    mistake: str
    harm: str
    seen: str

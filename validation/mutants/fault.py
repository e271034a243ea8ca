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
    flag: str = ""  # the mistake of a port that it is an example of (izo_ref/porting/flags.py)
    not_by_vectors: str = ""  # why no vector can notice; empty if the vectors have to


CPU_SIMULATOR = "found in a CPU simulator"
GPU_SIMULATOR = "found in a GPU simulator"
ELSEWHERE = "found in another implementation"

# Reasons why no vector can notice a fault.
ON_GPU = "It is in code of a GPU, and the vectors run on the CPU."
ANEW = (
    "It concerns what is kept from one detection or solve to the next, which saves work; the "
    "vectors ask for each stage anew."
)
ROUNDING = (
    "It shows where floats cannot tell whether a pair touches, and the vectors leave such ties out."
)
LARGE = "It is in the solver of large zones, and the zones of the vectors are small."
FALLBACK = "It is in a solver that runs only if block pivoting gives up, or if it is asked for."
HANDED_ON = (
    "It makes block pivoting fail its own check, so another solver takes the zone and is right."
)
ON_THREADS = "It shows with work for several threads, and the vectors are too small for that."
NOT_ASKED = "It concerns a choice of our own loop; no stage asks a port for it."
JUDGES = "It is in code that judges answers, and the vectors ask for answers."
ONE_STEP = "It shows in the next step of a sequence, and the vectors have single steps."
TOUCHES = (
    "It concerns starts that touch or cross and are accepted, and the vectors refuse such starts."
)
LEFT_OUT = "It concerns pairs that are left out, and the vectors leave out none."
WELDED = "It concerns welded vertices, and no vertices of the vectors coincide."
ODD_SIZES = (
    "It shows at extraordinary sizes, and the coordinates of the vectors are float32 numbers."
)
EXACT_MOVES = (
    "It shows in the rounding of moves, and those between float32 numbers have none in float64."
)
BY_FRACTIONS = "It is in exact arithmetic, which judges what floats cannot decide."
REPORTED = (
    "It concerns what is reported besides positions, and the vectors ask for positions alone."
)

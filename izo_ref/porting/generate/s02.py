"""Vectors of stage S2: whether a pair meets on its path, and when first."""

from __future__ import annotations

from collections import Counter
from typing import Any

from izo_ref.porting.cases import VALID, Case
from izo_ref.porting.generate import pairs_flat, pairs_miss, pairs_moving, pairs_near
from izo_ref.porting.generate.pairs import Named
from izo_ref.porting.reference.contact import meeting

# Published conservative methods stop before the time: the IPC Toolkit multiplies the time of its
# solvers by 0.8, and the additive method of Li et al. (2021) stops at a tenth of the distance. So a
# time may be early by 0.2 of itself, and the rest is for their own tolerances.
EARLY = 0.25
# The error that `contact` derives is that of evaluating the cubic once. A root finder subtracts two
# such values, or stops on either side of zero: twice. Another order of operations: once more twice.
MULTIPLE = 4
PAIRS = (
    *pairs_moving.DEGREES,
    *pairs_moving.TIMES,
    *pairs_moving.ROOTS,
    *pairs_near.boundaries(),
    *pairs_near.scales(),
    *pairs_near.STARTS,
    *pairs_near.COORDINATES,
    *pairs_near.RESTING,
    *pairs_near.LINEAR,
    *pairs_flat.SLIDING,
    *pairs_flat.STAYING,
    *pairs_flat.PARALLEL,
    *pairs_flat.DEGENERATE,
    *pairs_miss.MISSES,
)


def cases() -> list[Case]:
    """Return all cases of the stage."""
    numbers: Counter[str] = Counter()
    result = []
    for named in PAIRS:
        numbers[named.word] += 1
        result.append(_case(named, numbers[named.word]))
    return result


def _case(named: Named, number: int) -> Case:
    found = meeting(named.pair, MULTIPLE)
    expected: dict[str, dict[str, Any]] = {
        "meets": {"judge": "equal", "values": [int(found is not None)]}
    }
    dtypes = named.dtypes
    if found is not None:
        expected["toi"] = {
            "judge": "time",
            "time": float(found.time),
            "scale": found.scale,
            "multiple": MULTIPLE,
            "early": EARLY,
        }
        dtypes = tuple(name for name in dtypes if name in found.dtypes)
    return Case(
        f"S2-{named.word}-{number:02d}",
        "S2",
        named.flags,
        VALID,
        named.grade,
        dtypes,
        named.what,
        pair_inputs(named),
        expected,
    )


def pair_inputs(named: Named) -> dict[str, Any]:
    """Return the inputs of a pair, flat."""
    return {
        "is_edge_edge": int(named.pair.is_edge_edge),
        "start": [float(x) for point in named.pair.start for x in point],
        "end": [float(x) for point in named.pair.end for x in point],
    }

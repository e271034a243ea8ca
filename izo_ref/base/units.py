"""Powers of two that bring lengths and masses into the range of the computation.

A step with all lengths multiplied by 2^k has the answer times 2^k. Floats keep this bit for bit, as
long as nothing overflows or underflows: all bounds of the method are relative to the size of a
pair, of a zone or of the scene. So a step of extraordinary size is multiplied by a power of two,
resolved, and its answer is multiplied back. A step of ordinary size is computed as it is, and
nothing is copied.

**Ordinary lengths.** The largest coordinate of a vertex in a face is from 2^-100 to 2^100 m. The
method multiplies at most four lengths of one pair, or of one zone, without dividing by its size
first. So products are at most 2^800 for vertices that are 2^100 times farther out than the mesh,
and at least 2^-800 for features of 2^-100 of the size of the mesh.

**Ordinary masses.** Masses are from 2^-200 to 2^200 kg. Masses are multiplied by powers of four
only: the root of such a factor is a power of two, so the bits stay. Masses times an odd power of
two have roots with other digits. To give them the same bits, half of all steps of ordinary masses
would have to be computed with other masses than those that came in, and would get other digits.

**Ratios of masses.** The largest mass is at most 2^100 = 1.3e30 times the smallest one. Up to there
each vertex of random zones of 10 and of 60 impacts ends where it does in rational arithmetic, up to
1e-13 of the largest move. Beyond it errors grow, and the distance bound soon says nothing.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Masses
from izo_ref.base.errors import MassError

LENGTHS = 100  # exponent of the largest ordinary length [m], and less that of the smallest
MASSES = 200  # the same for masses [kg]
RATIO = 100  # exponent of the largest ratio of two masses


class Units(NamedTuple):
    """Powers of two by which the lengths and the masses of a step are multiplied.

    Attributes:
        length: Exponent of the factor of lengths.
        mass: Exponent of the factor of masses, an even number.
    """

    length: int = 0
    mass: int = 0


AS_THEY_ARE = Units()


def times_power(values: Any, exponent: Any) -> Any:
    """Return values times 2^exponent; what no float can hold becomes infinite or zero."""
    with np.errstate(all="ignore"):
        scaled = np.ldexp(values, exponent)
    return scaled if isinstance(values, np.ndarray) else float(scaled)


def into_range(size: float, largest: int) -> int:
    """Return the smallest shift of an exponent that brings a size from 2^-largest to 2^largest."""
    exponent = math.frexp(size)[1]
    return min(max(exponent, -largest), largest) - exponent


def mass_exponent(masses: Masses, used: Flags | None = None) -> int:
    """Return the even exponent of the power of two that brings masses into range.

    Args:
        masses: (n,) f8 [kg], positive.
        used: (n,) b1, vertices whose masses are used; those that are finite if None.
    """
    own = masses[np.isfinite(masses) if used is None else used]
    if len(own) == 0:
        return 0
    lowest, highest = math.frexp(float(own.min()))[1], math.frexp(float(own.max()))[1]
    if lowest > -MASSES and highest <= MASSES:
        return 0
    middle = (lowest + highest) // 2
    return -(middle - middle % 2)


def require_ratio(masses: Masses, used: Flags) -> None:
    """Raise an error if two masses differ too much to solve zones with them.

    Args:
        masses: (n,) f8 [kg], positive.
        used: (n,) b1, vertices whose masses are used.

    Raises:
        MassError: A mass is too small beside the largest one; names the first vertex.
    """
    own = masses[used]
    if len(own) == 0:
        return
    high = float(own.max())
    least = float(times_power(high, -RATIO))
    if float(own.min()) >= least:
        return
    off = np.flatnonzero(used & (masses < least))
    raise MassError(
        f"masses: expected numbers of at least {least:.3g} [kg] beside the largest mass of "
        f"{high:.3g} kg, found {len(off)} smaller ones, the first is {masses[off[0]]:.3g} at "
        f"vertex {off[0]}"
    )


def largest(values: Floats) -> float:
    """Return the largest absolute value; 0 if there is none."""
    return max(float(values.max(initial=0.0)), -float(values.min(initial=0.0)))

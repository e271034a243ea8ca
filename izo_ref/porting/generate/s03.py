"""Vectors of stage S3: the weights and the normal of an impact at its time."""

from __future__ import annotations

import struct
from collections import Counter
from fractions import Fraction
from typing import Any

from izo_ref.porting.cases import VALID, Case
from izo_ref.porting.generate import (
    pairs_early,
    pairs_flat,
    pairs_frames,
    pairs_moving,
    pairs_near,
    pairs_rounded,
)
from izo_ref.porting.generate.pairs import Named
from izo_ref.porting.generate.s02 import pair_inputs
from izo_ref.porting.reference.closest import Frame, frame
from izo_ref.porting.reference.contact import meeting
from izo_ref.porting.reference.rounded import EPS, is_float32, to_float32

# The scale bounds the rounding of one formula. There are others, with the same condition: areas
# instead of Cramer's rule, interpolated positions instead of interpolated differences.
MULTIPLE = 8
# A port whose tolerance is larger than this is not judged.
USELESS = 1e-2
# Where the normal is not unique, the gap at the start must be at least this part of the largest
# possible gap: far above rounding, so that the side is right, and no demand on the angle.
LEAST_GAP = 2.0**-6
PAIRS = (
    *pairs_frames.SIDES,
    *pairs_frames.TURNING,
    *pairs_moving.ROOTS,
    *pairs_frames.ORDERS,
    *pairs_frames.SIZES,
    *pairs_near.COORDINATES,
    *pairs_flat.SLIDING,
    *pairs_flat.PARALLEL,
    *pairs_flat.DEGENERATE,
    *pairs_early.FACES,
    *pairs_early.EDGES,
    *pairs_rounded.SIZES,
    *pairs_rounded.ROUNDED,
    *pairs_rounded.FAR,
)
# What the flags of stage S2 stand for here.
FLAGS = {"many-roots": "frame-time", "stays-coplanar": "frame-time"}
# Their frozen gap is zero at t = 0 although the normal exists, so no side is right.
NOT_HERE = ("graze", "triple-root")


def cases() -> list[Case]:
    """Return all cases of the stage."""
    numbers: Counter[str] = Counter()
    result = []
    for named in PAIRS:
        found = meeting(named.pair, MULTIPLE)
        if found is None or named.word in NOT_HERE:
            continue
        numbers[named.word] += 1
        single = "f4" in named.dtypes
        time = found.time * Fraction(named.share)
        toi = float32_below(time) if single else float(time)
        result.append(_case(named, numbers[named.word], toi))
    return result


def float32_below(time: Any) -> float:
    """Return the largest float32 that is not after a time."""
    number = to_float32(float(time))
    if number > time:
        (bits,) = struct.unpack("<i", struct.pack("<f", number))
        number = struct.unpack("<f", struct.pack("<i", bits - 1))[0]
    return number


def _case(named: Named, number: int, toi: float) -> Case:
    result = frame(named.pair, toi)
    expected, scales = _expected(result)
    usable = [n for n in named.dtypes if MULTIPLE * EPS[n] * max(scales) < USELESS]
    held = result.dtypes if is_float32(toi) else ("f8",)
    return Case(
        f"S3-{named.word}-{number:02d}",
        "S3",
        tuple(dict.fromkeys(FLAGS.get(flag, flag) for flag in named.flags)),
        VALID,
        named.grade,
        tuple(name for name in usable if name in held),
        named.what,
        {**pair_inputs(named), "toi": toi},
        expected,
    )


def _expected(result: Frame) -> tuple[dict[str, dict[str, Any]], list[float]]:
    """Return what is expected of both outputs, and the scales that are relative to 1."""
    common = {"scale": [result.size], "multiple": MULTIPLE}
    expected: dict[str, dict[str, Any]] = {}
    scales = [0.0]
    if result.weights_are_unique:
        scale = [result.weights_scale]
        values = list(result.weights)
        scales += scale
        expected["weights"] = {"judge": "values", "values": values, "scale": scale}
        expected["weights"]["multiple"] = MULTIPLE
    else:
        expected["weights"] = {"judge": "weights", "distance": result.distance, **common}
    if result.normal is not None:
        scale = [result.normal_scale]
        values = list(result.normal)
        scales += scale
        expected["normal"] = {"judge": "values", "values": values, "scale": scale}
        expected["normal"]["multiple"] = MULTIPLE
    else:
        gap = LEAST_GAP * result.reach
        expected["normal"] = {"judge": "side", "least_gap": gap, **common}
    return expected, scales

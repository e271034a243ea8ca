"""The dictionary of flags: the typical mistakes of ports, each explained once.

A case names the flags that it catches, `izo conform` prints their explanation beside a failure,
and `flags.json` holds them for other programs. The texts are in `dictionary/`. The last flags have
no stage, because no single case can show them; they are there for the faults of
`validation/mutants`.
"""

from __future__ import annotations

import json

from izo_ref.porting.dictionary.answers import DOOR, LOOP, OPTIMUM
from izo_ref.porting.dictionary.beyond import BEYOND
from izo_ref.porting.dictionary.descent import ITERATIONS, LAGRANGIAN, SEARCHES
from izo_ref.porting.dictionary.detection import DETECTION
from izo_ref.porting.dictionary.record import Flag
from izo_ref.porting.dictionary.zones import FRAMES, PROBLEM, ZONES
from izo_ref.porting.lines import one_a_line

__all__ = ["FLAG", "FLAGS", "Flag", "flags_of", "flags_text"]

FLAGS: tuple[Flag, ...] = (
    *DETECTION,
    *FRAMES,
    *ZONES,
    *PROBLEM,
    *LAGRANGIAN,
    *SEARCHES,
    *ITERATIONS,
    *OPTIMUM,
    *LOOP,
    *DOOR,
    *BEYOND,
)
FLAG = {flag.name: flag for flag in FLAGS}


def flags_of(stage: str) -> tuple[Flag, ...]:
    """Return the flags of a stage.

    Args:
        stage: Name of the stage, such as `S7`.
    """
    return tuple(flag for flag in FLAGS if stage in flag.stages)


def flags_text() -> str:
    """Return the content of `flags.json`: one flag a line."""
    records = (json.dumps(flag._asdict(), separators=(",", ":")) for flag in FLAGS)
    return one_a_line({"version": 1}, "flags", records)

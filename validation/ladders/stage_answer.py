"""What goes into a stage of the method, and what comes out of it."""

from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

from izo_ref.base.arrays import Floats

Inputs: TypeAlias = Mapping[str, Any]  # the fields of `izo_ref/porting/stages.py`


class Answer(NamedTuple):
    """What a stage answers.

    Attributes:
        numbers: Arrays of the outputs, flat.
        decision: What was decided; equal decisions are equal objects.
    """

    numbers: dict[str, Floats]
    decision: Any = None

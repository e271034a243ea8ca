"""Floats of the vectors, and answers of the ladders' stages as replies.

The ladders of precision ask most stages in the same way; `validation/ladders/stage_calls.py` has
the calls.
"""

from typing import Any

import numpy as np

from izo_ref.porting.stages import STAGE
from validation.ladders.stage_answer import Answer

DTYPES = {"f8": np.float64, "f4": np.float32}


def reply_of(stage: str, answer: Answer) -> dict[str, Any]:
    """Return the numbers of an answer in the shapes of a stage; those it lacks are left out."""
    return {
        field.name: answer.numbers[field.name].tolist()
        if field.shape
        else answer.numbers[field.name].item()
        for field in STAGE[stage].outputs
        if field.name in answer.numbers
    }

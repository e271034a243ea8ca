"""The quick rungs of ladders, as cases of a test."""

import pytest


def quick_rungs(ladders):
    """Return a case `(ladder, rung)` for each quick rung, with both names as its id."""
    return [
        pytest.param(ladder, rung, id=f"{ladder.name}-{rung}")
        for ladder in ladders
        for rung in ladder.quick
    ]

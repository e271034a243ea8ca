"""Samples of cases: some run always, the others with the slow tests."""

import pytest


def sample(cases, every, name=str):
    """Return parameters for all cases, of which only each `every`th one runs without `--slow`.

    Args:
        cases: The cases.
        every: How many cases there are for one that always runs.
        name: Names a case, for its test.
    """
    return [
        pytest.param(case, marks=pytest.mark.slow if k % every else (), id=name(case))
        for k, case in enumerate(cases)
    ]

"""Queries of single pairs on a path, with their answers."""

import pytest

from validation.scenes.queries import Queries, degenerate_queries
from validation.study import steps

# Our own degenerate cases, and the published ones where the step files are.
SOURCES = ("own", pytest.param("published", marks=pytest.mark.data))
EACH = 20  # of our own cases


def queries_of(source, rng) -> Queries:
    """Read or draw the queries of one of SOURCES."""
    if source == "own":
        return degenerate_queries(rng, EACH)
    data = steps.load("ccd-queries")
    return Queries(
        data["vertices"],
        data["kind_names"][data["kind"]] == "ee",
        data["truth"],
        [str(data["names"][name]) for name in data["name"]],
    )

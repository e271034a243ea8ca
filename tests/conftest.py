"""Command-line options, marks and fixtures."""

import numpy as np
import pytest

from tests.helpers.steps import DATA, SEED


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="run the tests that take minutes too")


def pytest_report_header():
    where = DATA if DATA.is_dir() else "absent: tests that need them are left out"
    return [f"izo_ref seed: {SEED} (IZO_SEED)", f"izo_ref step files: {where} (IZO_DATA)"]


def pytest_collection_modifyitems(config, items):
    for item in items:
        if "data" in item.keywords and not DATA.is_dir():
            item.add_marker(pytest.mark.skip(reason="needs the step files (IZO_DATA)"))
        if "slow" in item.keywords and not config.getoption("--slow"):
            item.add_marker(pytest.mark.skip(reason="takes minutes; run with --slow"))


@pytest.fixture
def rng(request):
    """A generator of its own for each test, from the seed in the header and its name."""
    return np.random.default_rng([SEED, *request.node.name.encode()])

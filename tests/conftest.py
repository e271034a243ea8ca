"""Command-line options, markers and fixtures of all tests."""

import numpy as np
import pytest

from tests.helpers.steps import DATA, SEED


def pytest_addoption(parser):
    """Add the option `--slow`."""
    parser.addoption("--slow", action="store_true", help="run the tests that take minutes too")


def pytest_report_header():
    """Print the seed of the random tests and the folder of the larger step files."""
    where = DATA if DATA.is_dir() else "absent: tests use the scenes of data/scenes alone"
    return [f"izo_ref seed: {SEED} (IZO_SEED)", f"izo_ref step files: {where} (IZO_DATA)"]


LEFT_OUT = pytest.StashKey[int]()


def pytest_collection_modifyitems(config, items):
    """Deselect the cases on larger step files if there are none, and skip slow tests."""
    # Ask for the marker, not for the keyword: the folder tests/data is a keyword of its tests.
    larger = [item for item in items if item.get_closest_marker("data") and not DATA.is_dir()]
    config.stash[LEFT_OUT] = len(larger)
    if larger:
        config.hook.pytest_deselected(items=larger)
        items[:] = [item for item in items if item not in set(larger)]
    # With several processes, the first one begins with the front of the list. It is busy with these
    # tests while another process compiles the package; otherwise both would compile the same.
    items.sort(key=lambda item: item.get_closest_marker("first") is None)
    for item in items:
        if item.get_closest_marker("slow") and not config.getoption("--slow"):
            reason = "takes minutes, or is one of many alike; run with --slow"
            item.add_marker(pytest.mark.skip(reason=reason))


def pytest_sessionfinish(session):
    if hasattr(session.config, "workeroutput"):  # this process is one of several
        session.config.workeroutput["left_out"] = session.config.stash.get(LEFT_OUT, 0)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Take the number of left-out cases from a process; all have the same number."""
    node.config.stash[LEFT_OUT] = getattr(node, "workeroutput", {}).get("left_out", 0)


def pytest_terminal_summary(terminalreporter, config):
    """Say how many cases were left out because the larger step files are missing."""
    if config.stash.get(LEFT_OUT, 0):
        terminalreporter.write_line(
            f"{config.stash[LEFT_OUT]} cases on larger step files were left out; they need the "
            "files of IZO_DATA"
        )


@pytest.fixture
def rng(request):
    """Return a generator that is seeded with the seed in the header and the name of the test."""
    return np.random.default_rng([SEED, *request.node.name.encode()])

"""Fixtures, seeds, and where the shared step files are."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

import izo_ref

HERE = Path(__file__).parent
DATA = Path(os.environ.get("IZO_DATA", HERE.parent.parent / "shared" / "data"))
SEED = int(os.environ.get("IZO_SEED", "20240607"))


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


def load(name):
    with np.load(DATA / f"{name}.npz") as archive:
        return {key: archive[key] for key in archive.files}


def load_step(name):
    arrays = load(name)
    keys = ("positions_t0", "positions_t1", "faces", "masses", "pinned")
    return izo_ref.Scene(**{key: arrays[key] for key in keys if key in arrays})


def peers():
    return json.loads((DATA / "peers.json").read_text())

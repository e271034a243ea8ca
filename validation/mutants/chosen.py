"""A plugin of pytest that runs chosen tests alone, in a given order.

It is loaded by `-p validation.mutants.chosen`. The file that the variable CHOSEN names has the
names of the tests, as a list in JSON. A command line with the names would be too long.
"""

import json
import os
from pathlib import Path

import pytest

CHOSEN = "CHOSEN"


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the chosen tests, in their order."""
    names = json.loads(Path(os.environ[CHOSEN]).read_text())
    place = {name: i for i, name in enumerate(names)}
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in place])
    items[:] = sorted(
        (item for item in items if item.nodeid in place), key=lambda item: place[item.nodeid]
    )

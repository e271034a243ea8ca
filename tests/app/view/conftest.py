"""A browser, and the page of a step, for the tests of the page."""

import pytest

from izo_ref.app.view.of_step import step_view
from izo_ref.loop.resolve import resolve
from tests.helpers.browser import started_browser
from tests.helpers.shapes import two_sheets
from tests.helpers.views import write_page


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """Start a browser once for all tests of this file."""
    with started_browser(tmp_path_factory.mktemp("profile")) as browser:
        yield browser


@pytest.fixture
def step_page(rng, tmp_path):
    """Write the page of a step of two sheets and its result; return it with both."""
    scene = two_sheets(rng)
    result = resolve(scene, 1e-3)
    return write_page(tmp_path, step_view("two sheets", scene, result)), scene, result

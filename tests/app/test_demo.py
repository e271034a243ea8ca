"""The demo: its scene, its page and its pictures."""

import re

import numpy as np
import pytest

from izo_ref import Status
from izo_ref.app.demo import demo_scene, write_demo
from izo_ref.app.picture import draw


def test_the_scene_has_the_documented_size_and_bodies():
    scene, body = demo_scene()
    assert 10_000 < len(scene.faces) < 20_000
    assert len(scene.faces) == 15_650
    assert set(body.tolist()) == {0, 1, 2}
    assert scene.pinned.any()


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Write the demo once: the result and its page."""
    return write_demo(tmp_path_factory.mktemp("demo"))


def test_the_demo_ends_free_and_writes_all_files(written):
    result, page = written
    assert result.status is Status.FREE
    names = {p.name for p in page.parent.iterdir()}
    assert names == {"index.html", "before.html", "after.html", "before.png", "after.png"}
    assert len(result.impacts.toi) > 100


def test_the_page_needs_no_network_and_shows_what_was_measured(written):
    result, page = written
    text = page.read_text()
    assert not re.search(r"(src|href)=.?(https?:)?//", text)
    assert f"{len(result.impacts.toi):,}" in text
    assert "FREE" in text
    view = (page.parent / "after.html").read_text()
    assert not re.search(r"<(script|link)[^>]+(src|href)=.?https?://", view)


def test_pictures_show_the_mesh_and_the_crossings(written):
    from PIL import Image

    _, page = written
    red = {}
    for name in ("before", "after"):
        pixels = np.asarray(Image.open(page.parent / f"{name}.png").convert("RGB")).astype(int)
        assert (pixels != 255).any(axis=2).mean() > 0.1
        red[name] = ((pixels[..., 0] > 120) & (pixels[..., 1:] < 60).all(axis=2)).sum()
    assert red["before"] > 100
    assert red["after"] == 0


def test_near_triangles_hide_those_behind_them(tmp_path):
    from PIL import Image

    near = np.array([[-1, -1, -1], [1, -1, -1], [0, -1, 1.0]])
    positions = np.concatenate((near + (0, 2, 0), near))  # the first triangle is farther away
    for order in ([0, 1], [1, 0]):
        faces = np.array([[0, 1, 2], [3, 4, 5]])[order]
        colors = np.array([[200, 0, 0], [0, 0, 200]])[order]
        draw(positions, faces, colors, tmp_path / "x.png", eye=(0, -1, 0), size=(90, 90))
        middle = np.asarray(Image.open(tmp_path / "x.png"))[45, 45]
        assert middle[2] > 50
        assert middle[0] == 0

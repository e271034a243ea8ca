"""The demo: its scene, its page and its times; and pictures of a mesh."""

import time

import numpy as np
import pytest

from izo_ref import Status
from izo_ref.app import demo
from izo_ref.app.cli import main
from izo_ref.app.demo import demo_scene, write_demo
from izo_ref.app.picture import draw
from izo_ref.app.view.pack import unpack
from tests.helpers.pages import Page
from tests.helpers.views import content_of


def test_the_scene_has_the_documented_size_and_bodies():
    scene, body = demo_scene()
    assert 10_000 < len(scene.faces) < 20_000
    assert len(scene.faces) == 15_650
    assert set(body.tolist()) == {0, 1, 2}
    assert scene.pinned.any()


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Run the demo once."""
    return write_demo(tmp_path_factory.mktemp("demo"))


def test_the_demo_ends_free_and_writes_one_page(done):
    assert done.result.status is Status.FREE
    assert [path.name for path in done.page.parent.iterdir()] == ["index.html"]
    assert len(done.result.impacts.toi) > 100


def test_the_page_shows_what_was_measured(done):
    page = Page(done.page)
    assert f"Impacts in zones{len(done.result.impacts.toi):,}" in page.text.replace("\n", "")
    assert "FREE" in page.text
    assert f"Time for resolving{done.resolving_s:.2f} s" in page.text
    content = content_of(page.source)
    assert content["parts"] == ["sphere", "sheet", "second sheet"]
    assert content["sides"][0]["nPairs"][1] > 1000
    assert content["sides"][1]["nPairs"] == [0, 0]


def test_the_parts_are_named_after_the_bodies(done):
    scene, body = demo_scene()
    content = content_of(done.page.read_text(encoding="utf-8"))
    part_of = unpack(content["partOf"], 1).ravel()
    assert np.array_equal(part_of[scene.faces[:, 0]], body)


def test_nothing_is_compiled_before_all_is_prepared(tmp_path, monkeypatch):
    """Making the scene compiles the checks of its arrays; then one process compiles the rest."""
    order = []

    def make_scene():
        order.append("scene")
        return demo_scene()

    monkeypatch.setattr(demo, "anything_compiled", lambda: order.append("asked") or False)
    monkeypatch.setattr(demo, "demo_scene", make_scene)
    done = write_demo(tmp_path, prepare=lambda: order.append("prepared"))
    assert order == ["asked", "prepared", "scene"]
    assert "compiling, only the first time" in done.lines()[0]


def test_compiling_and_resolving_have_a_time_each(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(demo, "anything_compiled", lambda: False)
    done = write_demo(tmp_path, prepare=lambda: time.sleep(1.0))
    assert done.preparing_s >= 1.0
    assert done.resolving_s == pytest.approx(done.result.timings["total"], abs=0.5)
    lines = done.lines()
    assert lines[0] == f"compiling, only the first time: {done.preparing_s:.1f} s"
    assert lines[1] == f"resolving: {done.resolving_s:.2f} s"
    page = Page(done.page)
    assert f"Time for compiling, only the first time{done.preparing_s:.1f} s" in page.text
    assert main(["demo", "-o", str(tmp_path)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith(("loading compiled code: ", "compiling, only the first time: "))
    assert said[1].startswith("resolving: ")
    assert said[2].startswith("FREE: ")
    assert said[3] == f"page: {tmp_path / 'index.html'}"


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

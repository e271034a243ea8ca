"""Pages in a headless Chromium: animations, addresses, hostile names, grey, narrow windows."""

import numpy as np
import pytest

from izo_ref.app.view.of_sequence import sequence_view
from izo_ref.formats.animation import open_animation
from tests.helpers.browser_scripts import SLIDE
from tests.helpers.pages import needs_browser
from tests.helpers.views import TRIANGLE, dipping_sheet, view_of, write_page

pytestmark = needs_browser
HOSTILE = '</script><img src=x onerror="document.title=1">'


def test_an_animation_plays_and_lists_what_crosses_in_each_frame(tmp_path, browser):
    frames, faces = dipping_sheet()
    np.savez(tmp_path / "dip.npz", positions=frames, faces=faces)
    page = write_page(tmp_path, sequence_view("dip", [open_animation(tmp_path / "dip.npz")]))
    script = SLIDE + (
        """
        const answer = {titles: [], rows: []};
        for (let frame = 0; frame < 6; frame += 1) {
          await set("frame", frame);
          answer.titles.push(document.getElementById("pairs-title").textContent);
          answer.rows.push(document.querySelectorAll("#list [role=option]").length);
        }
        answer.last = shown()[0];
        await set("path", 0.5);
        answer.between = shown()[0];
        document.querySelector("#list [role=option]").click();
        await wait(1000);
        answer.said = document.getElementById("said").textContent;
        await set("frame", 0);
        document.getElementById("play").click();
        const seen = new Set();
        for (let i = 0; i < 60 && seen.size < 6; i += 1) {
          await new Promise(requestAnimationFrame);
          seen.add(view.now.frame);
        }
        document.getElementById("play").click();
        answer.played = [...seen].sort();
        const stopped = view.now.frame;
        await wait(300);
        answer.stopped = stopped === view.now.frame;
        answer.radius = view.model.radius;
        return answer;
        """
    )
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert answer["rows"] == [0, 0, 0, 2, 2, 2]
    assert answer["titles"][3] == "Pairs that cross: Proposed 2"
    assert "edge 3" in answer["said"]
    assert len(answer["played"]) >= 3  # the browser may leave some out if it is slow
    assert answer["stopped"]
    step = (np.array(answer["last"]) - np.array(answer["between"])) * answer["radius"]
    assert np.abs(step.reshape(-1, 3) - 0.5 * (frames[5] - frames[4])).max() < 1e-6


def test_the_address_chooses_what_is_shown_at_first(step_page, browser):
    page, _, _ = step_page
    script = (
        "return [view.now.mode, view.stage.layout, view.now.theme, view.list.selected,"
        " document.getElementById('path').value];"
    )
    fragment = "colors=resolving&layout=wipe&theme=dark&pair=2"
    browser.load(page, fragment)
    answer = browser.run(script)
    assert browser.console == []
    assert answer[:4] == ["resolving", "wipe", "dark", 1]
    strange = "colors=none&layout=%3Cimg%3E&theme=&path=x&frame=1e99"
    browser.load(page, strange)
    answer = browser.run(script)
    assert browser.console == []
    assert answer[0] == "parts"
    assert answer[1] == "both"


def test_hostile_names_are_shown_as_texts(tmp_path, browser):
    page = write_page(tmp_path, view_of([[TRIANGLE]], title=HOSTILE, parts=[HOSTILE]))
    script = (
        "return [document.images.length, document.title,"
        " document.getElementById('legend').textContent];"
    )
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert answer == [0, f"{HOSTILE}: izo view", HOSTILE]


def test_colors_can_be_told_apart_in_grey(step_page, browser):
    """The scale rises evenly in luminance; parts, and the two sides of a pair, differ in it."""
    page, _, _ = step_page
    script = """
        const colors = await import("izo/colors");
        const grey = (color) => {
          const [red, green, blue] = colors.linear(color);
          return Math.cbrt(0.2126 * red + 0.7152 * green + 0.0722 * blue); // about the lightness
        };
        const values = Array.from({length: 21}, (_, i) => i / 20);
        return {
          light: values.map((value) => grey(colors.ramp(value, "light"))),
          dark: values.map((value) => grey(colors.ramp(value, "dark"))),
          times: values.map((value) => grey(colors.timeColor(value, "light"))),
          parts: Array.from({length: 8}, (_, i) => grey(colors.partColor(i))),
          sides: ["light", "dark"].map((theme) => colors.sideColors(theme).map(grey)),
        };
        """
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert (np.diff(answer["light"]) < -0.015).all()
    assert (np.diff(answer["dark"]) > 0.015).all()
    assert (np.diff(answer["times"]) > 0.01).all()
    assert np.diff(np.sort(answer["parts"])).min() > 0.02
    for first, second in answer["sides"]:
        assert first - second > 0.15


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_page(step_page, browser, width):
    page, _, _ = step_page
    browser.load(page, size=(width, 800))
    script = "const page = document.documentElement; return page.scrollWidth - page.clientWidth;"
    assert browser.run(script) <= 0
    assert browser.console == []


def test_a_page_that_is_damaged_says_so(step_page, tmp_path, browser):
    page, _, _ = step_page
    damaged = tmp_path / "damaged.html"
    damaged.write_text(page.read_text(encoding="utf-8").replace('"faces": "eJ', '"faces": "xx'))
    browser.load(damaged)
    said = browser.run("return document.getElementById('loading').textContent;")
    ready = browser.run("return document.documentElement.dataset.ready;")
    assert ready == "failed"
    assert said.startswith("The 3D view cannot be shown: ")
    assert len(browser.console) == 1  # so the other tests would see an error


def test_without_webgl_the_page_says_so_and_keeps_its_report(step_page, tmp_path, browser):
    page, _, _ = step_page
    without = tmp_path / "without.html"
    text = page.read_text(encoding="utf-8")
    off = "<script>HTMLCanvasElement.prototype.getContext = () => null;</script>"
    without.write_text(text.replace("</head>", off + "</head>"), encoding="utf-8")
    browser.load(without)
    said = browser.run("return document.getElementById('loading').textContent;")
    assert said.startswith("The 3D view cannot be shown: ")
    assert said.endswith("context. The report below has the figures.")
    assert browser.run("return document.querySelector('aside').checkVisibility();") is False
    assert browser.run("return document.getElementById('report').checkVisibility();") is True

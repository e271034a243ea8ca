"""The page of a step works in a headless Chromium: sliders, list, colors, layouts, keys."""

import numpy as np
import pytest

from tests.helpers.browser_scripts import PIXELS, SLIDE
from tests.helpers.pages import needs_browser

pytestmark = needs_browser


def test_the_path_slider_moves_both_sides(step_page, browser):
    page, scene, result = step_page
    script = SLIDE + (
        """
        const answer = {};
        for (const time of [0, 0.25, 1]) {
          await set("path", time);
          answer[time] = shown();
        }
        answer.text = document.getElementById("path-out").textContent;
        answer.radius = view.model.radius;
        return answer;
        """
    )
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert answer["text"] == "1.000"
    ends = np.concatenate((scene.positions_t0, scene.positions_t1, result.positions))
    centre = 0.5 * (ends.min(axis=0) + ends.max(axis=0))
    for time in (0.0, 0.25, 1.0):
        for side, end in enumerate((scene.positions_t1, result.positions)):
            expected = (1 - time) * scene.positions_t0 + time * end
            found = np.reshape(answer[f"{time:g}"][side], (-1, 3)) * answer["radius"] + centre
            # float32, relative to the radius: two roundings of the ends, two of the path
            assert np.abs(found - expected).max() < 4 * 2**-23 * answer["radius"]


def test_a_click_in_the_list_flies_to_the_pair_when_it_meets(step_page, browser):
    page, _, _ = step_page
    script = """
        const rows = document.querySelectorAll("#list [role=option]");
        const before = view.stage.camera.position.clone();
        rows[2].click();
        await wait(1500);
        const {pairs, row} = view.selected;
        const {root, positions} = view.stage.sides[0];
        const nodes = [...pairs.nodes.slice(6 * row, 6 * row + 4)];
        const middle = view.stage.controls.target.clone().set(0, 0, 0);
        for (const v of nodes) {
          middle.add(view.stage.controls.target.clone().fromArray(positions, 3 * v));
        }
        root.localToWorld(middle.multiplyScalar(1 / 4));
        return {
          n: Number(rows[2].getAttribute("aria-setsize")),
          selected: [...document.querySelectorAll("[aria-selected=true]")].map((r) => r.id),
          active: document.getElementById("list").getAttribute("aria-activedescendant"),
          time: Number(document.getElementById("path").value),
          toi: pairs.times[row],
          off: view.stage.controls.target.distanceTo(middle),
          near: view.stage.camera.position.distanceTo(middle),
          far: before.distanceTo(middle),
          cut: document.getElementById("cut").checked,
          said: document.getElementById("said").textContent,
        };
        """
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert answer["n"] > 20
    assert answer["selected"] == ["pair-2"]
    assert answer["active"] == "pair-2"
    assert answer["time"] == pytest.approx(answer["toi"], abs=6e-4)  # the slider has thousandths
    assert answer["off"] < 1e-5
    assert 0 < answer["near"] < answer["far"]
    assert answer["cut"]
    assert answer["said"].startswith(("vertex", "edge"))


def test_keys_in_the_list_go_through_all_rows(step_page, browser):
    page, _, _ = step_page
    script = """
        const list = document.getElementById("list");
        const press = async (key) => {
          list.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
          await wait(50);
          return view.list.selected;
        };
        const visited = [];
        for (const key of ["ArrowDown", "ArrowDown", "PageDown", "ArrowUp", "End", "Home"]) {
          visited.push(await press(key));
        }
        const drawn = list.querySelectorAll("[role=option]").length;
        return {visited, n: view.list.entries.length, drawn};
        """
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    n = answer["n"]
    assert answer["visited"] == [0, 1, 11, 10, n - 1, 0]
    assert answer["drawn"] < n  # only the rows that can be seen


def test_each_way_to_color_paints_something_else(step_page, browser):
    page, _, _ = step_page
    script = PIXELS + (
        """
        const seen = {};
        for (const radio of document.querySelectorAll("input[name=mode]")) {
          radio.click();
          await wait(50);
          seen[radio.value] = {
            colors: view.stage.sides.map((side) => side.colors.join()).join(),
            legend: document.getElementById("legend").textContent,
            painted: painted(0, 1),
          };
        }
        return seen;
        """
    )
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert set(answer) == {"parts", "pairs", "zones", "resolving", "start"}
    assert len({mode["colors"] for mode in answer.values()}) == len(answer)
    assert all(mode["legend"] for mode in answer.values())
    assert all(mode["painted"] > 1000 for mode in answer.values())


def test_layouts_show_one_side_or_both(step_page, browser):
    page, _, _ = step_page
    script = (
        PIXELS
        + SLIDE
        + (
            """
        const seen = {};
        for (const name of ["both", "before", "after", "wipe"]) {
          document.querySelector(`input[name=layout][value=${name}]`).click();
          await wait(50);
          seen[name] = {
            left: painted(0, 0.5), right: painted(0.5, 1),
            labels: ["before", "after"].map((s) => !document.getElementById(`label-${s}`).hidden),
          };
        }
        view.stage.sides[0].root.visible = false; // so that only the other side is seen
        await set("wipe", 0.8);
        seen.moved = {left: painted(0, 0.8), right: painted(0.8, 1)};
        await set("wipe", 0.2);
        seen.back = {left: painted(0, 0.2), right: painted(0.2, 1)};
        return seen;
        """
        )
    )
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert answer["both"]["left"] > 500
    assert answer["both"]["right"] > 500
    assert answer["both"]["labels"] == [True, True]
    assert answer["before"]["labels"] == [True, False]
    assert answer["after"]["labels"] == [False, True]
    assert answer["moved"]["left"] == 0
    assert answer["back"]["right"] > answer["moved"]["right"]


def test_keys_change_what_is_shown(step_page, browser):
    page, _, _ = step_page
    script = """
        const press = async (key) => {
          document.body.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
          await wait(300);
        };
        const theme = () => document.documentElement.dataset.theme;
        const answer = {themes: [theme()]};
        await press("d");
        answer.themes.push(theme());
        await press("3");
        answer.mode = view.now.mode;
        await press("x");
        answer.layout = view.stage.layout;
        await press("e");
        answer.edges = view.stage.sides[0].lines.visible;
        await press("n");
        answer.selected = view.list.selected;
        const eye = () => view.stage.camera.position.toArray();
        await press("a");
        const far = eye();
        await press("ArrowLeft");
        answer.turned = far.join() !== eye().join();
        await press("?");
        answer.help = document.getElementById("help").open;
        answer.keys = document.querySelectorAll("#help-keys tr").length;
        return answer;
        """
    browser.load(page)
    answer = browser.run(script)
    assert browser.console == []
    assert sorted(answer["themes"]) == ["dark", "light"]
    assert answer["mode"] == "zones"
    assert answer["layout"] == "before"
    assert answer["edges"]
    assert answer["selected"] == 0
    assert answer["turned"]
    assert answer["help"]
    assert answer["keys"] > 15

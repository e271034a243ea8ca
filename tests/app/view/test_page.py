"""The page of a view: what it holds can be read back, and nothing in it leads elsewhere."""

import hashlib
import re

import numpy as np
import pytest

from izo_ref.app.view import page as page_module
from izo_ref.app.view.model import (
    STEPS,
    Kind,
    ShownPairs,
    Table,
    grid_of,
    join_pairs,
    pairs_at_rest,
    pairs_on_path,
)
from izo_ref.app.view.pack import pack, unpack
from izo_ref.app.view.page import KINDS, MODULES, pair_sentence, view_page
from izo_ref.base.records import Pairs
from tests.helpers.pages import Page
from tests.helpers.views import TRIANGLE, content_of, positions_of, view_of
from validation import house

FOLDER = house.ROOT / "izo_ref" / "app" / "view"
HOSTILE = '</script><!-- <img src=x onerror="alert(1)"> {{data}} & \u2028'


@pytest.mark.parametrize("width", [1, 3, 6])
def test_numbers_are_unpacked_as_they_were(rng, width):
    limits = np.iinfo(np.int32)
    for n in (0, 1, 2, 1000):
        numbers = rng.integers(limits.min, limits.max, (n, width), endpoint=True)
        base = rng.integers(limits.min, limits.max, (n, width), endpoint=True)
        assert np.array_equal(unpack(pack(numbers), width), numbers)
        assert np.array_equal(unpack(pack(numbers, base), width, base), numbers)


def test_equal_frames_take_almost_no_room(rng):
    numbers = rng.integers(-STEPS, STEPS, (50_000, 3))
    assert len(pack(numbers, numbers)) < 2000
    assert len(pack(numbers)) < 1.4 * 4 * numbers.size
    with pytest.raises(OverflowError):
        pack(np.array([2**31]))


def test_positions_are_read_back_within_half_a_step(rng):
    before = [rng.normal(100.0, 3.0, (60, 3)) for _ in range(4)]
    after = [np.where(rng.random((60, 1)) < 0.2, p + 0.1, p) for p in before]
    content = content_of(view_page(view_of([before, after])))
    everything = np.concatenate(before + after)
    low, high = everything.min(axis=0), everything.max(axis=0)
    found = positions_of(content, 0.5 * (low + high))
    # Half a step, and the rounding of float64 in the numbers near 100.
    bound = 0.5 * content["radius"] / STEPS + 1e-12
    for frames, expected in zip(found, (before, after), strict=True):
        for positions, wanted in zip(frames, expected, strict=True):
            assert np.abs(positions - wanted).max() <= bound
    assert content["radius"] == pytest.approx(0.5 * (high - low).max())


@pytest.mark.parametrize("size", [5e-324, 1e-300, 1.0, 1e300])
def test_any_size_fits(size):
    view = view_of([[TRIANGLE * size]])
    grid = grid_of(view)
    whole = grid.whole(view.sides[0].positions[0])
    assert np.array_equal(whole, (np.array(TRIANGLE) * 2 - (1, 1, 0)) * STEPS)
    assert content_of(view_page(view))["radius"] == pytest.approx(0.5 * size, rel=1e-12)


def test_a_vertex_in_no_face_does_not_decide_the_size():
    far = np.concatenate((TRIANGLE, [[1e300, 0, 0]]))
    view = view_of([[far]])
    assert grid_of(view).radius_m == 0.5
    assert np.abs(grid_of(view).whole(far)).max() == 64 * STEPS
    nothing = view_of([[np.empty((0, 3))]])
    assert "</html>" in view_page(nothing)


def pairs_of_each_kind():
    """Return one pair of each kind, those with a time first."""
    on_path = pairs_on_path(
        Pairs(np.array([[7, 1, 2, 3], [4, 5, 8, 9]], np.int32), np.array([False, True])),
        np.array([0.75, 0.25]),
    )
    through = pairs_at_rest(Kind.EDGE_THROUGH_FACE, np.array([[1, 2]]), np.array([[3, 4, 5]]))
    faces = pairs_at_rest(Kind.FACE_FACE, np.array([[0, 1, 2]]), np.array([[3, 4, 5]]))
    return join_pairs([on_path, through, faces])


def test_pairs_are_said_in_words_the_first_to_meet_first():
    pairs = pairs_of_each_kind()
    assert [pair_sentence(pairs, i) for i in range(4)] == [
        "edge (4 5) and edge (8 9) meet at t = 0.25",
        "vertex (7) and face (1 2 3) meet at t = 0.75",
        "edge (1 2) and face (3 4 5) cross",
        "face (0 1 2) and face (3 4 5) cross",
    ]
    assert set(KINDS) == set(Kind)


def test_pairs_are_read_back():
    pairs = pairs_of_each_kind()
    view = view_of([[np.tile(TRIANGLE, (4, 1))]])
    view.sides[0].pairs[0] = pairs
    content = content_of(view_page(view))
    packed = content["sides"][0]["pairs"][0]
    assert np.array_equal(unpack(packed["nodes"], 6), pairs.nodes)
    assert unpack(packed["kinds"], 1).ravel().tolist() == [1, 0, 2, 3]
    times = unpack(packed["times"], 1).ravel() / content["ticks"]
    assert times[:2].tolist() == [0.25, 0.75]
    assert (times[2:] < 0).all()


def test_the_page_leads_nowhere(tmp_path):
    (tmp_path / "page.html").write_text(view_page(view_of([[TRIANGLE]])), encoding="utf-8")
    page = Page(tmp_path / "page.html")
    assert not re.search(r"https?:", page.source)
    assert {value for _, _, value in page.links} == {"#report"}
    assert "default-src 'none'" in page.source
    assert len(page.ids) == len(set(page.ids))
    for name in re.findall(r'byId\("([\w-]+)"\)', (FOLDER / "js" / "controls.js").read_text()):
        assert name in page.ids


def test_hostile_names_stay_texts(tmp_path):
    view = view_of(
        [[TRIANGLE]],
        title=HOSTILE,
        verdict=HOSTILE,
        parts=[HOSTILE],
        notes=[HOSTILE],
        tables=[Table(HOSTILE, (HOSTILE,), [(HOSTILE,)])],
    )
    (tmp_path / "page.html").write_text(view_page(view), encoding="utf-8")
    page = Page(tmp_path / "page.html")
    plain = view_page(view_of([[TRIANGLE]]))
    assert page.source.count("<script") == plain.count("<script")
    assert page.source.count("</script") == plain.count("</script")
    assert "<img" not in page.source
    assert content_of(page.source)["parts"] == [HOSTILE]


def test_every_module_is_in_the_page_and_imports_only_such():
    for name, path in MODULES.items():
        source = (FOLDER / path).read_text(encoding="utf-8")
        if not name.startswith("three"):
            for imported in re.findall(r'from "([^"]+)"', source):
                assert imported in MODULES, f"{path} imports {imported}"
    written = {f"js/{path.name}" for path in (FOLDER / "js").iterdir()}
    assert written == {path for path in MODULES.values() if path.startswith("js/")}
    imports = page_module._import_map()
    assert "three.core.min.js" not in imports
    assert imports.count("data:text/javascript;base64,") == len(MODULES)


def test_three_is_the_release_that_its_note_says():
    note = (FOLDER / "three" / "README.md").read_text(encoding="utf-8")
    sums = dict(re.findall(r"^\| `([\w.]+)` \| `([0-9a-f]{64})` \|$", note, re.M))
    assert len(sums) == 4
    for name, expected in sums.items():
        content = (FOLDER / "three" / name).read_bytes()
        assert hashlib.sha256(content).hexdigest() == expected, name
    core = (FOLDER / "three" / "three.core.min.js").read_text(encoding="utf-8")
    assert re.search(r'const t="(\d+)"', core)[1] == "185"
    assert "release 185" in (FOLDER / "page.html").read_text(encoding="utf-8")
    assert "The MIT License" in view_page(view_of([[TRIANGLE]]))


def test_arrays_that_do_not_fit_are_refused():
    wrong = ShownPairs(*(column[:0] for column in pairs_of_each_kind()))
    with pytest.raises(ValueError, match="a view of 3 vertices"):
        view_page(view_of([[TRIANGLE]], pinned=np.zeros(4, bool)))
    view = view_of([[TRIANGLE]])
    view.sides[0].pairs.append(wrong)
    with pytest.raises(ValueError, match="1 frames"):
        view_page(view)

"""Pages of the report: well-formed, without other files, and usable in a browser."""

import functools

import numpy as np
import pytest

from tests.helpers.pages import check_page, look, needs_browser
from validation.report import plots, site

RUN = {
    "run": 1,
    "command": "python -m validation report",
    "commit": "0123456789ab",
    "machine": "2 cores",
    "versions": "Python 3.11, numba 0.68",
    "quick": False,
    "started": "2026-01-01T00:00:00+00:00",
}
ROWS = [
    {"name": "b", "value": 2.0, "yes": True},
    {"name": "a <b>", "value": 1e-9, "yes": False},
    {"name": "c", "value": None, "yes": None},
    {"name": "d", "value": 10, "yes": True},
]
COLUMNS = {"name": "name", "value": "value", "doubled": lambda row: 2 * (row["value"] or 0.0)}


def drawing(shift=0.0):
    """Return a small plot as SVG."""
    figure, ax = plots.new(7.0, 4.0)
    for i in range(3):
        x = 10.0 ** np.arange(5)
        ax.plot(x, 1e-6 * x ** (1 + i / 3 + shift), label=f"line {i} & co", **plots.style(i))
    plots.logarithmic(ax)
    ax.set(xlabel="impacts < 10⁵", ylabel="time [s]")
    plots.legend_below(figure, [ax])
    return plots.svg(figure)


# A drawing takes a second. Tests of a page share the drawings, apart from the one that asks whether
# equal rows give equal pages.
drawn_before = functools.cache(drawing)


def write(path, extra="", draw=drawn_before):
    """Write a page with plots, a table and a folded section."""
    two = site.panels([draw(0.1), draw(0.2)], ["one", "two"])
    sections = [
        ("Plot", site.figure(draw(), "Time & size", [1])),
        ("Panels", site.figure(two, "Side by side", [1])),
        ("Table", site.data_table(COLUMNS, ROWS, "Some rows")),
        ("Folded", site.folded("more <b>", site.paragraph("a < b")) + extra),
    ]
    site.write_page(path, "A page & more", "What <it> says.", sections, ["Not all < 1."], [RUN])


@pytest.fixture
def page(tmp_path):
    """Write a page, and return its file."""
    write(tmp_path / "scaling.html")
    return tmp_path / "scaling.html"


def test_a_page_is_well_formed_and_needs_no_other_file(page):
    found = check_page(page)
    assert "A page & more" in found.text
    assert "What <it> says." in found.text
    assert "Not all < 1." in found.text
    assert len(found.figures) == 2
    assert found.tables == [[3] * 5]
    for text in found.figures:
        for said in ("python -m validation report", "commit 0123456789ab", "2 cores", "numba 0.68"):
            assert said in text


@pytest.mark.parametrize(
    "wrong",
    [
        "<p>",
        "</section>",
        '<img src="https://example.org/a.png">',
        '<script src="other.js"></script>',
        '<link rel="stylesheet" href="//example.org/a.css">',
        "<table><tr><td>1</td></tr><tr><td>1</td><td>2</td></tr></table>",
        "<figure>no origin</figure>",
        '<p id="same"></p><p id="same"></p>',
    ],
)
def test_the_page_check_finds_each_defect(tmp_path, wrong):
    write(tmp_path / "scaling.html", wrong)
    with pytest.raises(AssertionError):
        check_page(tmp_path / "scaling.html")


def test_equal_rows_give_equal_pages(page, tmp_path):
    write(tmp_path / "again" / "scaling.html", draw=drawing)
    assert (tmp_path / "again" / "scaling.html").read_bytes() == page.read_bytes()


def test_an_unknown_run_is_called_unknown(tmp_path):
    sections = [("Plot", site.figure(drawing(), "Time", [1, 7]))]
    site.write_page(tmp_path / "outer.html", "T", "I", sections, [], [RUN])
    assert "Run 7: unknown" in (tmp_path / "outer.html").read_text()


def test_plots_have_real_text_and_ids_of_their_own():
    one, two = drawing(), drawing(0.5)
    assert one == drawing()
    assert ">impacts &lt; 10⁵</text>" in one
    assert "line 0 &amp; co" in one
    ids = [{part.split('"')[0] for part in text.split('id="')[1:]} for text in (one, two)]
    assert ids[0]
    assert not ids[0] & ids[1]


def test_lines_differ_in_greyscale():
    """Marker and dashes are unique, and the colors of neighbours differ in lightness."""
    grey = {(plots.style(i)["marker"], str(plots.style(i)["linestyle"])) for i in range(60)}
    assert len(grey) == 60
    lightness = []
    for color in plots.COLORS:
        red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
        lightness.append(0.2126 * red + 0.7152 * green + 0.0722 * blue)
    assert min(np.abs(np.diff(lightness))) > 0.05


def test_ticks_are_powers_of_ten():
    assert [plots.power_of_ten(v) for v in (1e-12, 0.01, 1.0, 1000.0, 1e6, 0.0)] == [
        "10⁻¹²",
        "0.01",
        "1",
        "1000",
        "10⁶",
        "",
    ]


SORT = """(function () {
  var table = document.querySelector("table.sortable"), heads = table.tHead.rows[0].cells;
  function names() { return Array.from(table.tBodies[0].rows).map(r => r.cells[0].textContent); }
  function sorts() { return Array.from(heads).map(h => h.getAttribute("aria-sort")); }
  var said = [[names(), sorts()]];
  [1, 1, 0].forEach(function (i) {
    var button = heads[i].querySelector("button");
    button.focus();
    button.click();
    said.push([names(), sorts(), document.activeElement === button]);
  });
  return said;
})()"""


@needs_browser
def test_a_click_sorts_and_empty_cells_stay_last(page, tmp_path):
    (before, up, down, by_name), console = look(page, tmp_path, SORT)
    assert console == []
    assert before == [["b", "a <b>", "c", "d"], [None] * 3]
    assert up == [["a <b>", "b", "d", "c"], [None, "ascending", None], True]
    assert down == [["d", "b", "a <b>", "c"], [None, "descending", None], True]
    assert by_name == [["a <b>", "b", "c", "d"], ["ascending", None, None], True]


WIDTHS = "[document.documentElement.scrollWidth, window.innerWidth]"


@needs_browser
def test_a_page_fits_a_phone(page, tmp_path):
    (needed, given), console = look(page, tmp_path, WIDTHS)
    assert given == 390
    assert needed <= 390
    assert console == []


@needs_browser
def test_the_browser_reports_what_goes_wrong(tmp_path):
    """The two tests before this one can fail."""
    write(
        tmp_path / "outer.html",
        '<div style="width:900px">x</div><script>nothing.here();</script>',
    )
    (needed, given), console = look(tmp_path / "outer.html", tmp_path, WIDTHS)
    assert given == 390
    assert needed > 900
    assert any("nothing is not defined" in line for line in console)

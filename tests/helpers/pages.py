"""Checks that every page of a report has to pass, and a browser to load it in."""

import html
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser

import pytest

VOID = {"meta", "link", "img", "br", "hr", "input", "source", "col", "wbr"}
LOADED = ("src", "href", "xlink:href", "data", "action", "poster", "srcset")
CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to load the pages in")


class Page(HTMLParser):
    """A parsed page; raises an AssertionError where tags do not match.

    Attributes:
        ids: the id of each element that has one.
        links: (tag, attribute, value) of everything that a browser could load or follow.
        tables: for each table, the number of cells in each row, headings included.
        figures: the text of each figure.
        text: all text except styles and scripts.
    """

    def __init__(self, path):
        super().__init__()
        self.open, self.ids, self.links = [], [], []
        self.tables, self.figures, self.text = [], [], ""
        self.source = path.read_text(encoding="utf-8")
        self.feed(self.source)
        self.close()
        assert self.open == [], f"{path}: not closed: {self.open}"

    def handle_starttag(self, tag, attributes):
        """Record an element and open it."""
        attributes = dict(attributes)
        if "id" in attributes:
            self.ids.append(attributes["id"])
        self.links += [(tag, name, attributes[name]) for name in LOADED if name in attributes]
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append(0)
        elif tag in ("td", "th"):
            self.tables[-1][-1] += 1
        elif tag == "figure":
            self.figures.append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        """Record an element that has no content."""
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        """Close the innermost open element, which must have this tag."""
        assert self.open, f"</{tag}> closes nothing, line {self.getpos()[0]}"
        assert self.open[-1] == tag, f"</{tag}> in {self.open}, line {self.getpos()[0]}"
        self.open.pop()

    def handle_data(self, data):
        """Collect text outside of styles and scripts."""
        if self.open and self.open[-1] in ("style", "script"):
            return
        self.text += data
        if "figure" in self.open:
            self.figures[-1] += data


def check_page(path):
    """Check that a page is well formed and self-contained, and return it as a `Page`.

    Each row of a table needs the same number of cells, and each figure has to name the run,
    the commit and the versions that it comes from.
    """
    page = Page(path)
    assert page.source.startswith("<!doctype html>")
    assert len(page.ids) == len(set(page.ids)), "an id twice"
    for tag, name, value in page.links:
        assert not re.match(r"(https?:)?//", value), f"{tag} {name}={value}"
        if tag not in ("a", "use"):
            assert value.startswith("data:"), f"{tag} {name}={value} is another file"
    assert not re.search(r"@import|url\(\s*[\"']?(https?:)?//", page.source)
    for number, cells in enumerate(page.tables):
        assert len(set(cells)) <= 1, f"table {number}: cells by row {cells}"
    for text in page.figures:
        assert "How it was made" in text
        assert re.search(r"Run \d+: .+, commit \w+", text), text[-300:]
        assert "numba" in text
    assert "Known limits, and what was left out" in page.text
    return page


def look(path, folder, script="true", width=390):
    """Load a page in a browser, in a frame of a given width, and run a script in it.

    Args:
        path: file of the page; it is not changed.
        folder: for the copy of the page and the profile of the browser.
        script: a JavaScript expression whose value can be written as JSON.
        width: of the frame [px]; the window of a headless browser is wider than a phone.

    Returns:
        The value of the script, and the lines that the browser wrote on its console.
    """
    source = path.read_text(encoding="utf-8")
    say = (
        "<script>window.addEventListener('load', function () {"
        f"parent.postMessage(JSON.stringify({script}), '*');}});</script>"
    )
    copy, frame = folder / f"copy-{path.name}", folder / f"frame-{path.name}"
    copy.write_text(source.replace("</body>", say + "</body>"), encoding="utf-8")
    frame.write_text(
        "<!doctype html><body><pre></pre><script>window.onmessage = function (event) {"
        "document.querySelector('pre').textContent = event.data;};</script>"
        f'<iframe src="{copy.name}" style="width:{width}px;height:900px;border:0"></iframe>'
        "</body>",
        encoding="utf-8",
    )
    command = [
        CHROMIUM,
        *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"),
        *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
        *("--disable-dev-shm-usage", "--enable-logging=stderr", "--v=0"),
        "--virtual-time-budget=3000",
        f"--user-data-dir={folder / 'profile'}",
        "--dump-dom",
        frame.as_uri(),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    answer = _first_pre(done.stdout)
    assert answer, f"the page returned nothing: {done.stderr[-2000:]}"
    return json.loads(answer), console


def _first_pre(dom):
    """Return the text of the first <pre>, unescaped."""
    found = re.search(r"<pre>(.*?)</pre>", dom, re.DOTALL)
    return html.unescape(found[1]) if found else ""

"""The documentation builds without a warning, and its pages work alone and without a network."""

import importlib.util
import inspect
import json
import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import izo_ref
from tests.helpers.pages import CHROMIUM, Page, needs_browser

ROOT = Path(__file__).parents[2]
MISSING = [name for name in ("sphinx", "furo", "myst_parser") if not importlib.util.find_spec(name)]
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}")


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """Folder of the pages; fails on any warning of the build."""
    folder = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-b", "html"]
    command += ["-d", str(folder / "trees"), "docs", str(folder / "html")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "html"


def pages_of(folder):
    return sorted(folder.rglob("*.html"))


@cache
def parsed(path):
    return Page(path)


def test_pages_are_well_formed(built):
    assert len(pages_of(built)) > 20
    for path in pages_of(built):
        page = parsed(path)
        assert len(page.ids) == len(set(page.ids)), f"{path}: an id twice"
        assert "system-message" not in page.source, path


def test_every_link_leads_somewhere(built):
    followed = 0
    for path in pages_of(built):
        for tag, name, value in parsed(path).links:
            link = urlsplit(value)
            if tag != "a" or link.scheme:
                continue
            target = (path.parent / unquote(link.path)).resolve() if link.path else path
            assert target.is_file(), f"{path}: {tag} {name}={value}"
            if link.fragment and target.suffix == ".html":
                assert unquote(link.fragment) in parsed(target).ids, f"{path}: {value}"
                followed += 1
    assert followed > 100


def test_pages_load_nothing_from_elsewhere(built):
    for path in pages_of(built):
        for tag, name, value in parsed(path).links:
            if tag in ("a", "use") or value.startswith("data:"):
                continue
            link = urlsplit(value)
            assert link.scheme + link.netloc == "", f"{path}: {tag} {name}={value}"
            if link.path:
                assert (path.parent / unquote(link.path)).is_file(), f"{path}: {tag} {value}"
    for path in built.rglob("*.css"):
        style = path.read_text(encoding="utf-8")
        assert not re.search(r"@import|url\(\s*[\"']?(https?:)?//", style), path


def test_the_reference_has_every_public_name(built):
    ids = parsed(built / "api.html").ids
    names = set(izo_ref.__all__) - {"__version__", "errors"}
    assert names - {name.removeprefix("izo_ref.") for name in ids} == set()
    errors = {
        name
        for name, value in vars(izo_ref.errors).items()
        if inspect.isclass(value) and issubclass(value, izo_ref.IzoError)
    }
    documented = {name.rpartition(".")[2] for name in ids if name.startswith("izo_ref.")}
    assert errors - documented == set()


def test_sections_of_the_method_have_the_numbers_that_the_code_cites(built):
    pages = sorted((built / "method").glob("[0-9]-*.html"))
    assert len(pages) == 8
    for number, path in enumerate(pages, 1):
        assert path.name.startswith(f"{number}-")
        heading = re.search(r"<h1>(.*?)<a", parsed(path).source, re.DOTALL)
        assert re.sub("<.*?>", "", heading[1]).startswith(f"{number}. ")
    for folder in ("izo_ref", "validation"):
        for path in (ROOT / folder).rglob("*.py"):
            for cited in re.findall(r"docs/method,? sections? (\d+)", path.read_text("utf-8")):
                assert 1 <= int(cited) <= 8, f"{path} cites section {cited} of the method"


def test_every_example_is_shown(built):
    text = parsed(built / "examples.html").text
    paths = sorted((ROOT / "examples").glob("*.py"))
    assert len(paths) >= 4
    for path in paths:
        assert path.name in text


REPORT = """<script>window.addEventListener('load', function () { setTimeout(function () {
    var maths = Array.from(document.querySelectorAll('math'));
    var boxes = [document.documentElement].concat(
        Array.from(document.querySelectorAll('.content')));
    parent.postMessage({
        page: document.title,
        overflow: Math.max(...boxes.map(function (b) { return b.scrollWidth - b.clientWidth; })),
        flat: maths.filter(function (m) { return !m.getBoundingClientRect().width; }).length,
        found: document.querySelectorAll('ul.search li').length,
    }, '*');
}, 100); });</script></body>"""

VISIT = """<!doctype html><body><pre></pre><script>
    var pages = %s, reports = [], frame;
    function next() {
        if (frame) frame.remove();
        if (reports.length === pages.length) {
            document.querySelector('pre').textContent = JSON.stringify(reports);
            return;
        }
        frame = document.createElement('iframe');
        frame.style = 'width:%dpx;height:900px;border:0';
        frame.src = pages[reports.length];
        document.body.append(frame);
    }
    window.onmessage = function (event) { reports.push(event.data); next(); };
    next();
</script></body>"""


def visit(built, folder, width):
    """Load a copy of every page, one after the other, in one browser without a network.

    Returns:
        {page: what its script reported}, and the lines that the browser wrote on its console.
    """
    copy = shutil.copytree(built, folder / "html")
    names = [str(path.relative_to(copy)) for path in pages_of(copy)]
    for name in names:
        source = (copy / name).read_text(encoding="utf-8")
        (copy / name).write_text(source.replace("</body>", REPORT), encoding="utf-8")
    names += ["search.html?q=certificate"]
    frame = copy / "visit.html"
    frame.write_text(VISIT % (json.dumps(names), width), encoding="utf-8")
    command = [
        CHROMIUM,
        *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"),
        *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
        *("--disable-dev-shm-usage", "--enable-logging=stderr", "--v=0"),
        *("--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=120000"),
        f"--user-data-dir={folder / 'profile'}",
        "--dump-dom",
        frame.as_uri(),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    written = re.search(r"<pre>(.*?)</pre>", done.stdout, re.DOTALL)[1]
    assert written, f"the pages reported nothing: {done.stderr[-2000:]}"
    return dict(zip(names, json.loads(written), strict=True)), console


@needs_browser
@pytest.mark.parametrize("width", [390, 1280])
def test_every_page_works_in_a_browser(built, tmp_path, width):
    reports, console = visit(built, tmp_path, width)
    assert console == []
    for name, report in reports.items():
        assert report["overflow"] <= 0, f"{name}: something is wider than its box at {width} px"
        assert report["flat"] == 0, f"{name} has an equation that is not drawn"
    assert reports["search.html?q=certificate"]["found"] > 0

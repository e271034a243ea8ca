"""HTML pages: one file each that needs no network, tables that sort, figures with their origin."""

import html
import json
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from izo_ref.app.files import replacing
from validation.report.tables import cell_text
from validation.rows import Columns, Row

# Short names of the pages, for their navigation.
PAGES = {
    "index": "Overview",
    "inner": "Inner",
    "outer": "Outer",
    "convergence": "Convergence",
    "scaling": "Scaling",
}
ORIGIN = re.compile(r"<!--origin ([\d ]*)-->")
NOT_MEASURED = "<p class=missing>Not measured yet.</p>"


def write_page(
    path: Path,
    title: str,
    intro: str,
    sections: Iterable[tuple[str, str]],
    limits: Iterable[str],
    runs: Iterable[Row],
) -> None:
    """Write a page.

    Args:
        path: The HTML file; its stem is one of PAGES.
        title: Plain text.
        intro: Plain text that says what the page answers.
        sections: Headings and HTML in order; `figure`, `data_table` and `paragraph` return HTML.
        limits: Sentences in plain text: the known limits, and what was left out and why.
        runs: The runs of `validation.rows.runs`; each figure shows those that measured its rows.
    """
    parts = [f"<h1>{html.escape(title)}</h1>", paragraph(intro)]
    parts += [
        f"<section>\n<h2>{html.escape(name)}</h2>\n{body}\n</section>" for name, body in sections
    ]
    items = "\n".join(f"<li>{html.escape(sentence)}</li>" for sentence in limits)
    parts.append(
        f"<section>\n<h2>Known limits, and what was left out</h2>\n<ul>{items}</ul>\n</section>"
    )
    by_id = {run["run"]: run for run in runs}
    body = ORIGIN.sub(lambda match: _origin(match[1], by_id), "\n".join(parts))
    content = PAGE.format(
        title=html.escape(title), nav=_nav(path.stem), style=STYLE, script=SCRIPT, body=body
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write(content.encode())


def paragraph(text: str) -> str:
    """Return plain text as a paragraph."""
    return f"<p>{html.escape(text)}</p>"


def run_ids(rows: Iterable[Row]) -> list[int]:
    """Return the ids of the runs that measured these rows, in order."""
    return sorted({row["run"] for row in rows if row.get("run") is not None})


def figure(svg: str, caption: str, run_ids: Iterable[int]) -> str:
    """Return a plot with its caption and its origin.

    Args:
        svg: A plot of `plots.svg`, or several of `panels`.
        caption: Plain text; a screen reader reads it too.
        run_ids: Ids of the runs that measured the rows; `write_page` describes them below.
    """
    label = html.escape(caption, quote=True)
    if "aria-label" not in svg:  # panels have their own
        svg = svg.replace('role="img"', f'role="img" aria-label="{label}"', 1)
    ids = " ".join(map(str, run_ids))
    return (
        f'<figure>\n<div class="scroll" tabindex="0" role="group" aria-label="Plot">\n{svg}\n'
        f"</div>\n<figcaption>{html.escape(caption)}\n<!--origin {ids}--></figcaption>\n</figure>"
    )


def panels(svgs: Iterable[str], labels: Iterable[str], least_px: int = 290) -> str:
    """Return plots side by side, as far as there is room, for `figure`.

    Args:
        svgs: Plots of `plots.svg`.
        labels: Plain text for a screen reader, one for each plot.
        least_px: Least width of a plot; the next plot starts a new line if it has less room.
    """
    named = (
        svg.replace('role="img"', f'role="img" aria-label="{html.escape(label, quote=True)}"', 1)
        for svg, label in zip(svgs, labels, strict=True)
    )
    columns = f"grid-template-columns:repeat(auto-fill,minmax(min(100%,{least_px}px),1fr))"
    return f'<div class="panels" style="{columns}">\n' + "\n".join(named) + "\n</div>"


def data_table(columns: Columns, rows: Iterable[Row], caption: str = "") -> str:
    """Return a table that a click on a heading sorts.

    Args:
        columns: By heading, a key of the row or a function that computes the cell.
        rows: One for each line.
        caption: Plain text above the table.
    """
    head = "".join(
        f'<th scope="col"><button type="button">{html.escape(name)}</button></th>'
        for name in columns
    )
    lines = []
    for row in rows:
        values = (row.get(c) if isinstance(c, str) else c(row) for c in columns.values())
        lines.append("<tr>" + "".join(map(_cell, values)) + "</tr>")
    title = f"<caption>{html.escape(caption)}</caption>" if caption else ""
    label = html.escape(caption or "Table", quote=True)
    return (
        f'<div class="scroll" tabindex="0" role="group" aria-label="{label}">\n'
        f'<table class="sortable">{title}\n<thead><tr>{head}</tr></thead>\n<tbody>\n'
        + "\n".join(lines)
        + "\n</tbody>\n</table>\n</div>"
    )


def folded(summary: str, body: str) -> str:
    """Return HTML that a click on the summary shows."""
    return f"<details>\n<summary>{html.escape(summary)}</summary>\n{body}\n</details>"


def _cell(value: Any) -> str:
    """Return a cell; a number is aligned to the right, with the value that it is sorted by."""
    content = html.escape(cell_text(value))
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return f"<td>{content}</td>"
    if math.isnan(value):
        return '<td class="n"></td>'
    key = json.dumps(value) if math.isfinite(value) else repr(math.copysign(1e308, value))
    return f'<td class="n" data-v="{key}">{content}</td>'


def _origin(ids: str, runs: dict[int, Row]) -> str:
    """Return command, commit, machine and versions of the runs, folded."""
    items = []
    for number in map(int, ids.split()):
        run = runs.get(number)
        if run is None:
            items.append(f"<p>Run {number}: unknown.</p>")
            continue
        items.append(
            f"<p>Run {number}: <code>{html.escape(str(run['command']))}</code>, commit "
            f"{html.escape(str(run['commit']))}, {html.escape(str(run['machine']))}, "
            f"{html.escape(str(run['versions']))}, begun {html.escape(str(run['started']))}.</p>"
        )
    body = "\n".join(items) or "<p>No rows.</p>"
    return f'<details class="origin"><summary>How it was made</summary>\n{body}\n</details>'


def _nav(own: str) -> str:
    links = []
    for stem, name in PAGES.items():
        here = ' aria-current="page"' if stem == own else ""
        links.append(f'<a href="{stem}.html"{here}>{name}</a>')
    return "\n".join(links)


STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff;
  max-width: 1100px; margin: 0 auto; padding: 1rem; overflow-wrap: break-word; }
nav { display: flex; flex-wrap: wrap; gap: .25rem 1.2rem; padding-bottom: .5rem;
  border-bottom: 1px solid #e4e4e4; }
nav a { color: #444; text-decoration: none; padding: .25rem 0; }
nav a[aria-current] { color: #000; font-weight: 600; box-shadow: 0 2px #0b3c6f; }
a { color: #0b3c6f; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 1.2rem 0 .6rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .5rem; }
p, li { max-width: 46rem; }
.scroll { overflow-x: auto; }
.scroll:focus-visible, button:focus-visible { outline: 2px solid #0b3c6f; outline-offset: 2px; }
table { border-collapse: collapse; min-width: 60%; margin: .8rem 0; font-size: .92rem; }
caption { text-align: left; color: #555; padding: .2rem 0; }
th, td { border-bottom: 1px solid #e4e4e4; padding: .3rem .6rem .3rem 0; text-align: left;
  vertical-align: top; white-space: nowrap; }
td.n { text-align: right; font-variant-numeric: tabular-nums; padding-right: 1.4rem; }
th button { font: inherit; font-weight: 600; color: inherit; background: none; border: 0;
  padding: .2rem 0; text-align: left; cursor: pointer; }
th button::after { content: "\\2195"; color: #aaa; padding-left: .3em; }
th[aria-sort=ascending] button::after { content: "\\2191"; color: #222; }
th[aria-sort=descending] button::after { content: "\\2193"; color: #222; }
.panels { display: grid; gap: .5rem 1rem; }
figure { margin: 1rem 0 1.8rem; }
figcaption { font-size: .9rem; color: #555; max-width: 46rem; }
details { margin: .5rem 0; }
summary { cursor: pointer; color: #555; }
.origin { margin: .2rem 0; }
.origin p { margin: .3rem 0; }
.missing { color: #777; font-style: italic; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(12rem, 1fr));
  gap: 1.2rem 1.5rem; margin: 1.5rem 0; }
.tiles > * { border-top: 2px solid #0b3c6f; padding-top: .5rem; }
.tiles .label { color: #555; font-size: .9rem; }
.tiles .value { font-size: 1.9rem; line-height: 1.2; font-variant-numeric: tabular-nums; }
.tiles .said { font-size: .95rem; margin: .2rem 0; }
@media print { nav { display: none; } .scroll { overflow: visible; } }
"""

SCRIPT = """
document.querySelectorAll("table.sortable").forEach(function (table) {
  var heads = Array.from(table.tHead.rows[0].cells), body = table.tBodies[0];
  function key(row, i) {
    var cell = row.cells[i];
    if (cell.dataset.v !== undefined) return Number(cell.dataset.v);
    return cell.textContent === "" ? null : cell.textContent;
  }
  function compare(a, b) {
    if (typeof a === "number" && typeof b === "number") return a - b;
    return String(a).localeCompare(String(b), "en", {numeric: true});
  }
  heads.forEach(function (head, i) {
    head.querySelector("button").addEventListener("click", function () {
      var down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach(function (other) { other.removeAttribute("aria-sort"); });
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      var rows = Array.from(body.rows).sort(function (r, s) {
        var a = key(r, i), b = key(s, i);
        if (a === null || b === null) return (a === null) - (b === null);  // empty cells last
        return down ? compare(b, a) : compare(a, b);
      });
      rows.forEach(function (row) { body.appendChild(row); });
    });
  });
});
"""

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<nav aria-label="Pages">
{nav}
</nav>
<main>
{body}
</main>
<script>{script}</script>
</body>
</html>
"""

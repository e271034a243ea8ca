"""Pages of a report: one file each, no network; tables that sort, figures with their origin."""

import html
import json
import math
import re
from pathlib import Path

from izo_ref.app.files import replacing
from validation.report.tables import text

PAGES = {
    "index": "Where it stands",
    "inner": "Inner",
    "outer": "Outer",
    "convergence": "Convergence",
    "scaling": "Scaling",
}
ORIGIN = re.compile(r"<!--origin ([\d ]*)-->")
NOT_MEASURED = "<p class=missing>Not measured yet.</p>"


def write_page(path, title, intro, sections, limits, runs):
    """Write a page.

    Args:
        path: of the HTML file; its stem is one of PAGES.
        title: plain text.
        intro: plain text, what the page answers.
        sections: (heading, HTML) in order, as of `figure`, `data_table`, `paragraph`.
        limits: sentences in plain text: known limits, what was left out and why.
        runs: dictionaries as of `rows.runs`; those that a figure names are told under it.
    """
    path = Path(path)
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


def paragraph(sentence) -> str:
    """Plain text as a paragraph."""
    return f"<p>{html.escape(sentence)}</p>"


def run_ids(rows) -> list[int]:
    """The runs that rows came from, in order."""
    return sorted({row["run"] for row in rows if row.get("run") is not None})


def figure(svg, caption, run_ids) -> str:
    """A plot with its caption and what made it.

    Args:
        svg: as of `plots.svg`, or of `panels`.
        caption: plain text; also what a screen reader says.
        run_ids: of `run_ids`; `write_page` tells them under the caption.
    """
    label = html.escape(caption, quote=True)
    if "aria-label" not in svg:  # panels have their own
        svg = svg.replace('role="img"', f'role="img" aria-label="{label}"', 1)
    ids = " ".join(map(str, run_ids))
    return (
        f'<figure>\n<div class="scroll" tabindex="0" role="group" aria-label="Plot">\n{svg}\n'
        f"</div>\n<figcaption>{html.escape(caption)}\n<!--origin {ids}--></figcaption>\n</figure>"
    )


def panels(svgs, labels, least_px=290) -> str:
    """Plots side by side where there is room, for `figure`.

    Args:
        svgs: as of `plots.svg`.
        labels: plain text for a screen reader, one each.
        least_px: width of a plot before it gets a line of its own.
    """
    named = (
        svg.replace('role="img"', f'role="img" aria-label="{html.escape(label, quote=True)}"', 1)
        for svg, label in zip(svgs, labels, strict=True)
    )
    columns = f"grid-template-columns:repeat(auto-fill,minmax(min(100%,{least_px}px),1fr))"
    return f'<div class="panels" style="{columns}">\n' + "\n".join(named) + "\n</div>"


def data_table(columns, rows, caption="") -> str:
    """A table that a click on a heading sorts.

    Args:
        columns: {heading: key, or function of a row}; numbers as `tables.text` writes them.
        rows: dictionaries.
        caption: plain text above it.
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


def folded(summary, body) -> str:
    """HTML that a click on the summary shows."""
    return f"<details>\n<summary>{html.escape(summary)}</summary>\n{body}\n</details>"


def _cell(value):
    """Numbers to the right, with the value that they are sorted by."""
    content = html.escape(text(value))
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return f"<td>{content}</td>"
    if math.isnan(value):
        return '<td class="n"></td>'
    key = json.dumps(value) if math.isfinite(value) else repr(math.copysign(1e308, value))
    return f'<td class="n" data-v="{key}">{content}</td>'


def _origin(ids, runs):
    """Command, commit, machine and versions of the runs, folded."""
    told = []
    for number in map(int, ids.split()):
        run = runs.get(number)
        if run is None:
            told.append(f"<p>Run {number}: unknown.</p>")
            continue
        told.append(
            f"<p>Run {number}: <code>{html.escape(str(run['command']))}</code>, commit "
            f"{html.escape(str(run['commit']))}, {html.escape(str(run['machine']))}, "
            f"{html.escape(str(run['versions']))}, begun {html.escape(str(run['started']))}.</p>"
        )
    body = "\n".join(told) or "<p>No rows.</p>"
    return f'<details class="origin"><summary>How it was made</summary>\n{body}\n</details>'


def _nav(own):
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
        if (a === null || b === null) return (a === null) - (b === null);  // empty ones last
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

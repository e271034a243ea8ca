"""The report as a whole: run what is missing, write every page, and the page to begin with."""

import html
import time
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from validation import rows
from validation.report import site

STUDIES = ("inner", "outer", "convergence", "scaling")
QUESTIONS = {
    "inner": "Error against time of each method on one zone, next to other solvers.",
    "outer": "Objective against CPU time of a whole step, by selection, thickness and tolerance.",
    "convergence": "Objective, violation and new impacts by iteration.",
    "scaling": "Time and memory against triangles and against impacts.",
}
OTHERS = {
    "evidence/README.md": "every step file, judged by four judges",
    "zones.md": "solvers of zones against exact optima",
    "speed/README.md": "detection, whole steps, cold start, size, what each rule saves",
    "cuda/README.md": "what kernels need of a GPU, and what they were measured to take",
    "mutants.md": "deliberate faults, and whether the tests notice",
}
HEADLINES = 5
LOG = "report.log"  # beside the rows: what the runs said, and how long each study took


def write_report(output, command, quick, only, pages_only, say):
    """Run the studies, resuming, and write the pages.

    Args:
        output: folder of the pages; rows are in `rows/` there.
        command: that the pages name.
        quick: fewer and smaller cases.
        only: one of STUDIES, or None for all.
        pages_only: measure nothing.
        say: called with a line of progress.

    Returns:
        `Path` of the start page.
    """
    import_module("matplotlib")  # if it is missing, say so before measuring
    output = Path(output)
    folder = output / "rows"
    wanted = [only] if only else list(STUDIES)
    if not pages_only:
        run = rows.begin_run(folder, command, quick)
        with (folder / LOG).open("a") as log:
            tell = _teller(say, log)
            tell(f"run {run}: {command}")
            for name in wanted:
                study = _module("study", name)
                if study is not None:
                    begin = time.perf_counter()
                    study.run(folder, quick, tell)
                    tell(f"{name}: done in {time.perf_counter() - begin:.0f} s")
    for name in wanted:
        _write_page(name, folder, output)
    for name in set(STUDIES) - set(wanted):
        if not (output / f"{name}.html").is_file():
            _write_page(name, folder, output)
    _start_page(folder, output)
    return output / "index.html"


def _teller(say, log):
    """`say`, which also writes to a file, line by line."""

    def tell(line):
        say(line)
        print(line, file=log, flush=True)

    return tell


def _module(kind, name):
    """A study or a page; None if this version has none of that name."""
    full = f"validation.{kind}.{name}"
    return import_module(full) if find_spec(full) else None


def _write_page(name, folder, output):
    module = _module("report", name)
    if module is not None:
        module.page(folder, output)
        return
    path = output / f"{name}.html"
    sections = [("Rows", site.NOT_MEASURED)]
    site.write_page(path, site.PAGES[name], QUESTIONS[name], sections, ["Nothing is here yet."], [])


def _start_page(folder, output):
    pages = "\n".join(
        f'<li><a href="{name}.html">{site.PAGES[name]}</a>: {html.escape(QUESTIONS[name])}</li>'
        for name in STUDIES
    )
    others = "\n".join(
        f'<li><a href="{path}">{path}</a>: {what}</li>'
        if (output / path).is_file()
        else f"<li>{path}: {what} (not in this folder)</li>"
        for path, what in OTHERS.items()
    )
    sections = [
        ("In five figures", _tiles(folder)),
        ("Pages", f"<ul>{pages}</ul>"),
        ("Other reports", f"<ul>{others}</ul>"),
        ("Runs", _runs(folder) + site.paragraph(f"What they said: rows/{LOG}.")),
    ]
    known = rows.runs(folder)
    quick = [run for run in known if run["quick"]]
    limits = [
        "Figures are taken from the pages, where their limits are told.",
        "Times are of the machine named, which other work may have shared.",
    ]
    if quick:
        limits.append("This is a quick report: few and small cases, which show that it works.")
    site.write_page(
        output / "index.html",
        "Error against run time",
        "How close izo_ref comes to the optimum, and how long it takes: one zone, a whole step, "
        "by iteration and by size.",
        sections,
        limits,
        known,
    )


def _tiles(folder):
    """Five headlines: the first of each page, then second ones; a page without any says so."""
    first, later = [], []
    for name in STUDIES:
        module = _module("report", name)
        found = list(module.headlines(folder)) if module is not None else []
        first.append((name, found[0]) if found else (name, None))
        later += [(name, headline) for headline in found[1:]]
    tiles = first + later[: HEADLINES - len(first)]
    return '<div class="tiles">\n' + "\n".join(_tile(*tile) for tile in tiles) + "\n</div>"


def _tile(name, headline):
    label, value, said = headline or (site.PAGES[name], "–", "Not measured yet.")
    return (
        f'<div><div class="label">{html.escape(label)}</div>'
        f'<div class="value">{html.escape(value)}</div>'
        f'<p class="said">{html.escape(said)} '
        f'<a href="{name}.html">{site.PAGES[name]}</a></p></div>'
    )


def _runs(folder):
    columns = {name: name for name in ("run", "command", "commit", "quick", "started", "machine")}
    known = rows.runs(folder)
    return (
        site.data_table(columns, known, "Runs that rows came from")
        if known
        else (site.NOT_MEASURED)
    )

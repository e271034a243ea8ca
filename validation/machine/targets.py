"""The commands that are killed, and how each output says that it is whole."""

from __future__ import annotations

import csv
import io
import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from izo_ref.base.errors import IzoError
from izo_ref.porting.files import wrong_files
from izo_ref.porting.trace_files import INDEX, load_arrays, load_index

# Reads an output, and returns what is the same in every run; raises an error if it is not whole.
Reader = Callable[[Path], object]


class Target(NamedTuple):
    """A command to kill.

    Attributes:
        name: What the rows call it.
        module: What `python -m` runs.
        words: Its words; `{step}` is the step, and `{work}` the folder of the outputs.
        outputs: How each output is read, by its name in that folder.
        exits: Exit codes of a run that was not killed.
        places: Variables of modules that name a file or folder of the checkout, if the command
            writes into it: by module and variable, the path in a copy of the checkout.
        stale: Text in the output that is changed before, so that the command changes it back.
    """

    name: str
    module: str
    words: tuple[str, ...]
    outputs: dict[str, Reader]
    exits: tuple[int, ...] = (0,)
    places: Mapping[tuple[str, str], str] = MappingProxyType({})
    stale: str = ""

    @property
    def in_copy(self) -> bool:
        """Whether the command writes into a copy of the checkout."""
        return bool(self.places)


def arrays_of(path: Path) -> object:
    """Read an archive of arrays."""
    with np.load(path, allow_pickle=False) as archive:
        return {name: archive[name].tobytes() for name in sorted(archive.files)}


def shape_of_json(path: Path) -> object:
    """Read JSON; times differ, so only the names are the same in every run."""
    content = json.loads(path.read_text())
    return sorted(content) if isinstance(content, dict) else content


def page_of(path: Path) -> object:
    """Read a page in HTML, which has to end."""
    text = path.read_text().rstrip()
    if not text.endswith("</html>"):
        raise ValueError("the page does not end")
    return True


def text_of(path: Path) -> object:
    """Read a text."""
    return path.read_text()


def vectors_of(path: Path) -> object:
    """Read a folder of vectors, whose files have the sums that one of them lists."""
    wrong = wrong_files(path)
    if wrong:
        raise ValueError(wrong[0])
    return sorted(file.name for file in path.iterdir())


def trace_of(path: Path) -> object:
    """Read a trace: each file is whole, and with an index, each array is there."""
    arrays = load_arrays(path)
    if not (path / INDEX).is_file():
        return None  # a run that did not end, as the page says
    missing = load_index(path)["arrays"].keys() - arrays.keys()
    if missing:
        raise ValueError(f"{len(missing)} arrays are missing")
    return sorted(arrays)


def rows_of(path: Path) -> object:
    """Read the lines of rows up to the last line break, which is what a study goes on from."""
    text = path.read_text()
    lines = list(csv.reader(io.StringIO(text[: text.rfind("\n") + 1])))
    if any(len(line) != len(lines[0]) for line in lines):
        raise ValueError("a line has another number of cells than the first one")
    return True


NOT_WHOLE = (ValueError, OSError, KeyError, EOFError, IzoError)  # what readers raise

STEP = "{step}"
CASE = "S9-multipliers-not-clamped-02"
TARGETS = (
    Target(
        "izo resolve",
        "izo_ref.app.cli",
        ("resolve", STEP, "-o", "{work}/o.npz", "--json", "{work}/o.json", "--trace", "{work}/t"),
        {"o.npz": arrays_of, "o.json": shape_of_json, "t": trace_of},
    ),
    Target(
        "izo certify",
        "izo_ref.app.cli",
        ("certify", STEP, "--json", "{work}/c.json"),
        {"c.json": shape_of_json},
        (1,),
    ),
    Target(
        "izo demo",
        "izo_ref.app.cli",
        ("demo", "-o", "{work}/demo"),
        {"demo/index.html": page_of},
    ),
    Target(
        "izo vectors make",
        "validation.machine.small_vectors",
        ("{work}/vectors",),
        {"vectors": vectors_of},
    ),
    Target(
        "izo conform",
        "izo_ref.app.cli",
        (
            *(
                "conform",
                "--exec",
                f"{sys.executable} -m tests.ports.own",
                "--case",
                CASE,
                "--seconds",
                "120",
            ),
            *("--json", "{work}/r.json", "--html", "{work}/r.html"),
            *("--write-failures", "{work}/known.txt"),
        ),
        {"r.json": shape_of_json, "r.html": page_of, "known.txt": text_of},
    ),
    Target(
        "validation check",
        "validation",
        ("check", STEP, "--json", "{work}/v.json", "--html", "{work}/v.html"),
        {"v.json": shape_of_json, "v.html": page_of},
    ),
    Target(
        "study",
        "validation.machine.small_study",
        ("{work}/study",),
        {
            "study/runs.csv": rows_of,
            "study/small.csv": rows_of,
            "study/small.json": text_of,
            "study/small.md": text_of,
        },
    ),
    Target(
        "validation house --write",
        "validation",
        ("house", "--write"),
        {"README.md": text_of},
        places={("validation.house", "ROOT"): ""},
        stale="What people touch",
    ),
    Target(
        "validation readme",
        "validation",
        ("readme",),
        {"reports/README.md": text_of},
        places={("validation.report.readme", "README"): "reports/README.md"},
        stale="| report | figure | ",
    ),
    Target(
        "validation guide",
        "validation",
        ("guide",),
        {"docs/porting-stages.md": text_of},
        places={("validation.provenance", "ROOT"): ""},
        stale="| | name | shape |",
    ),
)

"""Directives that show what the code says while the documentation is built, so it cannot drift.

`command-help` takes a command and shows what it prints for --help. `rules-table` shows the rules
by which work is left out. `scenes-table` shows the steps of data/scenes/.
"""

import contextlib
import io
import json
import os
from importlib import import_module
from pathlib import Path
from unittest import mock

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

# The function that each command runs, without its name in the arguments.
COMMANDS = {
    "izo": "izo_ref.app.cli",
    "python -m validation": "validation.__main__",
}


class CommandHelp(SphinxDirective):
    """The output of `COMMAND --help`."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Return the nodes that stand for the directive."""
        words = self.arguments[0]
        name = next(name for name in COMMANDS if f"{words} ".startswith(f"{name} "))
        main = import_module(COMMANDS[name]).main
        out = io.StringIO()
        with (
            mock.patch.dict(os.environ, COLUMNS="80"),
            contextlib.redirect_stdout(out),
            contextlib.suppress(SystemExit),
        ):
            main([*words.removeprefix(name).split(), "--help"])
        return [nodes.literal_block(text=out.getvalue(), language="text")]


class Table(SphinxDirective):
    """A table whose rows, in Markdown, come from the method `rows`."""

    heading: tuple[str, ...]

    def run(self) -> list[nodes.Node]:
        """Return the nodes that stand for the directive."""
        lines = [self.heading, ["---"] * len(self.heading), *self.rows()]
        container = nodes.Element()
        text = StringList([f"| {' | '.join(cells)} |" for cells in lines])
        self.state.nested_parse(text, self.content_offset, container)
        return container.children


class RulesTable(Table):
    """The names and meanings of `izo_ref.base.options.RULES`."""

    heading = ("rule", "what it leaves out")

    def rows(self) -> list[tuple[str, ...]]:
        """Return the lines of the table below its heading."""
        rules = import_module("izo_ref.base.options").RULES
        return [(f"`{name}`", meaning) for name, meaning in rules.items()]


class ScenesTable(Table):
    """The steps that data/scenes/index.json describes."""

    heading = ("file", "what happens", "vertices", "triangles")

    def rows(self) -> list[tuple[str, ...]]:
        """Return the lines of the table below its heading."""
        index = Path(__file__).parents[2] / "data" / "scenes" / "index.json"
        scenes = json.loads(index.read_text(encoding="utf-8"))
        return [
            (f"`{name}.npz`", scene["what"], f"{scene['vertices']:,}", f"{scene['triangles']:,}")
            for name, scene in scenes.items()
        ]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.add_directive("command-help", CommandHelp)
    app.add_directive("rules-table", RulesTable)
    app.add_directive("scenes-table", ScenesTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""A directive that shows every program of examples/."""

from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FOLDER = Path(__file__).parents[2] / "examples"


class Examples(SphinxDirective):
    """One section for each program, in the order of their names."""

    def run(self) -> list[nodes.Node]:
        """Return the nodes of the sections."""
        sections = []
        for path in sorted(FOLDER.glob("*.py")):
            self.env.note_dependency(str(path))
            source = path.read_text(encoding="utf-8")
            section = nodes.section("", nodes.title("", path.name), ids=[path.stem])
            section += nodes.literal_block(text=source, language="python")
            sections.append(section)
        return sections


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.add_directive("examples", Examples)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

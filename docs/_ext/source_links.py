"""A role that names code and links to it: {source}`izo_ref/loop/resolve.py:resolve`.

The build fails if the file or the name is not there, so references follow every move of the
code. Files that are referred to become pages of the documentation.
"""

import ast
from functools import cache
from html import escape
from pathlib import Path

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxRole

ROOT = Path(__file__).parents[2]


class SourceRole(SphinxRole):
    """`path` or `path:name`, with the path from the root of the repository."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Return a link to the page that shows the source."""
        path, _, name = self.text.partition(":")
        text = path.removeprefix("izo_ref/") + (f": {name}" if name else "")
        literal = nodes.literal(self.rawtext, text)
        if not (ROOT / path).is_file():
            return [literal], [self._problem(f"no file {path}")]
        if name and name not in _lines_of_names(path):
            return [literal], [self._problem(f"{path} defines no {name}")]
        if not hasattr(self.env, "izo_sources"):
            self.env.izo_sources = set()
        self.env.izo_sources.add(path)
        uri = self.env.app.builder.get_relative_uri(self.env.docname, _page_of(path))
        anchor = f"#line-{_lines_of_names(path)[name]}" if name else ""
        return [nodes.reference("", "", literal, refuri=uri + anchor, internal=True)], []

    def _problem(self, message):
        return self.inliner.reporter.error(f"source: {message}", line=self.lineno)


def _page_of(path):
    return "_source/" + path.removesuffix(".py")


@cache
def _lines_of_names(path):
    """Line of each function, class, method (`Class.method`) and constant of a module."""
    lines = {}

    def collect(body, prefix):
        for node in body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                lines[prefix + node.name] = node.lineno
                if isinstance(node, ast.ClassDef):
                    collect(node.body, f"{prefix}{node.name}.")
            elif isinstance(node, ast.Assign):
                names = [n.id for t in node.targets for n in ast.walk(t) if isinstance(n, ast.Name)]
                lines.update({prefix + name: node.lineno for name in names})
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                lines[prefix + node.target.id] = node.lineno

    collect(ast.parse((ROOT / path).read_text(encoding="utf-8")).body, "")
    return lines


def _source_pages(app):
    for path in sorted(getattr(app.env, "izo_sources", ())):
        formatter = HtmlFormatter(linenos="inline", lineanchors="line", anchorlinenos=False)
        code = highlight((ROOT / path).read_text(encoding="utf-8"), PythonLexer(), formatter)
        context = {"title": path, "body": f"<h1><code>{escape(path)}</code></h1>{code}"}
        yield _page_of(path), context, "page.html"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.add_role("source", SourceRole())
    app.connect("html-collect-pages", _source_pages)
    return {"parallel_read_safe": False, "parallel_write_safe": True}

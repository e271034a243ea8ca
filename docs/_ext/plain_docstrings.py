"""Docstrings are plain text with names in backticks: what else reStructuredText reads is escaped.

Mentions of a section of the method, "docs/method section 6", become links. Fields of records are
listed under Attributes, so they are not shown a second time, nor as a signature where nobody calls
it.
"""

import dataclasses
import re

from sphinx.application import Sphinx
from sphinx.domains.python import PyObject

SECTION = re.compile(r"docs/method,? sections? (\d)")
PAGES = {
    "1": "1-problem",
    "2": "2-zones",
    "3": "3-augmented-lagrangian",
    "4": "4-directions",
    "5": "5-scaling",
    "6": "6-outer-loop",
    "7": "7-statuses",
    "8": "8-certificates",
}


def _escaped(line):
    """The line with *, | and trailing _ escaped outside of backticks."""
    pieces = line.split("`")
    for i in range(0, len(pieces), 2):
        pieces[i] = re.sub(r"([*|\\])", r"\\\1", pieces[i])
        pieces[i] = re.sub(r"(\w)_(?!\w)", r"\1\\_", pieces[i])
        pieces[i] = SECTION.sub(_link, pieces[i])
    return "`".join(pieces)


def _link(match):
    return f":doc:`{match[0]} </method/{PAGES[match[1]]}>`"


def _escape_docstring(app, what, name, obj, options, lines):
    lines[:] = [_escaped(line) for line in lines]


def _skip_field(app, what, name, obj, skip, options):
    return True if type(obj).__name__ == "_tuplegetter" else None


def _hide_signature(app, what, name, obj, options, signature, return_annotation):
    """Leave out the signature of a record that functions return, which repeats its fields."""
    if what != "class":
        return None
    filled = dataclasses.is_dataclass(obj) and all(
        field.default is dataclasses.MISSING for field in dataclasses.fields(obj)
    )
    return ("", None) if filled or issubclass(obj, tuple) else None


def _find_public_name(app, env, node, contnode):
    """Link a bare name of a docstring, such as `ShapeError`, to the public name."""
    if node.get("refdomain") != "py":
        return None
    domain, target = env.domains.python_domain, node["reftarget"]
    for prefix in ("izo_ref.", "izo_ref.errors."):
        if prefix + target in domain.objects:
            return domain.resolve_xref(
                env, node["refdoc"], app.builder, "obj", prefix + target, node, contnode
            )
    return None


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("missing-reference", _find_public_name)
    app.connect("autodoc-process-docstring", _escape_docstring, priority=400)
    app.connect("autodoc-skip-member", _skip_field)
    app.connect("autodoc-process-signature", _hide_signature)
    for field in PyObject.doc_field_types:
        if field.name == "variable":
            field.label = "Attributes"
    return {"parallel_read_safe": True, "parallel_write_safe": True}

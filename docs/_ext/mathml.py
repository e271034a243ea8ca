"""Equations as MathML, made while building: browsers render it without scripts or fonts of ours.

docutils converts the TeX. It calls its converter provisional; the lock file pins its version. An
equation that it cannot convert, or that does not close what it opens, is a warning, hence an error.
"""

import re

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util.logging import getLogger
from sphinx.util.math import get_node_equation_number

PAIRS = ((r"(?<!\\\\){", r"(?<!\\\\)}"), (r"\\left\b", r"\\right\b"), (r"\\begin\b", r"\\end\b"))
BAR = '<mo stretchy="false">\N{DOUBLE VERTICAL LINE}</mo>'


def _markup(node, as_block):
    """MathML of an equation, with norm bars of the same height and no gap between max and (."""
    tex = node.astext()
    for opening, closing in PAIRS:
        if len(re.findall(opening, tex)) != len(re.findall(closing, tex)):
            getLogger(__name__).warning(
                "%s does not match %s: %s", opening, closing, tex, location=node
            )
    try:
        markup = tex2mathml(tex, as_block=as_block)
    except MathError as error:
        getLogger(__name__).warning("%s: %s", error, tex, location=node)
        return ""
    markup = re.sub('<mo( class="[a-z]+")?>\N{DOUBLE VERTICAL LINE}</mo>', BAR, markup)
    return re.sub("<mo>(max|min)</mo>", r'<mo lspace="0.17em" rspace="0">\1</mo>', markup)


def _visit_inline(writer, node):
    writer.body.append(_markup(node, as_block=False))
    raise nodes.SkipNode


def _visit_block(writer, node):
    # the anchor of a labelled equation is on the element around it
    writer.body.append(f'<div class="equation"><div class="formula">{_markup(node, True)}</div>')
    if node["number"]:
        number = get_node_equation_number(writer, node)
        writer.body.append(f'<span class="eqno">({number})')
        writer.add_permalink_ref(node, "Link to this equation")
        writer.body.append("</span>")
    writer.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.add_html_math_renderer("mathml", (_visit_inline, None), (_visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}

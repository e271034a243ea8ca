"""Settings of the documentation; `make docs` builds it."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent)]

from izo_ref.version import __version__  # noqa: E402

project = "izo_ref"
exclude_patterns = ["_build"]
release = version = __version__
copyright = "the authors of izo_ref"
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    # our own, in _ext; those that change docstrings come before napoleon, which reads them
    "plain_docstrings",
    "sphinx.ext.napoleon",
    "generated",
    "example_pages",
    "mathml",
    "source_links",
]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nitpicky = True

# Equations and tables are numbered by section, so that code can name them: eq. 3.2.
numfig = True
math_numfig = True
math_eqref_format = "({number})"
html_math_renderer = "mathml"

add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = ["Source"]
# A name in backticks is a link where the documentation has it, and code everywhere else. Types
# of other packages are not looked up: that takes a network.
default_role = "py:obj"
nitpick_ignore_regex = [
    ("py:obj", r".*"),
    ("py:(class|exc)", r"(?!izo_ref\.).*"),
]

html_theme = "furo"
html_title = f"izo_ref {__version__}"
html_static_path = ["_static"]
html_css_files = ["docs.css"]
html_show_sphinx = False
html_copy_source = False
# The summaries of search results would be fetched, which browsers refuse to pages from files.
html_show_search_summary = False
html_theme_options = {"footer_icons": [], "navigation_with_keys": True}

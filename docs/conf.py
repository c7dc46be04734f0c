"""The documentation as a site: Markdown by MyST, theme Furo, equations as MathML, nothing from elsewhere.

Why these: docs/decisions/0027-documentation-site.md. `make docs` builds it; what is broken is an error there.
"""

import sys
import tomllib
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))

project = "teletaction"
copyright = "the teletaction developers, MIT licence"  # the name that Sphinx reads
release = tomllib.loads((HERE.parent / "pyproject.toml").read_text("utf-8"))["project"]["version"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "mathml", "without_network"]
root_doc = "docs/index"
include_patterns = ["docs/**", "deploy/**", "examples/*.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"]
"""The repository is the source: pages link to each other as they lie there."""
exclude_patterns = [".*", "docs/_extensions", "site", "build"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]
"""Types of other packages have no page here."""
autoclass_content = "both"
autodoc_member_order = "bysource"
default_role = "code"
"""Of single backquotes in docstrings."""
napoleon_use_ivar = True
python_use_unqualified_type_names = True

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
"""Headings down to ### can be linked to, as on a page of the repository."""
myst_links_external_new_tab = False

html_theme = "furo"
html_title = "teletaction"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["start", "console.png"]
"""The start page of the site and its picture, at its root."""
html_math_renderer = "mathml"
html_show_sphinx = False
html_copy_source = False
highlight_language = "none"
"""Of blocks that name none: commands and what they print."""


def setup(app: Sphinx) -> None:
    """Bytes of the protocols have no language of their own."""
    app.add_lexer("golden", TextLexer)

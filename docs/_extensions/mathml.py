"""Equations as MathML, which browsers draw by themselves: no script, no font, no picture."""

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

log = logging.getLogger(__name__)


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    _write(writer, node, as_block=False)


def _display(writer: HTML5Translator, node: nodes.math_block) -> None:
    _write(writer, node, as_block=True)


def _write(writer: HTML5Translator, node: nodes.Element, *, as_block: bool) -> None:
    """Write one equation; one that cannot be drawn is a warning, and so an error of the build."""
    try:
        drawn = tex2mathml(node.astext(), as_block=as_block)
    except MathError as error:
        log.warning("equation %r: %s", node.astext(), error, location=node)
        drawn = writer.encode(node.astext())
    writer.body.append(f'<div class="equation">{drawn}</div>' if as_block else drawn)
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Tell Sphinx of it."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}

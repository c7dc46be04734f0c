"""Writes the parts of a report: sections, and figures as embedded pictures."""

import base64
from collections.abc import Mapping
from html import escape
from io import BytesIO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from teletaction.report.report_words import NONE

DPI = 140
"""Resolution of the embedded pictures, dots per inch."""


def section(title: str, content: str, kind: str = "") -> str:
    """Wrap HTML content in a section; `kind` is a class of the style sheet."""
    marked = f' class="{kind}"' if kind else ""
    return f"<section{marked}><h2>{escape(title)}</h2>{content}</section>\n"


def fact_list(facts: Mapping[str, str]) -> str:
    """Write facts in a row, each below its name. Values are HTML."""
    return "<dl>" + "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in facts.items()) + "</dl>"


def annex(content: str) -> str:
    """Wrap technical parts in an annex that a screen shows collapsed, and that is printed only if it is open."""
    return f'<details class="annex"><summary>Technical annex</summary>{content}</details>\n'


def figure(title: str, drawn: Figure | None, caption: str) -> str:
    """Embed a figure with its caption; write "none" without a figure."""
    if drawn is None:
        return f"<p>{NONE}</p>"
    source = base64.b64encode(png(drawn, DPI)).decode("ascii")
    return (
        f'<figure><img alt="{escape(title)}" src="data:image/png;base64,{source}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def png(drawn: Figure, dpi: int) -> bytes:
    """Return a figure as a PNG file."""
    buffer = BytesIO()
    FigureCanvasAgg(drawn)
    drawn.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()

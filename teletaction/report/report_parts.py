"""Writes the parts of a report: sections, and figures as embedded pictures."""

import base64
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

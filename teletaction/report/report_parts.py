"""What a report is put together from: sections, and figures as pictures within the page."""

import base64
from html import escape
from io import BytesIO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from teletaction.report.report_words import NONE

DPI = 140


def section(title: str, content: str, kind: str = "") -> str:
    """A section of ready content; `kind` is a class of the style sheet."""
    marked = f' class="{kind}"' if kind else ""
    return f"<section{marked}><h2>{escape(title)}</h2>{content}</section>\n"


def figure(title: str, drawn: Figure | None, told: str) -> str:
    """A figure with what it shows in words; "none" where there is nothing to draw."""
    if drawn is None:
        return f"<p>{NONE}</p>"
    source = base64.b64encode(png(drawn, DPI)).decode("ascii")
    return (
        f'<figure><img alt="{escape(title)}" src="data:image/png;base64,{source}">'
        f"<figcaption>{escape(told)}</figcaption></figure>"
    )


def png(drawn: Figure, dpi: int) -> bytes:
    """A figure as a PNG file."""
    buffer = BytesIO()
    FigureCanvasAgg(drawn)
    drawn.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()

"""Writes the parts of a report: sections, and figures as embedded pictures."""

import base64
from collections.abc import Mapping
from io import BytesIO

import htpy as h
from htpy import Element, Node
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from teletaction.report.report_words import NONE

DPI = 140
"""Resolution of the embedded pictures, dots per inch."""


def section(title: str, content: Node, kind: str | None = None) -> Element:
    """Wrap content in a section; `kind` is a class of the style sheet."""
    return h.section(class_=kind)[h.h2[title], content]


def fact_list(facts: Mapping[str, Node]) -> Element:
    """Write facts in a row, each below its name."""
    return h.dl[[h.div[h.dt[name], h.dd[value]] for name, value in facts.items()]]


def annex(content: Node) -> Element:
    """Wrap technical parts in an annex that a screen shows collapsed, and that is printed only if it is open."""
    return h.details(".annex")[h.summary["Technical annex"], content]


def figure(title: str, drawn: Figure | None, caption: str) -> Element:
    """Embed a figure with its caption; write "none" without a figure."""
    if drawn is None:
        return h.p[NONE]
    return embedded(title, "png", png(drawn, DPI), caption)


def embedded(title: str, form: str, content: bytes, caption: str) -> Element:
    """Embed a picture file with its caption; `form` is its format, such as "png"."""
    source = base64.b64encode(content).decode("ascii")
    return h.figure[h.img(alt=title, src=f"data:image/{form};base64,{source}"), h.figcaption[caption]]


def png(drawn: Figure, dpi: int) -> bytes:
    """Return a figure as a PNG file."""
    buffer = BytesIO()
    FigureCanvasAgg(drawn)
    drawn.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()

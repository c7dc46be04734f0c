"""A site that asks for anything elsewhere is not built: hospitals' networks end at the door. Links may lead there."""

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

log = logging.getLogger(__name__)

_ASKED_FOR = re.compile(
    r"""<(?:script|img|source|iframe)\b[^>]*\bsrc=["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|<link\b(?![^>]*rel=["']?canonical)[^>]*\bhref=["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|(?:url\(|@import\s*)["']?((?:https?:)?//[^"')\s]+)""",
    re.IGNORECASE,
)


def asked_for(folder: Path) -> list[str]:
    """What pages and style sheets in a folder would fetch from elsewhere, a line each."""
    return [
        f"{path.relative_to(folder)}: {next(filter(None, groups))}"
        for path in sorted(folder.rglob("*"))
        if path.suffix in {".html", ".css", ".svg"}
        for groups in _ASKED_FOR.findall(path.read_text("utf-8"))
    ]


def _refuse(app: Sphinx, exception: Exception | None) -> None:
    for found in [] if exception else asked_for(Path(app.outdir)):
        log.warning("the site would ask for what is elsewhere: %s", found)


def setup(app: Sphinx) -> dict[str, bool]:
    """Tell Sphinx of it."""
    app.connect("build-finished", _refuse)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

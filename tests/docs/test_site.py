"""The site's own parts; `make docs` tests the rest."""

import sys
from importlib import import_module
from pathlib import Path

import pytest

from tests.places import ROOT

pytest.importorskip("sphinx", reason="the group `docs` is not installed")


@pytest.mark.parametrize(
    ("page", "elsewhere"),
    [
        ('<img src="https://example.org/x.png">', ["https://example.org/x.png"]),
        ('<link rel="stylesheet" href="//example.org/x.css">', ["//example.org/x.css"]),
        ("<style>@import 'http://example.org/x.css';</style>", ["http://example.org/x.css"]),
        ('<a href="https://example.org">a link</a> <script src="_static/x.js"></script>', []),
    ],
)
def test_requests_of_a_page_to_other_hosts_are_found(
    page: str, elsewhere: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [str(ROOT / "docs" / "_extensions"), *sys.path])
    (tmp_path / "page.html").write_text(page, "utf-8")
    found = import_module("without_network").asked_for(tmp_path)
    assert found == [f"page.html: {address}" for address in elsewhere]

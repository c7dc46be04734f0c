"""A page's process continues when a step of it raises."""

import socket
from pathlib import Path
from unittest.mock import Mock

import pytest
from starlette.applications import Starlette

from common.config.page_models import WebConfig
from common.runtime.containment import Containment
from common.web.door import Door
from common.web.guarded_page import file_in
from common.web.page_server import Work, address_of, bound, serve_page
from tests.conftest import Contained
from tests.unit.common.link.links import needs_ipv6


def test_a_step_that_raises_is_named_once_and_the_process_continues(
    contained: Contained, monkeypatch: pytest.MonkeyPatch
) -> None:
    contain, steps = Containment(), []
    monkeypatch.setattr(Door, "step", Mock(side_effect=AttributeError("no transport")))

    def step(now_s: float) -> None:
        steps.append(now_s)
        raise LookupError("no map")

    def status() -> None:
        raise ValueError("no figures")

    with socket.create_server(("127.0.0.1", 0)) as listening:
        serve_page(Starlette(), WebConfig(), listening, contain, Work(lambda: len(steps) >= 5, step, 0.008, status))
    assert len(steps) == 5
    names = contained.take()
    assert [name.split(" in ")[0] for name in names] == [
        "showing: LookupError",
        "connections: AttributeError",
        "status: ValueError",
    ]
    assert contain.count == 7


@needs_ipv6
def test_a_page_is_served_over_ipv6() -> None:
    config = WebConfig(bind="::1", port=0)
    with bound(config) as listening:
        port = listening.getsockname()[1]
        assert address_of(config, listening) == f"http://[::1]:{port}"
        socket.create_connection(("::1", port)).close()


@pytest.mark.parametrize("name", ["none.js", "..", ".hidden", "a/b.js", "../page.js", "a" * 300, "a\0b"])
def test_only_a_file_of_the_folder_is_served(tmp_path: Path, name: str) -> None:
    (tmp_path / "page.js").touch()
    (tmp_path / ".hidden").touch()
    assert file_in(tmp_path, "page.js") == tmp_path / "page.js"
    assert file_in(tmp_path, name) is None

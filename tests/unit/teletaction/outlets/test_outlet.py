"""An outlet listens on loopback unless it is opened to a network, and names in one line what it lacks."""

import socket
from pathlib import Path
from types import SimpleNamespace

import pytest

from teletaction.outlets import outlet
from teletaction.outlets.live_messages import LiveMessages
from teletaction.outlets.outlet import TOOLS, Reports, Tool, chosen_place
from teletaction.outlets.place import Place
from tests.commands import command, one_line

SITE = "curve:abc"


def edited(config: Path, old: str, new: str) -> Path:
    text = config.read_text("utf-8")
    assert old in text
    config.write_text(text.replace(old, new), "utf-8")
    return config


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--to xml", "no tool 'xml'; choose one of foxglove, rerun, lsl"),
        ("--to foxglove --host 0.0.0.0", "--host 0.0.0.0 is open to a network"),
        ("--to rerun --host ::", "--open-to-network"),
        ("--to rerun --host console.example", "--host console.example: expected an IP address"),
        ("--to lsl", "lsl listens at all addresses of this machine"),
        ("--to lsl --host 127.0.0.1", "leave out --host and --port"),
        ("--to lsl --port 8765 --open-to-network", "leave out --host and --port"),
        ("--to foxglove --port 70000", "--port"),
    ],
)
def test_an_impossible_place_is_one_line(options: str, said: str, configs: dict[str, Path]) -> None:
    assert said in one_line(command("outlet", "--config", configs["operator"], *options.split()), 2)


def test_an_operator_site_without_a_feed_is_one_line(configs: dict[str, Path]) -> None:
    port = next(line for line in configs["operator"].read_text("utf-8").splitlines() if line.startswith("feed_port"))
    config = edited(configs["operator"], port, "")
    assert "set feed_port" in one_line(command("outlet", "--config", config, "--to", "foxglove", "--port", "0"), 2)


@pytest.mark.parametrize("to", ["foxglove", "rerun"])
def test_a_port_in_use_is_one_line(to: str, configs: dict[str, Path]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = one_line(command("outlet", "--config", configs["operator"], "--to", to, "--port", port), 2)
    assert f"127.0.0.1:{port}" in line
    assert "choose another --port" in line


@pytest.mark.parametrize("to", TOOLS)
def test_a_missing_package_names_its_extra(to: str, configs: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    tool = TOOLS[to]
    monkeypatch.setitem(outlet.TOOLS, to, Tool("a_module_that_is_not_there", tool.server, tool.extra, tool.port))
    options = ["--open-to-network"] if tool.port is None else ["--port", "0"]
    line = one_line(command("outlet", "--config", configs["operator"], "--to", to, *options), 2)
    assert f"pip install 'teletaction[{tool.extra}]'" in line


@pytest.mark.parametrize(
    ("host", "consent", "listens"),
    [
        (None, False, "127.0.0.1"),
        ("localhost", False, "127.0.0.1"),
        ("127.0.0.2", False, "127.0.0.2"),
        ("0.0.0.0", True, "0.0.0.0"),
    ],
)
def test_a_place_is_loopback_or_has_consent(host: str | None, consent: bool, listens: str) -> None:
    place = chosen_place("foxglove", SITE, host, 0, open_to_network=consent)
    assert (place.site, place.host) == (SITE, listens)
    assert place.port > 0


def test_lsl_has_no_place_of_its_own() -> None:
    assert chosen_place("lsl", SITE, None, None, open_to_network=True) == Place(SITE)


def test_losses_and_silence_are_logged_when_they_are_new(caplog: pytest.LogCaptureFixture) -> None:
    live = LiveMessages()
    detached = SimpleNamespace(dropped=0)
    reports = Reports(live, detached)

    def logged() -> list[str]:
        caplog.clear()
        reports.step()
        return [record.getMessage() for record in caplog.records]

    assert logged() == ["no message from the operator site for 10 s: is it running?"]
    assert logged() == []
    live.counts["operator/clock"] += 1
    assert logged() == []
    detached.dropped, live.damaged = 3, 1
    live.counts["operator/clock"] += 1
    assert logged() == ["3 dropped because the tool was behind, 1 unreadable"]
    assert len(logged()) == 1, "it is silent again"

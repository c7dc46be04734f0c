"""The configurations that ship for containers: they load, and their addresses and ports fit each other."""

import re
from collections.abc import Mapping
from typing import Any

import pytest
from pydantic import BaseModel

from common.config.file import load_config
from common.config.link_models import RendezvousConfig, TunnelConfig
from common.config.page_models import ConsoleConfig, PatientPageConfig, WebConfig
from common.config.simulation_models import SimOperatorConfig, SimRemoteConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.config.stream_models import CameraConfig, VoiceConfig
from tests.places import ROOT

DOCKER = ROOT / "docker"


def ports(addresses: Mapping[Any, str]) -> dict[str, int]:
    return {finger: int(address.rsplit(":", 1)[1]) for finger, address in addresses.items()}


def test_the_sites_look_for_the_devices_where_the_simulators_serve_them() -> None:
    remote = load_config(DOCKER / "remote.toml", RemoteConfig)
    operator = load_config(DOCKER / "operator.toml", OperatorConfig)
    bench = load_config(DOCKER / "sim-remote.toml", SimRemoteConfig)
    hand = load_config(DOCKER / "sim-operator.toml", SimOperatorConfig)
    assert ports(remote.texture) == ports(bench.texture)
    assert ports(remote.thermal_sensors) == ports(bench.thermal_sensors)
    assert remote.telemanipulator.port == bench.can_port
    assert ports(operator.tacttip) == ports(hand.tacttip)
    assert operator.exoskeleton.port == hand.can_port
    assert operator.link.base_port == remote.link.base_port
    assert (bench.scene, bench.seed) == (hand.scene, hand.seed)


def service(name: str) -> str:
    """A service of the composition, as it is written."""
    return (ROOT / "docker-compose.yml").read_text("utf-8").split(f"\n  {name}:\n")[1].split("\n\n")[0]


@pytest.mark.parametrize("folder", ["", "hardware"])
def test_the_camera_is_beside_its_site(folder: str) -> None:
    camera = load_config(DOCKER / folder / "camera.toml", CameraConfig)
    remote = load_config(DOCKER / folder / "remote.toml", RemoteConfig)
    assert (camera.link.base_port, camera.link.keys) == (remote.link.base_port, remote.link.keys)


@pytest.mark.parametrize("folder", ["", "hardware"])
def test_the_voice_is_beside_its_site(folder: str) -> None:
    voice = load_config(DOCKER / folder / "voice.toml", VoiceConfig)
    remote = load_config(DOCKER / folder / "remote.toml", RemoteConfig)
    assert (voice.link.base_port, voice.link.keys) == (remote.link.base_port, remote.link.keys)
    assert voice.desk_port != remote.desk_port
    assert "PROCESS: voice" in service("remote-voice" if folder else "voice")


def test_the_camera_looks_for_pictures_where_the_simulator_serves_them() -> None:
    camera, bench = (
        load_config(DOCKER / "camera.toml", CameraConfig),
        load_config(DOCKER / "sim-remote.toml", SimRemoteConfig),
    )
    assert bench.camera is not None
    assert camera.source.rsplit(":", 1)[1] == bench.camera.port.rsplit(":", 1)[1]


def test_both_ends_of_a_tunnel_meet_in_a_room_of_the_rendezvous() -> None:
    rendezvous = load_config(DOCKER / "hardware" / "rendezvous.toml", RendezvousConfig)
    tunnel = load_config(DOCKER / "hardware" / "tunnel.toml", TunnelConfig)
    assert rendezvous.rooms[tunnel.room] == tunnel.secret
    assert rendezvous.port == tunnel.port
    for name in ("rendezvous", "tunnel"):
        assert "secrets: [room-secret]" in service(name)


@pytest.mark.parametrize("folder", ["", "hardware"])
def test_the_console_has_the_address_of_its_site(folder: str) -> None:
    console = load_config(DOCKER / folder / "console.toml", ConsoleConfig)
    site = load_config(DOCKER / folder / "operator.toml", OperatorConfig)
    assert (console.desk_port, console.feed_port, console.keys) == (site.desk_port, site.feed_port, site.link.keys)
    assert "{record}" in console.report_command
    assert "{report}" in console.report_command


def test_only_loops_of_real_sites_may_have_real_time_priority() -> None:
    text = (ROOT / "docker-compose.yml").read_text("utf-8")
    real = text.split("\nx-real: ")[1].split("\n\n")[0]
    assert 'ulimits: {core: 0, rtprio: "${REAL_TIME_PRIORITY:-10}"}' in real
    assert text.count("rtprio") == 1
    for name in ("remote", "operator"):
        assert service(name).startswith("    <<: *real\n")
    assert text.count("*real\n") == 2


def test_no_process_leaves_a_core_file_which_would_hold_its_secret_key() -> None:
    text = (ROOT / "docker-compose.yml").read_text("utf-8")
    assert "ulimits: {core: 0}" in text.split("\nx-process: ")[1].split("\n\n")[0]
    assert all("core: 0" in limits for limits in re.findall(r"ulimits: (.*)", text)), (
        "a service's own limits replace them"
    )
    services = re.split(r"\n  (?=[\w-]+:\n)", text.partition("\nservices:\n")[2].partition("\nsecrets:\n")[0])
    assert all("<<: *" in each for each in services)


def test_the_simulated_sessions_page_is_on_loopback_only_and_needs_a_token_over_tls() -> None:
    console = load_config(DOCKER / "console.toml", ConsoleConfig)
    assert re.findall(r"^ +ports: .*$", (ROOT / "docker-compose.yml").read_text("utf-8"), re.MULTILINE) == [
        f'    ports: ["127.0.0.1:${{CONSOLE_PORT:-8090}}:{console.port}"]'
    ]
    assert "ports:" in service("operator-host")
    for name in ("operator-site", "console"):
        assert "network_mode: service:operator-host" in service(name), "the site serves on its loopback only"
    assert console.tokens is not None
    assert console.certificate is not None


@pytest.mark.parametrize(
    ("file", "model", "name"),
    [("console", ConsoleConfig, "operator-console"), ("patient-page", PatientPageConfig, "patient-page")],
)
def test_a_page_beside_real_devices_needs_a_token_over_tls(file: str, model: type[WebConfig], name: str) -> None:
    page = load_config(DOCKER / "hardware" / f"{file}.toml", model)
    for path in (page.tokens, page.certificate, page.certificate_key):
        assert f"target: {path}}}" in service(name), "it is a secret of the composition"


@pytest.mark.parametrize(("name", "model"), [("remote", RemoteConfig), ("operator", OperatorConfig)])
def test_real_devices_are_named_as_they_come_and_go_and_the_key_is_a_secret(name: str, model: type[BaseModel]) -> None:
    config = load_config(DOCKER / "hardware" / f"{name}.toml", model)
    assert f"target: {config.model_dump()['link']['keys']}/site.key_secret}}" in service(name)
    assert "- /dev:/dev:ro" in service(name)
    named = {
        address
        for table in config.model_dump().values()
        if isinstance(table, dict)
        for address in table.values()
        if str(address).startswith("/dev/")
    }
    assert not any(address.startswith("/dev/tty") for address in named), "such a name is another device tomorrow"
    assert len(named) % 5 == 0
    assert named

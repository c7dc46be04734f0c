"""The configurations that ship for containers: they load, and their addresses and ports fit each other."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

from common.config import OperatorConfig, RemoteConfig, SimOperatorConfig, SimRemoteConfig, load_config

ROOT = Path(__file__).parents[2]
DOCKER = ROOT / "docker"


def ports(addresses: Mapping[Any, str]) -> dict[str, int]:
    return {finger: int(address.rsplit(":", 1)[1]) for finger, address in addresses.items()}


def test_the_sites_look_for_the_devices_where_the_simulators_serve_them() -> None:
    remote, operator = (
        load_config(DOCKER / "remote.toml", RemoteConfig),
        load_config(DOCKER / "operator.toml", OperatorConfig),
    )
    bench = load_config(DOCKER / "sim-remote.toml", SimRemoteConfig)
    hand = load_config(DOCKER / "sim-operator.toml", SimOperatorConfig)
    assert ports(remote.texture) == ports(bench.texture)
    assert ports(remote.thermal_sensors) == ports(bench.thermal_sensors)
    assert remote.telemanipulator.port == bench.can_port
    assert ports(operator.tacttip) == ports(hand.tacttip)
    assert operator.exoskeleton.port == hand.can_port
    assert operator.link.base_port == remote.link.base_port
    assert (bench.scene, bench.seed) == (hand.scene, hand.seed)


@pytest.mark.parametrize(("name", "model"), [("remote", RemoteConfig), ("operator", OperatorConfig)])
def test_each_device_of_the_hardware_configuration_is_mapped_by_the_composition(
    name: str, model: type[BaseModel]
) -> None:
    config = load_config(DOCKER / "hardware" / f"{name}.toml", model)
    named = {
        address
        for table in config.model_dump().values()
        if isinstance(table, dict)
        for address in table.values()
        if str(address).startswith("/dev/")
    }
    service = (ROOT / "docker-compose.yml").read_text("utf-8").split(f"  {name}-site-hardware:")[1].split("\n\n")[0]
    mapped = set(re.findall(r"^      - /dev/serial/by-id/\S+:(/dev/\S+)$", service, re.MULTILINE))
    assert named == mapped
    assert len(named) % 5 == 0
    assert named

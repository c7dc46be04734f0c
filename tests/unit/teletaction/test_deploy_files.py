"""The examples for a host with real devices: names fit the configurations that ship, and the syntax is right."""

import configparser
import re
import shutil
import subprocess

import pytest
from pydantic import BaseModel

from common.config import link_models, site_models
from common.config.file import load_config
from common.config.site_models import OperatorConfig, RemoteConfig
from tests.places import ROOT

RULES = ROOT / "deploy" / "udev" / "70-teletaction.rules"
INTERFACE = ROOT / "deploy" / "network" / "80-teletaction-can.network"
HARDWARE = ROOT / "docker" / "hardware"
_PART = re.compile(r'[A-Z_]+(\{\w+\})?(==|\+=|=)"[^"]*"')


def rules() -> list[str]:
    lines = RULES.read_text("utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def test_each_serial_device_of_the_configurations_has_a_rule_and_an_adapter_of_its_own() -> None:
    remote = load_config(HARDWARE / "remote.toml", RemoteConfig)
    operator = load_config(HARDWARE / "operator.toml", OperatorConfig)
    wanted = [*remote.texture.values(), *remote.thermal_sensors.values(), *operator.tacttip.values()]
    given = [f"/dev/{name}" for rule in rules() for name in re.findall(r'SYMLINK\+="([^"]+)"', rule)]
    assert sorted(given) == sorted(wanted)
    numbers = [number for rule in rules() for number in re.findall(r'ENV\{ID_SERIAL_SHORT\}=="([^"]+)"', rule)]
    assert len(numbers) == len(set(numbers)) == 15
    for rule in rules():
        assert all(_PART.fullmatch(part) for part in rule.split(", ")), rule
        assert "==" in rule.split(", ")[0]


def fields(kind: type[BaseModel]) -> set[str]:
    """Names of the fields of a configuration and of its tables."""
    below = {each for field in kind.model_fields.values() for each in re.findall(r"\w+Config", str(field.annotation))}
    tables = [getattr(module, name) for name in below for module in (site_models, link_models) if hasattr(module, name)]
    return set(kind.model_fields).union(*(table.model_fields for table in tables))


@pytest.mark.parametrize(("name", "kind"), [("remote", RemoteConfig), ("operator", OperatorConfig)])
def test_the_file_of_a_site_names_each_field(name: str, kind: type[BaseModel]) -> None:
    text = (HARDWARE / f"{name}.toml").read_text("utf-8")
    assert {field for field in fields(kind) if not re.search(rf"(?m)^(# )?\[?{field}\b", text)} == set()


def test_the_page_applies_each_rule_to_devices_that_are_already_there() -> None:
    page = (RULES.parent / "README.md").read_text("utf-8")
    triggered = next(line.split() for line in page.splitlines() if line.strip().startswith("udevadm trigger"))
    for subsystem in re.findall(r'SUBSYSTEM=="([^"]+)"', "\n".join(rules())):
        assert f"--subsystem-match={subsystem}" in triggered
    assert "--action=add" in triggered, "by default it sends `change`, and a rule is for `add`"


@pytest.mark.skipif(shutil.which("udevadm") is None, reason="udevadm is not there")
def test_udev_accepts_the_rules() -> None:
    known = subprocess.run(["udevadm", "verify", "--help"], capture_output=True, text=True, timeout=20, check=False)
    if known.returncode:
        pytest.skip("this udevadm has no verify")
    verified = subprocess.run(["udevadm", "verify", RULES], capture_output=True, text=True, timeout=20, check=False)
    assert verified.returncode == 0, verified.stderr


def test_the_interface_is_the_configurations_and_as_fast_as_the_protocol() -> None:
    parser = configparser.ConfigParser()
    parser.read(INTERFACE, "utf-8")
    for name, kind, bus in (("remote", RemoteConfig, "telemanipulator"), ("operator", OperatorConfig, "exoskeleton")):
        address = getattr(load_config(HARDWARE / f"{name}.toml", kind), bus)
        assert (address.interface, address.channel) == ("socketcan", parser["Match"]["Name"])
    assert parser["CAN"]["BitRate"] == "1M"
    # By default it needs an address to count as online, which it never has: a boot may wait two minutes.
    assert parser["Link"]["RequiredForOnline"] == "carrier"
    assert "bitrate 1000000" in (INTERFACE.parent / "README.md").read_text("utf-8")

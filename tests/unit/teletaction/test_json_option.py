"""`--json` prints one object with what the command prints for people."""

import csv
import json
from pathlib import Path

from common.link.keys import load_keys
from tests.commands import command
from tests.conftest import Keys


def test_checks_of_the_doctor(configs: dict[str, Path]) -> None:
    result = command("doctor", "--config", configs["remote"], "--json")
    assert result.code == 1, "a failed check is an error in either form"
    checks = json.loads(result.out)["checks"]
    lines = command("doctor", "--config", configs["remote"]).out.splitlines()
    assert [f"{'ok  ' if each['good'] else 'FAIL'} {each['check']}" for each in checks] == [
        line.split(":")[0] for line in lines
    ]


def test_devices_of_a_host(tmp_path: Path) -> None:
    result = command("doctor", "--ports", tmp_path, "--json")
    assert result.code == 1
    assert all(each.keys() == {"address", "good", "device"} for each in json.loads(result.out)["devices"])


def test_keys(keys: Keys) -> None:
    shown = json.loads(command("keys", "show", "--keys", keys.remote, "--json").out)
    trusted = [{"name": "operator", "role": "partner", "key": load_keys(keys.operator).public}]
    assert shown == {"own": load_keys(keys.remote).public, "trusted": trusted}


def test_objects_of_a_scene() -> None:
    objects = json.loads(command("scene", "check", "materials", "--json").out)["objects"]
    rows = list(csv.DictReader(command("scene", "check", "materials").out.splitlines()))
    assert [list(each) for each in objects] == [list(row) for row in rows]
    for each, row in zip(objects, rows, strict=True):
        written = {name: f"{value:.3g}" if isinstance(value, float) else str(value) for name, value in each.items()}
        assert written | {"step_us": ""} == row | {"step_us": ""}, "all but the measured time of a step"

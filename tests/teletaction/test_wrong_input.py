"""Wrong input answers in one line with exit 2, and names what is wrong."""

import json
import socket
from pathlib import Path

import pytest

from common.config import SimRemoteConfig, to_toml
from common.keys import TrustedKeys, create_keys
from teletaction.cli import main
from teletaction.demo_files import SURFACES, TABLES, DemoOptions, prepare

THERMAL = "time_s,sensor_c,force_n\n" + "".join(f"{0.01 * n:.2f},33.0,0.0\n" for n in range(50))


@pytest.fixture
def configs(tmp_path: Path) -> dict[str, Path]:
    return prepare(DemoOptions(fingers=1), tmp_path)


def refuse(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must be refused; its one line."""
    assert main(list(arguments)) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.strip().splitlines()
    assert len(lines) == 1, captured.err
    assert lines[0].startswith("teletaction: ")
    return lines[0]


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")


def test_unknown_command_and_option(capsys: pytest.CaptureFixture[str]) -> None:
    assert "frobnicate" in refuse(capsys, "frobnicate")
    assert "--frobnicate" in refuse(capsys, "demo", "--frobnicate")
    assert "--fingers" in refuse(capsys, "demo", "--fingers", "9")


def test_unknown_scene(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    line = refuse(capsys, "demo", "--headless", "--scene", "atlantis", "--out", str(tmp_path / "o"))
    assert "atlantis" in line
    assert "phantom" in line


def test_a_virtual_environment_needs_a_scene_and_a_configuration(
    capsys: pytest.CaptureFixture[str], configs: dict[str, Path], tmp_path: Path
) -> None:
    config = str(configs["operator"])
    line = refuse(capsys, "virtual", "--scene", "atlantis", "--config", config)
    assert "unknown scene 'atlantis'; known: materials, paper_iron_wood" in line
    assert "none.toml: cannot read" in refuse(
        capsys, "virtual", "--scene", str(tmp_path / "none.toml"), "--config", config
    )
    assert "--scene" in refuse(capsys, "virtual", "--config", config)
    assert "--seed" in refuse(capsys, "virtual", "--scene", "materials", "--config", config, "--seed", "-1")
    assert "remote.toml" in refuse(capsys, "virtual", "--scene", "materials", "--config", str(configs["remote"]))
    own = tmp_path / "own.toml"
    own.write_text('name = "own"\n[materials.balsa]\ndensity_kg_m3 = 160.0\n', "utf-8")
    line = refuse(capsys, "virtual", "--scene", str(own), "--config", config)
    assert "own.toml: materials: balsa: conductivity_w_mk is missing" in line


def test_folder_with_other_things_is_left_alone(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work", "utf-8")
    assert "other things" in refuse(capsys, "demo", "--headless", "--out", str(tmp_path))
    assert (tmp_path / "thesis.txt").read_text("utf-8") == "years of work"


def test_configuration(capsys: pytest.CaptureFixture[str], configs: dict[str, Path], tmp_path: Path) -> None:
    assert "absent.toml" in refuse(capsys, "remote", "--config", str(tmp_path / "absent.toml"))
    remote = configs["remote"]
    edit(remote, "rate_hz =", "rate_hertz =")
    line = refuse(capsys, "remote", "--config", str(remote))
    assert "rate_hertz" in line
    assert "remote.toml:2" in line
    edit(remote, "rate_hertz = 250.0", "rate_hz = 5.0")
    line = refuse(capsys, "remote", "--config", str(remote))
    assert "rate_hz" in line
    assert "100" in line


def test_port_in_use(capsys: pytest.CaptureFixture[str], configs: dict[str, Path]) -> None:
    import tomllib

    port = tomllib.loads(configs["remote"].read_text("utf-8"))["link"]["base_port"]
    with socket.create_server(("127.0.0.1", port + 1)):
        assert f"{port + 1}" in refuse(capsys, "remote", "--config", str(configs["remote"]))


def test_simulator_port_in_use(capsys: pytest.CaptureFixture[str], configs: dict[str, Path]) -> None:
    import tomllib

    address = tomllib.loads(configs["sim-operator"].read_text("utf-8"))["tacttip"]["index"]
    with socket.create_server(("127.0.0.1", int(address.rsplit(":", 1)[1]))):
        assert "index" in refuse(capsys, "sim-operator", "--config", str(configs["sim-operator"]))


def test_device_absent(capsys: pytest.CaptureFixture[str], configs: dict[str, Path]) -> None:
    edit(configs["operator"], "wait_for_devices_s = 20.0", "wait_for_devices_s = 0.5")
    line = refuse(capsys, "operator", "--config", str(configs["operator"]))
    assert "exoskeleton" in line or "tacttip" in line


def test_key_problems(capsys: pytest.CaptureFixture[str], configs: dict[str, Path], tmp_path: Path) -> None:
    secret = tmp_path / "keys" / "remote" / "site.key_secret"
    secret.chmod(0o644)
    assert "0644" in refuse(capsys, "remote", "--config", str(configs["remote"]))
    secret.chmod(0o600)
    TrustedKeys(tmp_path / "keys" / "operator").revoke("remote")
    assert "-- remote KEY" in refuse(capsys, "operator", "--config", str(configs["operator"]))
    assert "exists" in refuse(capsys, "keys", "init", "--keys", str(tmp_path / "keys" / "remote"))
    assert "nobody" in refuse(capsys, "keys", "revoke", "nobody", "--keys", str(tmp_path / "keys" / "remote"))
    assert "no public key" in refuse(capsys, "keys", "trust", "x", "y", "--keys", str(tmp_path / "keys" / "remote"))
    create_keys(tmp_path / "new")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("time_s,force_n\n0.0,0.0\n0.1,0.0\n", "column sensor_c is missing"),
        (THERMAL.replace("0.20,33.0", "0.20,warm"), "line 22: column sensor_c"),
        (THERMAL.replace("0.20,33.0", "0.20,nan"), "line 22: column sensor_c"),
        (THERMAL.replace("0.20,33.0", "0.20,"), "line 22: column sensor_c"),
        ("", "line 1: no header"),
    ],
)
def test_a_thermal_trace_that_cannot_be_read_is_answered_and_the_others_go_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, expected: str
) -> None:
    bad, free = tmp_path / "a.csv", tmp_path / "b.csv"
    bad.write_text(text, "utf-8")
    free.write_text(THERMAL, "utf-8")
    assert main(["identify", "thermal", "--table", str(TABLES / "materials.json"), str(bad), str(free)]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    of_bad = [line for line in lines if line["trace"] == str(bad)]
    assert {line["status"] for line in of_bad} == {"unidentifiable"}
    assert [line["final"] for line in of_bad].count(True) == 1
    for line in of_bad:
        assert line["material"] is None
        assert str(bad) in line["reason"]
        assert expected in line["reason"]
    assert {line["status"] for line in lines if line["trace"] == str(free)} == {"no_contact"}


def test_tables_and_numbers(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    trace = tmp_path / "a.csv"
    trace.write_text(THERMAL, "utf-8")
    assert "cannot be read" in refuse(capsys, "identify", "thermal", "--table", str(tmp_path / "no.json"), str(trace))
    assert "table" in refuse(capsys, "identify", "thermal", "--table", str(SURFACES), str(trace))
    table = str(TABLES / "materials.json")
    assert "--at" in refuse(capsys, "identify", "thermal", "--table", table, "--at", "1,soon", str(trace))
    assert "nothing to identify" in refuse(capsys, "identify", "thermal", "--table", table)
    assert "adamant" in refuse(
        capsys, "render", "thermal", "--object", "adamant", "--object-c", "20", "--air-c", "25", "--seconds", "1"
    )
    out = str(tmp_path / "t")
    assert "adamant" in refuse(capsys, "simulate", "thermal", "--material", "adamant", "--out", out)
    assert "velvet" in refuse(capsys, "simulate", "stroke", "--surface", "velvet", "--out", out)
    assert "labels.csv" in refuse(capsys, "calibrate", "thermal", "--traces", str(tmp_path), "--out", out)


def test_a_simulated_configuration_is_no_site_configuration(configs: dict[str, Path]) -> None:
    assert "can_port" in to_toml(SimRemoteConfig(texture={"index": "pty"}, thermal_sensors={"index": "pty"}))
    assert main(["remote", "--config", str(configs["sim-remote"])]) == 2

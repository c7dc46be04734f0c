"""A demonstration over a simulated network: its connections, and refusals before the start."""

from pathlib import Path

import pytest

from common.config.file import load_config
from common.config.simulation_models import SimNetworkConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.wire.streams import STREAMS
from sim_sensors.network.file import load_network
from teletaction.recordings.summary import proxy
from teletaction.session.demo import run_demo
from teletaction.session.demo_files import NETWORK, PROCESSES, DemoOptions, prepare
from tests.commands import command, one_line


def test_the_operator_reaches_the_remote_site_only_through_the_network(tmp_path: Path) -> None:
    configs = prepare(DemoOptions(fingers=1, network="mobile", seed=4), tmp_path)
    assert set(configs) == {*PROCESSES, NETWORK}
    network = load_config(configs[NETWORK], SimNetworkConfig)
    remote = load_config(configs["remote"], RemoteConfig).link.base_port
    operator = load_config(configs["operator"], OperatorConfig).link.base_port
    assert (network.base_port, network.to_base_port) == (operator, remote)
    assert abs(operator - remote) >= len(STREAMS)
    assert (network.network, network.seed, network.wait_for_start) == ("mobile", 4, True)


def test_without_a_network_the_sites_are_connected_directly(tmp_path: Path) -> None:
    configs = prepare(DemoOptions(fingers=1), tmp_path)
    assert tuple(configs) == PROCESSES
    remote = load_config(configs["remote"], RemoteConfig).link.base_port
    assert load_config(configs["operator"], OperatorConfig).link.base_port == remote


def test_a_file_is_found_wherever_the_process_starts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "drive.csv").write_text("send_time_s,rtt_ms\n0,20\n1,40\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    configs = prepare(DemoOptions(fingers=1, network="drive.csv"), tmp_path / "out")
    monkeypatch.chdir("/")
    network = load_network(load_config(configs[NETWORK], SimNetworkConfig).network)
    assert network.conditions(0.0).delay_s == 0.010


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("moon", "", "unknown network 'moon'; known: bad_evening"),
        ("line.toml", "[[phase]]\nfrom_s = 0\nloss = 2\n", "line.toml:3: phase.0.loss: "),
        ("drive.csv", "send_time_s,rtt_ms\n0,slow\n", "drive.csv:2: rtt_ms: 'slow' is no number"),
    ],
)
def test_a_bad_network_is_one_line_before_anything_starts(tmp_path: Path, name: str, text: str, expected: str) -> None:
    path = tmp_path / name if text else name
    if text:
        (tmp_path / name).write_text(text, "utf-8")
    assert expected in one_line(command("demo", "--headless", "--network", path, "--out", tmp_path / "out"), 2)


def test_a_waiting_network_needs_a_start_command(tmp_path: Path) -> None:
    (tmp_path / "n.toml").write_text('network = "lan"\nbase_port = 5700\nwait_for_start = true\n', "utf-8")
    assert "fault_port" in one_line(command("sim-network", "--config", tmp_path / "n.toml"), 2)


def test_the_summary_reports_the_network() -> None:
    assert proxy(None) is None
    status = {"network": "lan", "streams": {"motion": {}}, "faults": [{"kind": "cut"}], "pid": 7}
    assert proxy(status) == {"streams": {"motion": {}}, "faults": [{"kind": "cut"}]}


def test_a_demo_that_cannot_begin_leaves_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with pytest.raises(ValueError, match="unknown network"):
        run_demo(DemoOptions(fingers=1, network="nosuch"))
    assert list((tmp_path / "teletaction").iterdir()) == []

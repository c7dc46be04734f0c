"""A whole session as a user runs it: the command line, five processes' worth of output, and its end."""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from common import limits
from common.fingers import FINGERS
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(120)]

PROMPT_S = 3.0
"""Longest time from Ctrl-C to the prompt, s."""


def demo(out: Path, *arguments: str) -> list[str]:
    return [sys.executable, "-m", "teletaction", "demo", "--out", str(out), *arguments]


def children_of(text: str) -> list[str]:
    """Processes whose command line mentions `text`."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and entry.name != str(os.getpid()):
            try:
                command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            except (FileNotFoundError, ProcessLookupError):
                continue
            if text in command:
                found.append(command)
    return found


def test_a_headless_session_leaves_a_true_summary(tmp_path: Path) -> None:
    out = tmp_path / "out"
    run = subprocess.run(
        demo(out, "--headless", "--seconds", "9", "--scene", "materials", "--seed", "7", "--network", "lan"),
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert (run.returncode, run.stdout) == (0, ""), run.stderr
    summary: dict[str, Any] = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["scene"] == "materials"
    assert summary["seed"] == 7
    assert summary["network"] == "lan"
    assert summary["proxy"]["streams"]["motion"]["to_remote"]["bytes"] > 30_000
    assert len(summary["contacts"]) == len(FINGERS)
    assert summary["taps"]["made"] == summary["taps"]["played"] == len(FINGERS)
    assert summary["modes"]["agreement"] > 0.95
    assert summary["faults"] == []
    assert limits.WIDE.low_c <= summary["plate_c"]["min"] <= summary["plate_c"]["max"] <= limits.PLATE_FAULT_C
    assert summary["sensor_plate_c"]["max"] <= limits.SENSOR_PLATE_C
    assert 0.0 < summary["force_n"]["max"] <= limits.FINGER_FORCE_N
    assert 0.0 < summary["contact_force_n"]["max"] <= limits.CONTACT_FORCE_N
    assert summary["vibration_rpm"]["free_max"] < limits.MOTOR_FLOOR_RPM
    assert summary["latency_ms"]["contact_to_motor"]["count"] == len(FINGERS)
    assert summary["latency_ms"]["bare_curve_ping"]["p50"] > 0.0
    assert "<html" in (out / "report.html").read_text("utf-8")
    for name in ("remote", "operator", "sim-remote", "sim-operator", "network"):
        assert (out / f"{name}.log").is_file()
        assert (out / "config" / f"{name}.toml").is_file()
    with (out / "session.mcap").open("rb") as file:
        reader = make_reader(file)
        counts: dict[str, int] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert schema.data
            assert message.log_time > 0
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
    assert counts == summary["recorded"]
    assert counts["remote/touch"] == summary["packets"]["touch"]["sent"]
    assert counts["operator/motion"] == summary["packets"]["motion"]["sent"]


@pytest.fixture
def exploring(tmp_path: Path) -> "Iterator[subprocess.Popen[str]]":
    """A demo of one finger in full work, writing to `tmp_path / "out"`."""
    words = demo(tmp_path / "out", "--headless", "--seconds", "600", "--fingers", "1")
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            assert any("exploring" in line for line in process.stderr)
            yield process
        finally:
            process.kill()


def test_ctrl_c_returns_to_the_prompt_and_the_report_follows(
    exploring: "subprocess.Popen[str]", tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert len(children_of(str(out))) >= 4
    exploring.send_signal(signal.SIGINT)
    assert exploring.wait(PROMPT_S) == 0
    assert children_of(str(out / "config")) == []
    assert exploring.stderr is not None
    said = exploring.stderr.read()
    assert re.search(r"saved \d+ s of exploration in \S+/out: 4 recordings, complete\n", said), said
    assert f"{out / 'report.html'} is being made in the background" in said
    wait_until(lambda: not children_of(str(out)), "the report is not made", 60.0)
    assert "report.html" in (out / "summarise.log").read_text("utf-8")
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["latency_ms"]["bare_curve_ping"]["count"] > 10
    assert (out / "report.html").is_file()
    assert [path.name for path in out.glob("*.mcap")] == ["session.mcap"]


def test_a_killed_launcher_leaves_no_process(exploring: "subprocess.Popen[str]", tmp_path: Path) -> None:
    exploring.kill()
    exploring.wait()
    wait_until(lambda: not children_of(str(tmp_path / "out")), "a process runs on", 5.0)

"""A remote site behind a firewall with one open way out: by a rendezvous, by `ssh -R`, by WireGuard."""

import json
import shutil
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.commands import command
from tests.conftest import Keys
from tests.network.link_bench import MEASURED, Bench, assert_sound
from tests.network.two_host_session import FINGERS, Delays, TwoHostSession
from tests.network.two_hosts import Way
from tests.network.ways import over_rendezvous, over_ssh, over_wireguard

pytestmark = [pytest.mark.netns, pytest.mark.timeout(180)]

WAYS: dict[str, tuple[Way, str]] = {
    "rendezvous": (over_rendezvous, ""),
    "ssh": (over_ssh, "sshd"),
    "wireguard": (over_wireguard, "wireguard-go"),
}
"""What joins the hosts, and the program that it needs."""


@pytest.mark.parametrize("delay_ms", [0.0, 20.0])
@pytest.mark.parametrize("name", WAYS)
def test_the_link_works_with_one_way_out(
    name: str, delay_ms: float, keys: Keys, link_table: list[str], tmp_path: Path
) -> None:
    way, program = WAYS[name]
    if program and shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")
    with ExitStack() as ends:
        bench = Bench(keys, ends)
        if delay_ms:
            bench.hosts.impair(delay_ms, 0.1 * delay_ms, 0.01)
        bench.connect(way(bench.hosts, tmp_path))
        bench.accept(MEASURED)
        measured = bench.finish()
    link_table.append(measured.row(f"{name}, {delay_ms:g} ms{', loss 1%' * bool(delay_ms)}"))
    assert_sound(measured)
    assert np.median(measured.true_age_ns) >= 0.9e6 * delay_ms


def test_a_whole_session_keeps_its_figures_over_a_rendezvous(link_table: list[str], tmp_path: Path) -> None:
    figures: dict[str, dict[str, Any]] = {}
    for name, way in (("direct", None), ("rendezvous", over_rendezvous)):
        out = tmp_path / name
        out.mkdir()
        with ExitStack() as ends:
            session = TwoHostSession(ends, out, Delays(20.0, 20.0), way=way)
            session.finish()
        made = command("summarise", "--recordings", out, "--out", out / "result", "--fingers", FINGERS)
        assert made.code == 0, made.err
        figures[name] = json.loads((out / "result" / "summary.json").read_text("utf-8"))
        delays = figures[name]["latency_ms"]
        link_table.append(
            f"whole session, {name}: one way {delays['link_one_way']['p50']} / {delays['link_one_way']['p99']} ms, "
            f"contact to motor {delays['contact_to_motor']['p50']} ms, taps {figures[name]['taps']}"
        )
    for found in figures.values():
        assert (found["faults"], found["interruptions"]) == ([], [])
        assert found["taps"]["played"] >= 1
    direct, tunnelled = (figures[name]["latency_ms"]["link_one_way"]["p50"] for name in figures)
    assert tunnelled <= 1.1 * direct

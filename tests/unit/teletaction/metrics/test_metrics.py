"""Metrics over a socket: the content of a status file, a missing or old file, and the token."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from prometheus_client.parser import text_string_to_metric_families

from common.health import OLDEST_S
from teletaction.metrics.metrics import METRICS, PREFIX, StatusCollector, process_samples, samples
from teletaction.metrics.metrics_server import MOST_CLIENTS, ListenProblem, MetricsServer, read_token
from tests.commands import command, one_line
from tests.waiting import wait_until

STATUS: dict[str, Any] = {
    "process": "operator",
    "rss_mib": 80.5,
    "loop": {
        "period_ms": 2.0,
        "ticks": 1000,
        "late_p50_us": 50.0,
        "late_p99_us": 90.0,
        "late_max_us": 1500.0,
        "overruns": 3,
        "missed": 7,
        "cpu": 0.2,
    },
    "state": "fault",
    "fault": {"code": "plate-too-hot", "where": "thumb"},
    "missing": "",
    "age_ms": 4.5,
    "max_age_ms": 150.0,
    "rate_hz": 412.5,
    "works": 0.6,
    "real_time": False,
    "behind": "413 of 500 ticks a second",
    "behind_s": 17.5,
    "held_back": 15,
    "handshakes": {"admitted": 13, "refused": 14},
    "clock": {"offset_ns": -5, "uncertainty_ns": 150_000},
    "devices": {
        "exoskeleton": {
            "connected": True,
            "times_lost": 1,
            "refused": {"HandPose": 2, "FingerHeights": 3},
            "unknown": 0,
        },
        "index tacttip": {"serial": "TT0001", "times_lost": 4, "damaged": 5, "missed": 6, "unsent": 7},
        "thumb tacttip": {"serial": None},
    },
    "sent": {"motion": 990},
    "spared": {"motion": 4010},
    "received": {"touch": 980},
    "superseded": {"touch": 8},
    "refused": {"touch": {"age": 9, "sequence": 10}, "damaged": {"control": 11}},
    "recorded": {"operator/rendered": 1000},
    "recording_lost": 12,
    "recording_failed": "no space left",
}
TOKEN = "correct-horse-battery-staple"


def write_status(path: Path, age_s: float = 0.0, **changes: object) -> None:
    status = {**STATUS, **changes, "time_ns": time.monotonic_ns() - round(age_s * 1e9)}
    path.write_text(json.dumps(status), "utf-8")


@contextlib.contextmanager
def serving(status: list[Path], token: str | None = None, listen: str = "127.0.0.1:0") -> Iterator[tuple[str, int]]:
    stop = threading.Event()
    with MetricsServer(listen, StatusCollector(status), token) as server:
        thread = threading.Thread(target=server.serve, args=(stop.is_set,))
        thread.start()
        try:
            yield str(server.server_address[0]), server.server_address[1]
        finally:
            stop.set()
            thread.join()


def ask(address: tuple[str, int], path: str = "/metrics", **headers: str) -> tuple[int, dict[str, str], str]:
    connection = HTTPConnection(*address, timeout=20.0)
    try:
        connection.request("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        return answer.status, dict(answer.getheaders()), answer.read().decode()
    finally:
        connection.close()


def values(text: str) -> dict[tuple[str, tuple[tuple[str, str], ...]], float]:
    return {
        (sample.name.removeprefix(PREFIX), tuple(sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_the_status_of_a_site_is_served(tmp_path: Path) -> None:
    write_status(tmp_path / "operator.json")
    with serving([tmp_path / "operator.json"]) as address:
        code, headers, text = ask(address)
    assert code == 200
    assert headers["Content-Type"].startswith("text/plain; version=0.0.4")
    found = values(text)

    def value(name: str, **labels: str) -> float:
        return found[name, tuple(sorted({"process": "operator", **labels}.items()))]

    assert value("up") == 1.0
    assert 0.0 <= value("status_age_seconds") < OLDEST_S
    assert value("loop_late_seconds", quantile="0.99") == pytest.approx(90e-6)
    assert value("loop_late_seconds", quantile="1") == pytest.approx(1.5e-3)
    assert (value("loop_ticks_total"), value("loop_overruns_total")) == (1000.0, 3.0)
    assert value("loop_missed_total") == 7.0
    assert (value("loop_rate_hertz"), value("loop_behind"), value("loop_behind_seconds_total")) == (412.5, 1.0, 17.5)
    assert (value("loop_works_ratio"), value("loop_real_time")) == (0.6, 0.0)
    assert value("loop_ticks_held_back_total") == 15.0
    assert value("cpu_ratio") == 0.2
    assert value("resident_memory_peak_bytes") == 80.5 * 2**20
    states = {state: value("session_state", state=state) for state in ("disconnected", "connected", "engaged", "fault")}
    assert states == {"disconnected": 0.0, "connected": 0.0, "engaged": 0.0, "fault": 1.0}
    assert (value("fault"), value("devices_missing")) == (1.0, 0.0)
    assert value("packets_sent_total", stream="motion") == 990.0
    assert value("packets_spared_total", stream="motion") == 4010.0
    assert value("packets_received_total", stream="touch") == 980.0
    assert value("packets_superseded_total", stream="touch") == 8.0
    assert value("packets_refused_total", stream="touch", reason="age") == 9.0
    assert value("packets_refused_total", stream="touch", reason="sequence") == 10.0
    assert value("packets_damaged_total", stream="control") == 11.0
    assert value("packet_age_seconds") == pytest.approx(4.5e-3)
    assert value("clock_uncertainty_seconds") == pytest.approx(150e-6)
    assert value("packet_age_limit_seconds") == pytest.approx(0.15)
    assert value("handshakes_total", outcome="admitted") == 13.0
    assert value("handshakes_total", outcome="refused") == 14.0
    assert value("device_connected", device="exoskeleton") == 1.0
    assert value("device_connected", device="index tacttip") == 1.0
    assert value("device_connected", device="thumb tacttip") == 0.0
    assert value("device_lost_total", device="exoskeleton") == 1.0
    assert value("device_frames_damaged_total", device="exoskeleton") == 5.0
    assert value("device_frames_damaged_total", device="index tacttip") == 5.0
    assert value("device_frames_missed_total", device="index tacttip") == 6.0
    assert value("device_commands_unsent_total", device="index tacttip") == 7.0
    assert value("recording_written_total", stream="operator/rendered") == 1000.0
    assert value("recording_lost_total") == 12.0
    assert value("recording_failed") == 1.0
    served = {name.removesuffix("_total") for name, _ in found}
    assert served == METRICS.keys(), "each metric of the table was looked at here"


def test_an_old_or_missing_status_serves_only_up_and_age(tmp_path: Path) -> None:
    write_status(tmp_path / "old.json", age_s=OLDEST_S + 1.0)
    write_status(tmp_path / "before_start.json", age_s=-1000.0)
    (tmp_path / "broken.json").write_text('{"time_ns": ', "utf-8")
    names = ("old", "before_start", "broken", "absent")
    with serving([tmp_path / f"{name}.json" for name in names]) as address:
        found = values(ask(address)[2])
        up = {name: found.pop(("up", (("process", name),))) for name in names}
        assert up == dict.fromkeys(names, 0.0)
        assert {name for name, _ in found} == {"status_age_seconds"}
        assert found["status_age_seconds", (("process", "old"),)] > OLDEST_S
        write_status(tmp_path / "absent.json", state="engaged")
        assert values(ask(address)[2])["up", (("process", "absent"),)] == 1.0


@pytest.mark.parametrize(
    ("status", "shown"),
    [
        ({"state": "engaged"}, "engaged"),
        ({"state": "engaged", "stale": "no touch for 0.30 s"}, "lost"),
        ({"state": "lost", "stale": "no touch for 0.30 s"}, "lost"),
        ({"state": "engaging"}, "engaging"),
    ],
)
def test_no_state_that_acts_is_served_while_the_link_is_silent(status: dict[str, Any], shown: str) -> None:
    found = {labels["state"]: value for name, labels, value in samples(status) if name == "session_state"}
    assert [state for state, value in found.items() if value] == [shown]
    assert ("fault", {}, 0.0) in list(samples(status))


def test_an_ended_process_is_down_even_with_a_fresh_status(tmp_path: Path) -> None:
    write_status(tmp_path / "remote.json", state="ended")
    (name, _, value), *others = process_samples(tmp_path / "remote.json", time.monotonic_ns())
    assert (name, value) == ("up", 0.0)
    assert [name for name, _, _ in others] == ["status_age_seconds"]


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers(-(2**70), 2**70) | st.just(10**400) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from([*STATUS, "other"]), JSON))
def test_a_status_with_any_content_is_no_error(status: dict[str, Any]) -> None:
    for name, labels, value in samples({**STATUS, **status}):
        assert name in METRICS
        assert all(isinstance(label, str) for label in labels.values())
        assert abs(value) < 1e30


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Authorization": "Bearer wrong-token-of-some-length"},
        {"Authorization": TOKEN},
        {"Authorization": f"Basic {TOKEN}"},
        {"Authorization": f"Bearer {TOKEN}x"},
        {"Authorization": "Bearer "},
    ],
)
def test_nothing_is_served_without_the_token(tmp_path: Path, headers: dict[str, str]) -> None:
    write_status(tmp_path / "operator.json")
    with serving([tmp_path / "operator.json"], TOKEN) as address:
        for path in ("/metrics", "/other"):
            code, answered, text = ask(address, path, **headers)
            assert (code, answered["WWW-Authenticate"]) == (401, "Bearer")
            assert PREFIX not in text
        assert ask(address, Authorization=f"Bearer {TOKEN}")[0] == 200


def test_there_is_one_page_and_one_method(tmp_path: Path) -> None:
    with serving([tmp_path / "operator.json"]) as address:
        assert ask(address, "/")[0] == 404
        assert ask(address, "/metrics?x=1")[0] == 200
        connection = HTTPConnection(*address, timeout=20.0)
        connection.request("POST", "/metrics", body=b"x")
        assert connection.getresponse().status == 501
        connection.close()


def test_a_silent_or_lost_client_does_not_delay_the_others(tmp_path: Path) -> None:
    with serving([tmp_path / "operator.json"]) as address:
        with socket.create_connection(address), socket.create_connection(address) as rude:
            rude.sendall(b"GET /metr")
            assert ask(address)[0] == 200
        assert ask(address)[0] == 200


def test_many_slow_clients_hold_a_bounded_number_of_threads(tmp_path: Path) -> None:
    before = threading.active_count()
    with serving([tmp_path / "operator.json"]) as address, contextlib.ExitStack() as slow:
        for _ in range(3 * MOST_CLIENTS):
            slow.enter_context(socket.create_connection(address)).sendall(b"GET /metrics HTTP/1.1\r\n")
        assert ask(address)[0] == 200  # all of them were accepted before
        wait_until(lambda: threading.active_count() - before <= MOST_CLIENTS + 1, patience_s=2.0)


@pytest.mark.parametrize("listen", ["0.0.0.0:0", "[::]:0"])
def test_a_token_is_needed_beyond_loopback(tmp_path: Path, listen: str) -> None:
    if listen.startswith("[") and not socket.has_dualstack_ipv6():
        pytest.skip("no IPv6 here")
    with pytest.raises(ListenProblem, match=r"others can reach this address: give a --token-file"):
        MetricsServer(listen, StatusCollector([]), None)
    with serving([tmp_path / "operator.json"], TOKEN, listen) as (_, port):
        assert ask(("127.0.0.1", port))[0] == 401
        assert ask(("127.0.0.1", port), Authorization=f"Bearer {TOKEN}")[0] == 200


@pytest.mark.parametrize(
    "listen", ["", "9634", "127.0.0.1:", ":9634", "127.0.0.1:99999", "127.0.0.1:-1", "127.0.0.1:x"]
)
def test_a_wrong_address_is_reported(listen: str) -> None:
    with pytest.raises(ListenProblem, match=r"expected HOST:PORT, such as 127\.0\.0\.1:9634"):
        MetricsServer(listen, StatusCollector([]), None)


@pytest.mark.timeout(20)
def test_a_token_file_that_is_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    pipe = tmp_path / "token"
    os.mkfifo(pipe, 0o600)
    with pytest.raises(OSError, match="is no regular file"):
        read_token(pipe)


def test_a_token_readable_by_others_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_text(TOKEN + "\n", "utf-8")
    file.chmod(0o600)
    assert read_token(file) == TOKEN
    file.chmod(0o640)
    with pytest.raises(ListenProblem, match=r"mode 0640 lets others read the token; `chmod 600` it"):
        read_token(file)
    file.chmod(0o600)
    for bad in ("", "short", "two words in the file", "é" * 20):
        file.write_text(bad, "utf-8")
        with pytest.raises(ListenProblem, match="a token is"):
            read_token(file)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--listen", "0.0.0.0:0", "--status", "a.json"], "others can reach this address"),
        (["--status", "a/x.json", "--status", "b/x.json"], "two files have one name"),
        (["--status", "a.json", "--token-file", "/nowhere/token"], "No such file"),
        ([], "--status"),
    ],
)
def test_bad_input_is_one_line(arguments: list[str], says: str) -> None:
    assert says in one_line(command("metrics", *arguments), 2)


def test_the_command_serves_until_it_is_stopped(tmp_path: Path) -> None:
    write_status(tmp_path / "remote.json", process="remote")
    served = [sys.executable, "-m", "teletaction", "metrics", "--listen", "127.0.0.1:0", "--status"]
    with subprocess.Popen([*served, str(tmp_path / "remote.json")], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        line = process.stderr.readline()
        port = int(line.rsplit(":", 1)[1].removesuffix("/metrics\n"))
        assert ask(("127.0.0.1", port))[0] == 200
        os.kill(process.pid, signal.SIGTERM)
        assert process.wait(30) == 0
        assert process.stderr.read() == ""

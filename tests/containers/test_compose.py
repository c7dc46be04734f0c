"""The demonstration of the how-to: started, used, a process killed, an emergency stop, ended, and judged."""

import json
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from common import limits
from common.fingers import FINGERS
from tests.containers.checkout import Checkout, run, wait_for
from tests.containers.console_page import assert_closed_to_strangers, assert_used_by_its_tokens, read_tokens
from tests.containers.howto import blocks, named_in_passing

pytestmark = [pytest.mark.containers, pytest.mark.timeout(600)]

PAGE = "docs/howto/first-session.md"
SERVICES = {
    "sim-remote": "sim-remote",
    "sim-operator": "sim-operator",
    "remote": "remote-site",
    "operator": "operator-site",
    "console": "console",
}
"""Service of each process."""
KILL = "import json, os; os.kill(json.load(open('/session/remote.json'))['pid'], 9)"
SESSION = "docker-compose exec -T operator-site python -m teletaction session {} --config /config/operator.toml"


@pytest.fixture
def demo(tmp_path: Path) -> Iterator[Checkout]:
    checkout = Checkout(tmp_path / "teletaction")
    try:
        yield checkout
    finally:
        checkout.remove()


def test_the_demonstration_survives_a_killed_site_and_keeps_every_limit(demo: Checkout) -> None:
    up, look, tokens, engaged, end = blocks(PAGE)["In containers"]
    begin_s = time.monotonic()
    with demo.start(up) as attached:
        try:
            use(demo, begin_s, look, tokens, engaged)
            demo(end, seconds=180.0)
            attached.communicate(timeout=30.0)
        finally:
            attached.kill()
    assert set(named_in_passing("README.md")) <= set(demo.ran), "the README names commands that nobody tried"
    judge(demo.folder / "session-result")


def use(demo: Checkout, begin_s: float, look: str, tokens: str, engaged: str) -> None:
    """All that happens between up and stop."""
    wait_for(lambda: all(demo.healthy(service) for service in SERVICES.values()), "all healthy", 400.0)
    print(f"from nothing to healthy: {time.monotonic() - begin_s:.0f} s")
    demo(look)
    assert_confined(demo)
    wait_for(lambda: demo(engaged) == "", "engaged", 60.0)
    use_console(demo, read_tokens(demo(tokens)))
    kill_a_site(demo)
    wait_for(lambda: demo(engaged) == "", "engaged again", 60.0)
    stop_in_an_emergency(demo)
    wait_for(lambda: demo(engaged) == "", "engaged after the stop", 60.0)
    worked_s = script_s(demo)
    wait_for(lambda: script_s(demo) > worked_s + 8.0, "8 s more of work", 60.0)


def assert_confined(demo: Checkout) -> None:
    """Each service is nobody of importance, writes nowhere but where it must, and has a share of the machine."""
    for service in (*SERVICES.values(), "operator-host"):
        container = json.loads(run("docker", "inspect", demo.container(service)))[0]
        host = container["HostConfig"]
        assert container["Config"]["User"] == "teletaction"
        assert host["ReadonlyRootfs"]
        assert host["Init"]
        assert host["CapDrop"] == ["ALL"]
        assert host["SecurityOpt"] == ["no-new-privileges:true"]
        assert 0 < host["Memory"] <= 2**30
        assert 0 < host["NanoCpus"] <= 1.5e9
        assert 0 < host["PidsLimit"] <= 64
        who = run("docker", "exec", demo.container(service), "sh", "-c", "id -u; touch /usr/x 2>&1 || true")
        assert who.startswith("10001\n")
        assert "Read-only file system" in who


def script_s(demo: Checkout) -> float:
    return float(demo.status("sim-operator", "sim-operator")["script_s"])


def use_console(demo: Checkout, tokens: dict[str, str]) -> None:
    """It is published on this machine's loopback alone, and is for who has a token there."""
    port = int(demo.environment["CONSOLE_PORT"])
    network = f"{demo.environment['COMPOSE_PROJECT_NAME']}_session"
    outside = run("docker", "network", "inspect", "-f", "{{(index .IPAM.Config 0).Gateway}}", network).strip()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((outside, port), timeout=5.0)
    certificate = demo.folder / "certificate.pem"
    run("docker", "cp", f"{demo.container('console')}:/keys/console/certificate.pem", str(certificate))
    address, trust = f"https://localhost:{port}", ssl.create_default_context(cafile=certificate)
    assert_closed_to_strangers(address, trust)
    assert_used_by_its_tokens(address, trust, tokens)


def kill_a_site(demo: Checkout) -> None:
    """The engine starts again what has ended."""
    ticks, restarts = (
        demo.status("remote-site", "remote")["loop"]["ticks"],
        int(demo.inspect("remote-site", ".RestartCount")),
    )
    # Its exit code says nothing: the command may end with the container whose process it kills.
    kill = ("docker", "exec", demo.container("remote-site"), "python", "-c", KILL)
    subprocess.run(kill, capture_output=True, timeout=30, check=False)
    wait_for(lambda: int(demo.inspect("remote-site", ".RestartCount")) == restarts + 1, "restarted", 30.0)
    wait_for(lambda: demo.status("remote-site", "remote")["loop"]["ticks"] < ticks, "running again", 60.0)


def stop_in_an_emergency(demo: Checkout) -> None:
    """Both sites latch, are not healthy while they do, and engage again when a person has said so."""
    demo(SESSION.format("estop"))
    begin_s = time.monotonic()
    wait_for(lambda: demo.inspect("operator-site", ".State.Health.Status") == "unhealthy", "operator unhealthy", 20.0)
    # It was started again just before, and is allowed its time to come up.
    wait_for(lambda: demo.inspect("remote-site", ".State.Health.Status") == "unhealthy", "remote unhealthy", 35.0)
    print(f"unhealthy {time.monotonic() - begin_s:.1f} s after an emergency stop")
    assert demo.healthy("console")
    demo(SESSION.format("clear"))
    demo(SESSION.format("engage"))
    wait_for(lambda: demo.healthy("operator-site") and demo.healthy("remote-site"), "healthy again", 20.0)


def judge(result: Path) -> None:
    """What really happened at the simulated devices."""
    assert (result / "report.html").stat().st_size > 0
    summary = json.loads((result / "summary.json").read_text("utf-8"))
    assert summary["duration_s"] > 20.0
    assert {contact["finger"] for contact in summary["contacts"]} == set(FINGERS)
    assert 0 < summary["taps"]["played"] <= summary["taps"]["made"]
    assert {fault["fault"] for fault in summary["faults"] if fault["what"] == "fault"} == {
        "emergency stop by the operator"
    }
    assert limits.COMFORT.low_c <= summary["plate_c"]["min"]
    assert summary["plate_c"]["max"] <= limits.PLATE_FAULT_C
    assert summary["sensor_plate_c"]["max"] <= limits.SENSOR_PLATE_C
    assert 0.0 < summary["force_n"]["max"] <= limits.FINGER_FORCE_N
    assert 0.0 < summary["contact_force_n"]["max"] <= limits.CONTACT_FORCE_N
    assert summary["vibration_rpm"]["free_max"] < limits.MOTOR_FLOOR_RPM
    # As the containers are limited: a process that needed more would have been killed.
    print(
        "memory, MiB:", summary["rss_mib"], "processor:", {name: loop["cpu"] for name, loop in summary["loop"].items()}
    )
    assert all(mib < 200.0 for mib in summary["rss_mib"].values())

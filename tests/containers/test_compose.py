"""The composition as it stands: built, brought up, a process killed, taken down, and the session judged."""

import json
import os
import shutil
import socket
import ssl
import subprocess
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from websockets.exceptions import ConnectionClosed

from common import limits
from common.fingers import FINGERS
from teletaction.conclude import conclude
from teletaction.demo_files import DemoOptions
from tests.session.page import opened

pytestmark = [pytest.mark.containers, pytest.mark.timeout(600)]

ROOT = Path(__file__).parents[2]
SERVICES = {
    "sim-remote": "sim-remote",
    "sim-operator": "sim-operator",
    "remote": "remote-site",
    "operator": "operator-site",
    "console": "console",
}
PAGE = 8090
KILL = "import json, os; os.kill(json.load(open('/session/remote.json'))['pid'], 9)"


def run(*command: str, seconds: float = 60.0) -> str:
    """Run a command and return what it printed."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=seconds, check=False)
    assert done.returncode == 0, f"{' '.join(command)}: {done.stdout[-3000:]} {done.stderr[-3000:]}"
    return done.stdout


class Composition:
    """One project of its own; its containers, network and volumes carry its name."""

    def __init__(self) -> None:
        has_plugin = subprocess.run(("docker", "compose", "version"), capture_output=True, timeout=30, check=False)
        compose = ("docker", "compose") if has_plugin.returncode == 0 else ("docker-compose",)
        self._compose = (*compose, "-p", f"teletaction-test-{uuid.uuid4().hex[:8]}")
        os.environ["CONSOLE_PORT"] = str(free_port())

    def __call__(self, *words: str, seconds: float = 60.0) -> str:
        return run(*self._compose, *words, seconds=seconds)

    def container(self, process: str) -> str:
        return self("ps", "-q", SERVICES[process]).strip()

    def health(self, process: str) -> str:
        return run("docker", "inspect", "-f", "{{.State.Health.Status}}", self.container(process)).strip()

    def restarts(self, process: str) -> int:
        return int(run("docker", "inspect", "-f", "{{.RestartCount}}", self.container(process)))

    def status(self, process: str) -> dict[str, Any]:
        text = run("docker", "exec", self.container("sim-operator"), "cat", f"/session/{process}.json")
        status: dict[str, Any] = json.loads(text)
        return status

    def page(self, folder: Path) -> tuple[str, ssl.SSLContext]:
        """Where the console is on this host, and what its certificate is checked against."""
        certificate = folder / "certificate.pem"
        run("docker", "cp", f"{self.container('console')}:/keys/console/certificate.pem", str(certificate))
        published = self("port", "operator-host", str(PAGE)).strip()
        assert published == f"127.0.0.1:{os.environ['CONSOLE_PORT']}"
        return f"https://{published}", ssl.create_default_context(cafile=certificate)

    def tokens(self) -> dict[str, str]:
        """The console's tokens by what they are for."""
        lines = run("docker", "exec", self.container("console"), "cat", "/keys/console/tokens").splitlines()
        return {role: token for _, role, token in map(str.split, lines)}

    def engaged(self) -> bool:
        return all(self.status(site)["state"] == "engaged" for site in ("remote", "operator"))


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


@pytest.fixture
def composition() -> Iterator[Composition]:
    if shutil.which("docker") is None:
        pytest.fail('no docker here: `eval "$(tests/containers/engine.sh)"` first')
    found = Composition()
    try:
        yield found
    finally:
        found("down", "--volumes", "--timeout", "3", seconds=120.0)


def wait_for(what: Callable[[], bool], told: str, seconds: float) -> None:
    """Poll once a second; an answer that cannot be had yet counts as no."""
    deadline_s = time.monotonic() + seconds
    while time.monotonic() < deadline_s:
        try:
            if what():
                return
        except AssertionError:
            pass  # its container is just being restarted
        time.sleep(1.0)
    raise AssertionError(f"{told}: not within {seconds:g} s")


def use_console(composition: Composition, folder: Path) -> None:
    """Its page is for who has a token; a finding is made on it."""
    address, trust = composition.page(folder)
    tokens = composition.tokens()
    with pytest.raises(HTTPError, match="401"):
        urlopen(address + "/page/main.js", context=trust)
    for headers in ({}, {"Cookie": "teletaction=" + "0" * 64}):
        with opened(address, ssl=trust, **headers) as stranger, pytest.raises(ConnectionClosed):
            stranger.until(lambda page=stranger: page.state, "nothing")
    with (
        opened(address, ssl=trust, Cookie=f"teletaction={tokens['act']}") as page,
        opened(address, ssl=trust, Cookie=f"teletaction={tokens['observe']}") as observer,
    ):
        page.until(lambda: page.state and page.state["session"]["state"] == "engaged", "an engaged session")
        page.until(lambda: page.picture is not None and len(page.picture.bins) > 0, "a picture")
        assert page.state["meaning"].startswith("Calibrated ")
        assert page.ask("begin", pseudonym="P-0417")["ok"]
        assert page.ask("finding", finger="index", kind="warm")["details"]["saved"]
        observer.until(lambda: observer.state and observer.state["findings"], "the finding")
        assert not observer.ask("estop")["ok"]
        # A machine that builds and starts all of this may let a request wait too long: a person asks again.
        page.until(lambda: page.ask("end")["ok"], "the end")
        page.until(lambda: (page.state["session"]["saved"] or {}).get("report"), "the report", 120.0)
        assert page.ask("sound", answer="refused")["ok"]
        page.until(lambda: page.ask("engage")["ok"], "engaging again")
        report = Request(address + page.state["session"]["saved"]["report"])
    report.add_header("Cookie", f"teletaction={tokens['observe']}")
    assert "P-0417" in urlopen(report, context=trust).read().decode()


def test_a_composition_survives_a_killed_site_and_keeps_every_limit(composition: Composition, tmp_path: Path) -> None:
    composition("build", seconds=400.0)
    composition("up", "--detach", seconds=120.0)
    wait_for(lambda: all(composition.health(process) == "healthy" for process in SERVICES), "all healthy", 90.0)
    wait_for(composition.engaged, "engaged", 60.0)
    wait_for(lambda: composition.status("sim-operator")["script_s"] > 15.0, "15 s of work", 60.0)

    use_console(composition, tmp_path)
    ticks, restarts = composition.status("remote")["loop"]["ticks"], composition.restarts("remote")
    # Its exit code says nothing: the command may end with the container whose process it kills.
    kill = ("docker", "exec", composition.container("remote"), "python", "-c", KILL)
    subprocess.run(kill, capture_output=True, timeout=30, check=False)
    wait_for(lambda: composition.restarts("remote") == restarts + 1, "restarted", 30.0)
    wait_for(lambda: composition.status("remote")["loop"]["ticks"] < ticks, "running again", 60.0)
    wait_for(composition.engaged, "engaged again", 60.0)
    run(
        "docker",
        "exec",
        composition.container("remote"),
        "python",
        "-m",
        "common.health",
        "/session/remote.json",
        "--state",
        "engaged",
    )
    before = composition.status("sim-operator")["script_s"]
    wait_for(lambda: composition.status("sim-operator")["script_s"] > before + 8.0, "8 s more of work", 60.0)
    source = f"{composition.container('sim-operator')}:/session/."
    composition("stop", "--timeout", "5", seconds=90.0)
    run("docker", "cp", source, str(tmp_path / "session"))

    assert (tmp_path / "session" / "remote-1.mcap").stat().st_size > 0, "the killed site's recording was not kept"
    conclude(tmp_path / "session", tmp_path / "result", DemoOptions())
    summary = json.loads((tmp_path / "result" / "summary.json").read_text("utf-8"))
    assert (tmp_path / "result" / "report.html").stat().st_size > 0
    assert summary["duration_s"] > 20.0
    assert {contact["finger"] for contact in summary["contacts"]} == set(FINGERS)
    assert 0 < summary["taps"]["played"] <= summary["taps"]["made"]
    assert summary["faults"] == []
    assert limits.COMFORT.low_c <= summary["plate_c"]["min"]
    assert summary["plate_c"]["max"] <= limits.PLATE_FAULT_C
    assert summary["sensor_plate_c"]["max"] <= limits.SENSOR_PLATE_C
    assert 0.0 < summary["force_n"]["max"] <= limits.FINGER_FORCE_N
    assert 0.0 < summary["contact_force_n"]["max"] <= limits.CONTACT_FORCE_N
    assert summary["vibration_rpm"]["free_max"] < limits.MOTOR_FLOOR_RPM
    # As the containers are limited: a process that needed more would have been killed.
    assert all(mib < 200.0 for mib in summary["rss_mib"].values())

"""The service file: what it says fits the program, and systemd finds nothing wrong with it."""

import configparser
import shutil
import subprocess
from pathlib import Path

import pytest

from common.config import SiteConfig
from common.ladder import NOTICE_S, SITE_WATCHDOG_S, SUPERVISOR_WATCHDOG_S
from common.watchdog import EXIT_CODE

UNIT = Path(__file__).parents[2] / "deploy" / "systemd" / "teletaction@.service"


@pytest.fixture
def service() -> dict[str, str]:
    """The section of the service; of a name given twice, the last value."""
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    parser.optionxform = str  # type: ignore[assignment, method-assign]
    parser.read(UNIT, "utf-8")
    return dict(parser["Service"])


def test_the_supervisors_watchdog_is_the_ladders(service: dict[str, str]) -> None:
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) == SUPERVISOR_WATCHDOG_S > SITE_WATCHDOG_S + NOTICE_S


def test_a_start_may_take_as_long_as_devices_may_be_waited_for(service: dict[str, str]) -> None:
    longest_s = next(
        limit.le for limit in SiteConfig.model_fields["wait_for_devices_s"].metadata if hasattr(limit, "le")
    )
    assert float(service["TimeoutStartSec"]) > longest_s


def test_what_failed_is_started_again_and_what_ended_well_is_not(service: dict[str, str]) -> None:
    assert service["Restart"] == "on-failure"
    assert EXIT_CODE != 0
    assert "StartLimitIntervalSec=0" in UNIT.read_text("utf-8")


def test_it_runs_as_its_own_user_with_nothing_secret_in_the_file(service: dict[str, str]) -> None:
    assert service["User"] == "teletaction"
    assert service["CapabilityBoundingSet"] == ""
    assert service["LimitCORE"] == "0"
    assert {"PYTHONFAULTHANDLER", "PYTHONUNBUFFERED"} == {pair.split("=")[0] for pair in service["Environment"].split()}


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not there")
@pytest.mark.parametrize("site", ["remote", "operator"])
def test_systemd_finds_nothing_wrong(site: str, tmp_path: Path) -> None:
    installed = tmp_path / f"teletaction@{site}.service"
    text = UNIT.read_text("utf-8")
    program = "/opt/teletaction/bin/teletaction"
    assert program in text
    installed.write_text(text.replace(program, "/bin/true"), "utf-8")  # it is not installed here
    verified = subprocess.run(
        ["systemd-analyze", "verify", str(installed)], capture_output=True, text=True, timeout=50, check=False
    )
    assert (verified.returncode, verified.stderr) == (0, "")

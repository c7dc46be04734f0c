"""The service file fits the program, and systemd accepts it."""

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from common.config.site_models import SiteConfig
from common.runtime.watchdog import EXIT_CODE
from common.timing.timeouts import NOTICE_S, SITE_WATCHDOG_S, SUPERVISOR_WATCHDOG_S
from tests.places import ROOT

UNIT = ROOT / "deploy" / "systemd" / "teletaction@.service"
CONSOLE = UNIT.with_name("console-memory.conf")


def test_the_service_fits_the_program() -> None:
    parser = configparser.ConfigParser(interpolation=None, strict=False)  # of a name given twice, the last value
    parser.optionxform = str  # type: ignore[assignment, method-assign]
    parser.read(UNIT, "utf-8")
    service = parser["Service"]
    # The supervisor's watchdog is the ladder's, and a start may take as long as devices may be waited for.
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) == SUPERVISOR_WATCHDOG_S > SITE_WATCHDOG_S + NOTICE_S
    limits = SiteConfig.model_fields["wait_for_devices_s"].metadata
    assert float(service["TimeoutStartSec"]) > next(limit.le for limit in limits if hasattr(limit, "le"))
    # What failed is started again, and what ended well is not.
    assert service["Restart"] == "on-failure"
    assert EXIT_CODE != 0
    assert "StartLimitIntervalSec=0" in UNIT.read_text("utf-8")
    # It runs as its own user with nothing secret in the file.
    assert service["User"] == "teletaction"
    assert service["CapabilityBoundingSet"] == ""
    assert service["LimitCORE"] == "0"
    assert {"PYTHONFAULTHANDLER", "PYTHONUNBUFFERED"} == {pair.split("=")[0] for pair in service["Environment"].split()}


def test_the_console_may_use_as_much_memory_as_in_its_container() -> None:
    parser = configparser.ConfigParser(interpolation=None)
    assert parser.read(CONSOLE, "utf-8")
    composed = (ROOT / "docker-compose.yml").read_text("utf-8").partition("\n  console:\n")[2]
    limit = re.search(r"^    mem_limit: (\w+)", composed, re.MULTILINE)
    assert limit is not None
    assert parser["Service"]["MemoryMax"] == limit[1].upper() == "1G"
    assert CONSOLE.name in UNIT.with_name("README.md").read_text("utf-8")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not there")
@pytest.mark.parametrize("site", ["remote", "operator"])
def test_systemd_accepts_the_service(site: str, tmp_path: Path) -> None:
    installed = tmp_path / f"teletaction@{site}.service"
    text = UNIT.read_text("utf-8")
    program = "/opt/teletaction/bin/teletaction"
    assert program in text
    installed.write_text(text.replace(program, "/bin/true"), "utf-8")  # it is not installed here
    verified = subprocess.run(
        ["systemd-analyze", "verify", str(installed)], capture_output=True, text=True, timeout=50, check=False
    )
    assert (verified.returncode, verified.stderr) == (0, "")

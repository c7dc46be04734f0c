"""The test bed: its page's example runs, and it refuses an impossible command."""

import re
from pathlib import Path

import pytest

from common.link.session_state import Refused
from teletaction.testbed.network_faults import NetworkFaults
from tests.places import ROOT
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

PAGE = ROOT / "docs" / "howto" / "testbed.md"


def test_the_example_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(example, {})
    age_ms = float(capsys.readouterr().out.split()[0])
    assert 80.0 <= age_ms <= 125.0, "of a packet on a way of 100 +- 20 ms"


def test_a_local_request_is_answered_or_refused(working: VirtualSession) -> None:
    assert working.ask_desk("remote", "status")["state"] == "engaged"
    with pytest.raises(Refused):
        working.ask_desk("remote", "dance")


def test_the_network_takes_the_commands_of_the_simulated_one(working: VirtualSession) -> None:
    network = NetworkFaults(working.network)
    network.obey("partition 1")
    network.step()
    working.run(0.5)
    assert not working.at_work
    network.obey("clear")
    working.resume()
    for word in ("cut", "half_open 5"):
        with pytest.raises(ValueError, match="no connections"):
            network.obey(word)

"""Health of a process from its status file, and the page of limits."""

import json
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_figures
from common.health import OLDEST_S, find_problem, main
from common.limits_table import limits_page
from tests.places import ROOT

NOW_NS = 1_000_000_000_000


def status(tmp_path: Path, **fields: object) -> Path:
    path = tmp_path / "status.json"
    path.write_text(json.dumps(fields))
    return path


@pytest.mark.parametrize(("age_s", "healthy"), [(0.0, True), (4.9, True), (5.1, False), (-1.0, False)])
def test_a_status_must_be_young(tmp_path: Path, age_s: float, healthy: bool) -> None:
    problem = find_problem(status(tmp_path, time_ns=NOW_NS - round(age_s * 1e9)), NOW_NS)
    assert (problem == "") is healthy


def test_a_site_must_be_in_the_state_asked_for_and_its_process_must_not_have_ended(tmp_path: Path) -> None:
    path = status(tmp_path, time_ns=NOW_NS, state="connected", paused="console was hidden for 3 s")
    assert find_problem(path, NOW_NS) == ""
    assert find_problem(path, NOW_NS, "connected") == ""
    assert find_problem(path, NOW_NS, "engaged").endswith("connected, expected engaged (console was hidden for 3 s)")
    path = status(tmp_path, time_ns=NOW_NS, state="ended")
    for expected in (None, "engaged", "ended"):
        assert find_problem(path, NOW_NS, expected).endswith("the process has ended")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing", "index texture sensor: opening"),
        ("stale", "no touch for 0.30 s"),
        ("keys", "/keys/trusted:2: not UTF-8; remove this line"),
    ],
)
def test_an_unsafe_or_stale_process_is_not_healthy(tmp_path: Path, name: str, words: str) -> None:
    sound = {"fault": None, **dict.fromkeys(("missing", "stale", "keys"), "")}
    assert find_problem(status(tmp_path, time_ns=NOW_NS, state="engaged", **sound), NOW_NS, "engaged") == ""
    path = status(tmp_path, time_ns=NOW_NS, state="engaged", **(sound | {name: words}))
    assert find_problem(path, NOW_NS).endswith(f"{name}: {words}")
    assert find_problem(path, NOW_NS, "engaged").endswith(f"{name}: {words}")


def test_a_fault_in_another_form_is_reported_as_it_stands(tmp_path: Path) -> None:
    assert find_problem(status(tmp_path, time_ns=NOW_NS, fault={"code": "new"}), NOW_NS).endswith("{'code': 'new'}")


def test_a_latched_fault_is_unhealthy_and_is_reported(tmp_path: Path) -> None:
    fault = fault_figures(Fault(FaultCode.PLATE_TOO_HOT, "thumb", value=42.3, limit=42.0))
    path = status(tmp_path, time_ns=NOW_NS, state="fault", fault=fault)
    assert find_problem(path, NOW_NS).endswith("fault: thumb: plate at 42.3 C, above 42.0 C")
    path = status(tmp_path, time_ns=NOW_NS, state="fault", fault="of another version")
    assert find_problem(path, NOW_NS).endswith("fault: of another version")


@given(age_s=st.floats(OLDEST_S, 1e6), words=st.sampled_from(["engaged", "engaging", "connected"]))
def test_no_old_status_passes_for_a_state(tmp_path_factory: pytest.TempPathFactory, age_s: float, words: str) -> None:
    path = status(tmp_path_factory.mktemp("old"), time_ns=NOW_NS - round(age_s * 1e9), state=words)
    said = find_problem(path, NOW_NS, words)
    assert words not in said
    assert ": silent, " in said
    assert said.endswith(f"s old, expected less than {OLDEST_S:g} s")


def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = status(tmp_path, time_ns=time.monotonic_ns(), state="engaged")
    assert main([str(path), "--state", "engaged"]) == 0
    assert main([str(tmp_path / "absent.json")]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert "absent.json: No such file" in printed.err


def test_the_page_of_limits_is_up_to_date() -> None:
    page = ROOT / "docs" / "limits.md"
    assert page.read_text("utf-8") == limits_page(), "python -m common.limits_table > docs/limits.md"

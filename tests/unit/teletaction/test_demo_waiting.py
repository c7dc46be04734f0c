"""A demo that did not start reports the current state of its sites, never an old one."""

import json
import time
from pathlib import Path

from teletaction.session.demo import _waiting_for


def test_a_site_that_has_not_started_or_is_silent_is_named(tmp_path: Path) -> None:
    def write(name: str, age_s: float, **fields: object) -> None:
        time_ns = time.monotonic_ns() - round(age_s * 1e9)
        (tmp_path / f"{name}.json").write_text(json.dumps({"time_ns": time_ns, **fields}), "utf-8")

    write("operator", 0.0, state="connected")
    assert _waiting_for(tmp_path) == "remote has not started; operator connected"
    write("remote", 60.0, state="engaged", missing="")
    write("operator", 0.0, state="connected", missing="index tacttip: opening")
    assert _waiting_for(tmp_path) == "remote silent, 60.0 s old; operator connected index tacttip: opening"


def test_a_session_that_does_not_begin_names_the_fault_and_the_late_loop_of_a_site(tmp_path: Path) -> None:
    fault = {"text": "hand's x: does not obey"}
    (tmp_path / "remote.json").write_text(
        json.dumps({"time_ns": time.monotonic_ns(), "state": "fault", "fault": fault, "behind": "56 of 250 ticks"})
    )
    assert _waiting_for(tmp_path).startswith("remote fault: hand's x: does not obey, loop behind: 56 of 250 ticks;")

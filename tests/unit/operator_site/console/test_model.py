"""From what is fed to what is shown: everything that is known, and nothing old as if it were now."""

import json
import math
from typing import Any

import msgpack
import numpy as np
import pytest

from common.wire.packets import LinkState
from operator_site.console.examination.findings import UNCERTAIN_SD_K
from operator_site.console.model import Console
from operator_site.console.state.fingers_now import FIELDS, GONE_S
from operator_site.console.state.frame import Kind, Priority
from operator_site.console.state.signals import BINS
from operator_site.console.web.page_state import page_state
from operator_site.safety.limit_flags import Limit
from tests.unit.operator_site.console.fed import INDEX, S, fed, figures, happen, rendered, touch
from tests.unit.operator_site.console.page_messages import read_frame

AGE_S = FIELDS.index("age_s")


@pytest.fixture
def console() -> Console:
    """At work for two seconds, on the clock from 100 s to 102 s."""
    made = Console()
    happen(made, 99.99, "connected", "calibration 5f2c")
    happen(made, 99.99, "engaged")
    fed(made, 100.0, 102.0)
    made.step(102.0)
    return made


def shown(console: Console, now_s: float) -> dict[str, Any]:
    state = page_state(console, now_s, lambda _: True, "operator.toml")
    json.dumps(state, allow_nan=False)
    return state


def test_a_picture_has_what_was_fed(console: Console) -> None:
    picture = read_frame(console.picture(102.0, 9, None))
    assert (picture.kind, picture.sequence, len(picture.bins)) == (Kind.WHOLE, 9, BINS)
    assert picture.session == 7
    assert picture.flags.state is LinkState.ENGAGED
    assert picture.flags.contact == (False, True, False, False, False)
    assert picture.flags.in_use == (False, True, True, False, False)
    assert picture.flags.recording
    row = dict(zip(FIELDS, picture.fingers[INDEX].tolist(), strict=True))
    assert row["x_m"] == pytest.approx(0.01)
    assert row["y_m"] == pytest.approx(0.0, abs=1e-6)  # the index finger is 20 mm from the hand's middle
    assert (row["force_n"], row["contact_n"], row["motor_hz"], row["plate_c"]) == pytest.approx((1.0, 1.5, 100.0, 31.0))
    assert row["age_s"] == pytest.approx(0.01, abs=1e-5)
    assert np.nanmax(picture.bins[-20:, INDEX * 5 + 1]) == pytest.approx(1.5)


def test_pictures_in_a_row_hold_each_bin_once(console: Console) -> None:
    newest, numbers = None, []
    for step in range(1, 60):
        now_s = 102.0 + step / 30.0
        fed(console, now_s - 1 / 30, now_s)
        picture = read_frame(console.picture(now_s, step, newest))
        last = round(picture.time_s * 30.0) - 1
        numbers += range(last - len(picture.bins) + 1, last + 1)
        newest = console.signals.newest_bin(now_s)
        assert newest == last
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_what_is_too_old_is_not_shown(console: Console) -> None:
    late = read_frame(console.picture(102.0 + 0.5 * GONE_S, 1, None))
    assert late.fingers[INDEX, AGE_S] == pytest.approx(0.5 * GONE_S, abs=0.02)
    assert not np.isnan(late.fingers[INDEX, 0]), "it is shown with its age"
    gone = read_frame(console.picture(102.0 + 1.1 * GONE_S, 1, None))
    assert np.isnan(gone.fingers[:, :AGE_S]).all()
    assert not any(gone.flags.contact)
    state = shown(console, 102.0 + 1.1 * GONE_S)
    finger = state["fingers"][INDEX]
    assert finger["decision"] == "NO CONTACT"
    assert [finger[name] for name in ("object_c", "stiffness_n_m", "roughness_v", "contact_s")] == [None] * 4
    assert state["link"] == {"delay_ms": None, "delay_sd_ms": None, "age_ms": None, "loss": None}
    assert state["session"]["state"] == "silent"


def test_a_plate_without_a_reading_has_none(console: Console) -> None:
    console.take("operator/rendered", 102 * S, rendered(limited=int(Limit.PLATE_UNKNOWN)))
    row = read_frame(console.picture(102.0, 1, None)).fingers[INDEX]
    assert np.isnan(row[FIELDS.index("plate_c")])
    assert not np.isnan(row[FIELDS.index("force_n")])


def test_an_empty_console_shows_nothing_as_known() -> None:
    console = Console()
    console.step(5.0)
    picture = read_frame(console.picture(5.0, 1, None))
    assert picture.flags.state is LinkState.DISCONNECTED
    assert np.isnan(picture.fingers).all()
    assert np.isnan(picture.bins).all()
    state = shown(console, 5.0)
    assert state["session"]["state"] == "disconnected"
    assert state["engage"]["refusal"]
    assert [check["name"] for check in state["checks"] if check["ready"]] == ["disk"]
    assert all(check["help"] for check in state["checks"] if not check["ready"])
    assert state["alarms"] == []


def test_the_check_list_has_what_the_remote_site_refuses_and_calls_it_no_key(console: Console) -> None:
    assert "remote site" not in [check["name"] for check in shown(console, 102.0)["checks"]]
    slow = "the link is too slow: a round trip of 400 ms, packets may be 150 ms old (link.max_age_s on both sites)"
    console.take("operator/figures", 102 * S, figures(refusal=slow))
    (check,) = [check for check in shown(console, 102.0)["checks"] if check["text"] == slow.capitalize()]
    assert (check["name"], check["ready"]) == ("remote site", False)
    assert check["help"] == "teletaction doctor --config operator.toml"


def test_the_calibration_is_shown_and_without_one_the_check_fails(console: Console) -> None:
    def calibration(state: dict[str, Any]) -> tuple[object, object]:
        return state["meaning"], next(check["ready"] for check in state["checks"] if check["name"] == "calibration")

    assert calibration(shown(console, 102.0)) == (None, False)
    said = "Calibrated 2026-11-03 (sensor TX-0007), 480 touches, effusivity ± 3 %"
    console.take("operator/figures", 102 * S, figures(calibrated=said))
    assert calibration(shown(console, 102.0)) == (said, True)
    console.take("operator/figures", 102 * S, figures(calibrated=said, session=0))
    assert calibration(shown(console, 102.0)) == (said, False), "who is connected next may be another"


def test_the_state_has_what_is_known_of_a_finger_and_the_link_with_its_error(console: Console) -> None:
    state = shown(console, 102.0)
    finger, link = state["fingers"][INDEX], state["link"]
    assert (link["delay_ms"], link["delay_sd_ms"], link["loss"]) == pytest.approx((20.0, 2.0, 0.0))
    assert (finger["decision"], finger["line"]) == ("IDENTIFIED", "PVC 91 %")
    assert finger["candidates"] == [["PVC", 0.91], ["acrylic", 0.05]]
    assert (finger["object_c"], finger["object_c_sd"], finger["object_c_uncertain"]) == (24.1, 0.3, False)
    assert (finger["roughness_v"], finger["groove_mm"], finger["groove_sd_mm"]) == (0.12, 4.0, 0.1)
    assert finger["stiffness_known"]
    assert finger["contact_s"] == pytest.approx(2.0)


def test_a_temperature_with_a_wide_error_is_uncertain(console: Console) -> None:
    for sequence, sd_k in ((10_210, 0.9), (10_211, 2.1)):
        console.take("operator/touch", 102 * S, touch(sequence, 102 * S, object_c_sd=sd_k))
        finger = shown(console, 102.0)["fingers"][INDEX]
        assert (finger["object_c_sd"], finger["object_c_uncertain"]) == (sd_k, sd_k > UNCERTAIN_SD_K)


def test_a_packet_that_never_came_counts_where_nothing_came_in_time(console: Console) -> None:
    console.take("operator/touch", 102 * S + S // 10, touch(10_210, 0))
    assert shown(console, 102.1)["link"]["loss"] == pytest.approx(10 / 211, abs=0.005)


@pytest.mark.parametrize("state", ["engaging", "lost"])
def test_a_site_that_is_engaged_alone_is_understood(console: Console, state: str) -> None:
    console.take("operator/figures", 102 * S, figures(state=state))
    assert (console.site.state, console.damaged) == (LinkState.ENGAGED, 0)


def test_damaged_messages_are_counted_and_harm_nothing(console: Console) -> None:
    for stream in ("operator/touch", "operator/rendered", "operator/skin", "operator/clock", "operator/session"):
        for payload in (b"", b"\xc1", msgpack.packb(7), msgpack.packb([]), msgpack.packb({"a": 1})):
            console.take(stream, 102 * S, payload)
    assert console.damaged >= 20
    assert shown(console, 102.0)["fingers"][INDEX]["line"] == "PVC 91 %"


def test_a_clock_that_is_set_back_shows_what_comes_then(console: Console) -> None:
    fed(console, 50.0, 51.0)
    console.step(51.0)
    picture = read_frame(console.picture(51.0, 1, console.signals.newest_bin(102.0)))
    assert picture.kind is Kind.WHOLE
    assert picture.time_s <= 51.0
    assert picture.fingers[INDEX, AGE_S] == pytest.approx(0.01, abs=1e-5)
    assert shown(console, 51.0)["link"]["age_ms"] == pytest.approx(10.0)
    assert console.alarms.priority is Priority.NONE


def test_limits_are_named_for_three_seconds_on_the_fingers_in_use(console: Console) -> None:
    console.take("operator/rendered", 102 * S, rendered(limited=int(Limit.FORCE_RANGE | Limit.PLATE_RATE)))
    assert read_frame(console.picture(102.0, 1, None)).flags.limited == (False, True, True, False, False)
    console.take("operator/rendered", 102 * S + S // 100, rendered())
    assert shown(console, 104.9)["fingers"][INDEX]["limits"] == ["force"]
    assert shown(console, 105.1)["fingers"][INDEX]["limits"] == []
    assert shown(console, 104.9)["fingers"][0]["limits"] == []


def test_a_limit_that_holds_nothing_back_is_not_shown(console: Console) -> None:
    def limited(limit: Limit) -> tuple[bool, ...]:
        console.take("operator/rendered", 102 * S, rendered(limited=int(limit)))
        return read_frame(console.picture(102.0, 1, None)).flags.limited

    assert limited(Limit.STIFFNESS | Limit.PASSIVITY) == (False,) * 5, "softer than it is needs no act"
    assert [console.fingers.softened(finger, 102.0) for finger in range(5)] == [False, True, False, False, False]
    assert not console.fingers.softened(1, 105.1)
    assert limited(Limit.STIFFNESS | Limit.RELEASED) == (False,) * 5
    assert limited(Limit.FORCE_RANGE) == (False, True, True, False, False)


def test_another_examination_has_a_map_of_its_own(console: Console) -> None:
    before = shown(console, 102.0)["map"]["number"]
    surface = console.tactile_map
    console.begin_map()
    assert console.tactile_map is not surface
    assert shown(console, 102.0)["map"]["number"] == before + 1


def test_devices_have_their_readable_names(console: Console) -> None:
    lost = {"index tacttip": {"missing": "opening"}, "middle tacttip": {"missing": ""}, "exoskeleton": {"missing": ""}}
    console.take("operator/figures", 102 * S, figures(devices=lost))
    console.step(102.0)
    state = shown(console, 102.0)
    devices = {device["name"]: device for device in state["devices"]}
    assert devices["middle"]["ready"]
    assert not devices["index"]["ready"]
    assert devices["index"]["help"] == "teletaction doctor --config operator.toml"
    assert devices["thumb"] == {"name": "thumb", "ready": True, "text": "not used", "help": ""}
    assert state["engage"]["refusal"] == "Cannot engage: Index module absent."
    assert state["alarms"][0]["text"] == "Index module lost. Index feels nothing."
    assert math.isfinite(state["alarms"][0]["since_s"])
    assert shown(console, 105.0)["alarms"][0]["age_s"] == 3.0, "whatever the origin of the examination's times is"

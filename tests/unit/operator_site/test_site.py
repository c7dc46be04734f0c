"""The operator site's tick with devices and link in the test's hands."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from common.config.file import to_toml
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.link.link import OperatorLink
from common.link.session_state import Refused
from common.recording.recorder import Recorder
from common.wire.messages import Event, EventKind, Touch
from common.wire.packets import LinkState
from operator_site.coupling.coupling import Places
from operator_site.devices.devices import OperatorDevices
from operator_site.session.local_control import answer_desk
from operator_site.session.session_client import SessionClient
from operator_site.site import OperatorSite, session_with
from operator_site.site_recording import SCHEMAS
from teletaction.replay.replay import replay
from tests.unit.operator_site.touches import INDEX, touch
from tests.unit.operator_site.virtual_touch import CONFIG, MS, Devices


class SilentLink:
    """Nobody on the other side."""

    def receive(self, stream: str) -> list[bytes]:
        return []

    def newest(self, stream: str) -> list[bytes]:
        return []

    def send(self, stream: str, packet: bytes) -> bool:
        return False

    def send_latest(self, stream: str, packet: bytes) -> None:
        raise AssertionError("no motion without a session")


def site(devices: Devices, recorder: Recorder | None = None) -> OperatorSite:
    client = session_with(cast(OperatorLink, SilentLink()), CONFIG)
    return OperatorSite(CONFIG, client, cast(OperatorDevices, devices), recorder)


def run(operator: OperatorSite, first: int, ticks: int) -> int:
    for tick in range(first, first + ticks):
        operator.tick(1_000 * MS + tick * 2 * MS)
    return first + ticks


def test_everything_is_neutral_without_a_peer() -> None:
    devices = Devices()
    run(site(devices), 0, 200)
    assert len(devices.written) == 200
    assert not any(devices.engaged)
    for output in devices.written:
        assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * len(FINGERS)


def test_a_person_cannot_engage_before_a_remote_site_is_connected() -> None:
    config = CONFIG.model_copy(update={"engage": False})
    client = session_with(cast(OperatorLink, SilentLink()), config)
    operator = OperatorSite(config, client, cast(OperatorDevices, Devices()))
    run(operator, 0, 5)
    with pytest.raises(Refused, match="no remote site is connected"):
        answer_desk(client, operator.attendance, operator.coupling, 0, "", "engage", {})
    assert not client.want_engaged
    client.session.connect(1)
    assert answer_desk(client, operator.attendance, operator.coupling, 0, "", "engage", {})["wanted"]


def test_a_module_that_cut_out_latches_a_fault_until_it_is_cleared() -> None:
    devices = Devices()
    operator = site(devices)
    session = operator.client.session
    now = run(operator, 0, 5)
    assert session.state is LinkState.DISCONNECTED
    devices.cut = [Fault(FaultCode.MODULE_CUT_OUT, "index")]
    now = run(operator, now, 2)
    assert session.state is LinkState.FAULT
    assert session.fault == Fault(FaultCode.MODULE_CUT_OUT, "index")
    session.clear()
    now = run(operator, now, 2)
    assert session.state is LinkState.FAULT, "the module still says so"
    devices.cut = []
    now = run(operator, now, 2)
    assert session.state is LinkState.FAULT, "a fault latches"
    session.clear()
    run(operator, now, 2)
    assert session.state is LinkState.DISCONNECTED
    assert operator.rendering.fault is None
    figures: dict[str, Any] = operator.figures()
    assert figures["fault"] is None
    assert figures["limited"]["index"] == ("released", "plate_test"), "a second fault within ten minutes"


@dataclass(slots=True)
class ScriptedClient(SessionClient):
    """A session whose touch packets the test writes; nothing goes to a link."""

    def step(self, now_ns: int, not_ready: str, *_: object) -> None:
        pass

    def accept(self, touch: Touch, now_ns: int) -> None:
        self.touch, self.touch_packet = touch, touch.encode()
        self.acceptance.last_ns = now_ns

    def send_motion(self, now_ns: int, x_m: float, y_m: float, z_m: object) -> None:
        return None


def pressed(sequence: int, rng: np.random.Generator) -> Touch:
    """The index finger strokes and taps something that is never quite the same."""
    known = {"mode": 3, "contact": 1, "conductivity_w_mk": 200, "density_kg_m3": 2700, "specific_heat_j_kgk": 900}
    estimated = {"stiffness_n_m": 300, "k_tap": 4000, "k_stroke_v": 5000, "k_stroke_f": 50, "object_c": 22}
    never_the_same = {name: value * rng.uniform(0.9, 1.0) for name, value in estimated.items()}
    events = (Event(n, EventKind.TAP, INDEX, n, 0, 0.2) for n in range(sequence // 50, sequence // 50 + 3))
    return touch(*events, sequence=sequence, **known, **never_the_same)


def test_a_replay_of_a_new_recording_is_identical_to_the_last_bit(tmp_path: Path) -> None:
    """A session with strokes, a gap, a fault that is cleared, and a second session."""
    rng = np.random.default_rng(5)
    devices = Devices()
    with Recorder(tmp_path / "operator.mcap", SCHEMAS, {"configuration": to_toml(CONFIG)}) as recorder:
        operator = site(devices, recorder)
        client = ScriptedClient(cast(OperatorLink, SilentLink()), {}, 0.15, True)
        operator.client = client
        for tick in range(2000):
            now_ns = 1_000 * MS + tick * 2 * MS
            if tick in (100, 1200):
                client.session.connect(tick)
                client.session.engage()
                client.touch = None
            if tick == 700:
                devices.cut = [Fault(FaultCode.MODULE_CUT_OUT, "index")]
            if tick == 900:
                devices.cut = []
                client.session.clear()
                client.session.engage()
            if tick > 110 and not 400 < tick < 500 and tick % 3:
                client.accept(pressed(tick, rng), now_ns)
            hand = devices.hand
            height_m = -0.004 * math.sin(2.0 * math.pi * tick / 250)
            hand.place = Places(1e-4 * tick + 1e-6 * float(rng.normal()), 0.0, (height_m,) * len(FINGERS))
            operator.tick(now_ns)
    assert recorder.lost == 0
    result = replay(tmp_path / "operator.mcap", tmp_path / "out")
    assert result["remote"] == {}
    assert result["operator"]["operator"] == {
        "ticks": 2000,
        "rendered_rows": 2000,
        "identical": 2000,
        "first_difference": None,
        "missing_touch_packets": 0,
    }
    assert max(output.force_n[INDEX] for output in devices.written) > 1.0
    assert len({output.motor_rpm[INDEX] for output in devices.written}) > 100
    assert any(output.fault for output in devices.written)
    assert (tmp_path / "out" / "rendering.csv").read_text("utf-8").count("\n") == 2001

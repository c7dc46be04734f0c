"""Pain is recorded on each change, and only with consent."""

import math
from pathlib import Path

import pytest

from common.tenderness.patient_row import Patient
from remote_site.site_recording import SiteRecording
from tests.virtual.session import virtual_session


class Written:
    """Keeps what is recorded."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, Patient]] = []

    def write(self, topic: str, now_ns: int, payload: bytes) -> None:
        assert topic == "remote/patient"
        self.rows.append((now_ns, Patient.unpack(payload)))


def test_each_change_is_recorded_once_with_its_time() -> None:
    written = Written()
    recording = SiteRecording(written)  # type: ignore[arg-type]
    for now_ns, pain, limit_n in ((1, None, None), (2, 0.0, None), (3, 0.0, None), (4, 6.0, 1.5), (5, math.nan, 1.5)):
        recording.patient(now_ns, pain, limit_n)
    assert written.rows == [(2, Patient(0.0, None)), (4, Patient(6.0, 1.5)), (5, Patient(None, 1.5))]


@pytest.mark.parametrize("consent", [False, True])
def test_pain_is_recorded_only_with_consent(consent: bool, tmp_path: Path) -> None:
    with virtual_session(patient_switch=True) as session:
        written = Written()
        session.remote._recording = SiteRecording(written)  # type: ignore[arg-type]
        session.remote._recording.tick = lambda *_: None  # type: ignore[method-assign]
        session.remote._recording.session = lambda *_: None  # type: ignore[method-assign]
        session.remote._pain_recorded = consent
        assert session.sim_remote.patient_switch is not None
        session.sim_remote.patient_switch.pain = 0.3
        session.run_coarsely(2.0)
        assert bool(written.rows) == consent

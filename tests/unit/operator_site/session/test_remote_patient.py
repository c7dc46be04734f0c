"""The report of a remote site about its patient is read, or refused."""

import math

import pytest

from common.tenderness.pain_report import PainReport
from common.wire.packets import BadPacket
from operator_site.session.remote_status import RemotePatient, remote_patient


def test_a_site_without_a_slider_says_nothing():
    assert remote_patient({"recording": ""}) is None


def test_pain_limit_and_reports_are_read():
    details = {"pain": 4.2, "patient_limit_n": 2.1, "pain_reports": [0.1, 0.2, 2.6, 7.0]}
    assert remote_patient(details) == RemotePatient(4.2, 2.1, (PainReport(0.1, 0.2, 2.6, 7.0),))
    assert remote_patient({"pain": 4.2, "pain_agreed": True}) == RemotePatient(4.2, None, (), agreed=True)
    assert remote_patient({"pain": None}) == RemotePatient(None, None, ())


@pytest.mark.parametrize(
    "details",
    [
        {"pain": "4"},
        {"pain": True},
        {"pain": 10.5},
        {"pain": -0.1},
        {"pain": math.nan},
        {"pain": 1.0, "patient_limit_n": -1.0},
        {"pain": 1.0, "patient_limit_n": "2"},
        {"pain": 1.0, "pain_reports": [1.0, 2.0, 3.0]},
        {"pain": 1.0, "pain_reports": [None, 2.0, 3.0, 4.0]},
        {"pain": 1.0, "pain_reports": 3},
        {"pain": 1.0, "pain_reports": [1.0] * 84},
    ],
)
def test_what_fits_no_range_is_refused(details):
    with pytest.raises(BadPacket):
        remote_patient(details)

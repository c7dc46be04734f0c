"""A report of pain lowers the gate's force limit; a person ends it."""

import math

import pytest

from common.limits import APPROACH_DOWN_M_S, CONTACT_FORCE_N, PAIN_SHARE
from remote_site.safety.limit_flags import Limit
from tests.unit.remote_site.safety.test_patient_gate import DT, Rig, one


class Pressed(Rig):
    """A gate whose second finger presses on an elastic object, and a patient with a reaction time of 0.6 s."""

    def press(self, seconds, pain_from_s=math.inf, stiffness_n_m=1000.0, pain_to_s=math.inf, wanted_m=-0.0045):
        peak_n, flags, begun_s = 0.0, 0, self.t_s
        while self.t_s - begun_s < seconds:
            t_s = self.t_s - begun_s
            force_n = max(0.0, -self.z_m[1] * stiffness_n_m)
            answer = 5.0 if pain_from_s <= t_s < pain_to_s else 0.0
            out = self.step(wanted_z_m=one(wanted_m, 0.006), force_n=one(force_n, 0.0), pain=answer)
            peak_n, flags = max(peak_n, force_n), flags | out.limited[1]
        return peak_n, flags, force_n


def painful():
    """A gate after a report of pain that began at about 2 N."""
    rig = Pressed().met()
    rig.press(0.9)
    rig.press(0.4, pain_from_s=0.0, wanted_m=0.006)
    rig.press(1.0, pain_from_s=0.0, pain_to_s=0.6, wanted_m=0.006)
    return rig


def test_without_a_slider_and_without_pain_the_default_limit_holds():
    assert Pressed().met().gate.patient_limit_n is None
    rig = Pressed().met()
    peak_n, _, _ = rig.press(3.0)
    assert rig.gate.patient_limit_n is None
    assert peak_n > 4.0


def test_pain_lowers_the_limit_at_once_and_the_finger_rises():
    rig = Pressed().met()
    _, _, before_n = rig.press(2.0)
    _, flags, after_n = rig.press(1.0, pain_from_s=0.0)
    limit_n = rig.gate.patient_limit_n
    assert limit_n <= PAIN_SHARE * before_n
    assert after_n <= limit_n + 1e-9
    assert flags & Limit.FORCE


def test_later_presses_stay_within_the_limit_and_other_fingers_too():
    rig = painful()
    limit_n = rig.gate.patient_limit_n
    assert limit_n is not None
    peak_n, _, _ = rig.press(4.0)
    assert peak_n <= limit_n
    assert rig.gate.patient_limit_n == limit_n


def test_only_an_act_returns_to_the_default():
    rig = painful()
    rig.gate.clear_fault()
    rig.step(engaged=False, pain=0.0)
    assert rig.gate.patient_limit_n is not None
    rig.gate.end_pain_limit()
    assert rig.gate.patient_limit_n is None
    peak_n, _, _ = rig.press(4.0)
    assert 4.0 < peak_n <= CONTACT_FORCE_N


def test_a_finger_that_presses_is_lowered_slowly_once_the_limit_ends():
    rig = painful()
    _, _, before_n = rig.press(2.0)
    rig.gate.end_pain_limit()
    _, _, soon_n = rig.press(0.05)
    assert before_n < soon_n <= before_n + 1000.0 * APPROACH_DOWN_M_S * 0.05 + 1e-9
    _, _, later_n = rig.press(1.0)
    assert later_n > 4.0


@pytest.mark.parametrize("before_n", [0.5, 2.0, 4.9])
@pytest.mark.parametrize("default_n", [1.0, CONTACT_FORCE_N])
def test_a_limit_from_before_a_restart_holds_until_a_person_ends_it(before_n, default_n):
    rig = Pressed(contact_force_n=default_n).met()
    rig.gate.continue_pain_limit(before_n)
    assert rig.gate.patient_limit_n == (before_n if before_n < default_n else None)
    peak_n, _, _ = rig.press(4.0)
    assert peak_n <= min(before_n, default_n)
    rig.press(2.0, pain_from_s=0.5)
    assert rig.gate.pain_limit.limit_n < before_n or before_n == 0.5
    rig.gate.end_pain_limit()
    assert rig.gate.patient_limit_n is None


def test_a_lower_default_is_never_raised():
    rig = Pressed(contact_force_n=0.5).met()
    for _ in range(round(2.0 / DT)):
        rig.step(wanted_z_m=one(-0.0045, 0.006), force_n=one(0.45, 0.0), pain=5.0)
    assert rig.gate.patient_limit_n is None, "the patient's limit of 0.5 N is no lower"


def test_unknown_pain_and_unknown_forces_change_nothing():
    rig = Pressed().met()
    rig.press(2.0)
    rig.step(pain=math.nan, force_n=one(2.0, 0.0))
    rig.step(pain=5.0, force_age_s=math.inf)
    assert rig.gate.patient_limit_n is None


@pytest.mark.parametrize("pain", [0.0, 10.0, math.nan])
def test_pain_is_no_fault(pain):
    rig = Pressed().met()
    out = rig.step(pain=pain, force_n=one(2.0, 0.0))
    assert out.fault is None

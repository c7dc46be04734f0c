"""The patient-side gate keeps its limits for any request."""

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.faults.fault import AXES, TELEMANIPULATOR, Fault, FaultCode
from common.faults.texts import fault_text
from common.fingers import FINGERS
from common.limits import (
    APPROACH_DOWN_M_S,
    APPROACH_PLANE_M_S,
    CONTACT_FORCE_N,
    DOSE_ABOVE_C,
    DOSE_LIMIT_K_S,
    GAP_S,
    LEFT_J,
    LEFT_W,
    SENSOR_PLATE_C,
    SWING_CYCLES,
    SWING_N,
    SWING_S,
)
from common.safety.repeated_fault import REPEATED_S, ROUND_S, TEST_EVERY_S, WINDOW_S
from common.timing.timeouts import TICK_AGE_S
from remote_site.safety.following_error import HEIGHT_MARGIN_M, PERSIST_S, PLANE_MARGIN_M, STOPPING_S
from remote_site.safety.heater_limits import SENSOR_HIGH_C, TEST_DRIVE
from remote_site.safety.limit_flags import Limit, limit_names
from remote_site.safety.patient_gate import PatientGate
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M
from remote_site.safety.setpoints import (
    BRAKE_SHARE,
    CLEAR_HEIGHT_M,
    HEIGHT_HIGH_M,
    HEIGHT_LOW_M,
    HEIGHT_SPEED_M_S,
    PLANE_RANGE_M,
    PLANE_SPEED_M_S,
    RETREAT_M_S,
    ROUNDING_M,
    STOP_S,
    TOUCHING_N,
    WIDEN_M_S2,
)
from remote_site.safety.sliding_extrema import MEMORY_S

FAILED, FAILED_OTHERWISE = Fault(FaultCode.SENSOR_CUT_OUT, "index"), Fault(FaultCode.HEATER_UNASKED, "index")
DT = 0.002
NOT_FINITE = (math.nan, math.inf, -math.inf)


def dense(*edges: float, step: float) -> list[float]:
    return sorted({round(edge + k * step, 9) for edge in edges for k in range(-4, 5)})


def one(value, other, finger=1):
    return [value if i == finger else other for i in range(5)]


class Rig:
    """A gate with a clock and a telemanipulator that is where its set-points are."""

    def __init__(self, z_m: float = 0.006, **settings) -> None:
        self.gate = PatientGate(**settings)
        self.t_s = 5.0
        self.x_m, self.y_m, self.z_m = 0.0, 0.0, [z_m] * 5

    def step(self, engaged=True, age=0.0, dt=DT, **changes):
        self.t_s += dt
        request = {
            "wanted_x_m": self.x_m,
            "wanted_y_m": self.y_m,
            "wanted_z_m": list(self.z_m),
            "measured_x_m": self.x_m,
            "measured_y_m": self.y_m,
            "measured_z_m": list(self.z_m),
            "force_n": 0.0,
            "force_age_s": 0.0,
            "heater_drive": 0.0,
            "sensor_c": 33.0,
            "ambient_c": 23.0,
            "sensor_age_s": 0.01,
            "in_contact": False,
        } | changes
        heights, plates = ("wanted_z_m", "measured_z_m"), ("heater_drive", "sensor_c", "ambient_c", "sensor_age_s")
        for name in (*heights, "force_n", *plates, "in_contact"):
            if not isinstance(request[name], list):
                request[name] = [request[name]] * 5
        out = self.gate.step(self.t_s, engaged, age, **request)
        if out.ready:
            self.x_m, self.y_m, self.z_m = out.x_m, out.y_m, list(out.z_m)
        return out

    def run(self, ticks, **changes):
        for _ in range(ticks):
            out = self.step(**changes)
        return out

    def met(self):
        """A hand that has met the operator's, and follows at full speed."""
        self.run(100)
        return self


def test_refuses_a_force_limit_above_the_table():
    for limit in (0.0, -1.0, CONTACT_FORCE_N + 0.01, math.nan):
        with pytest.raises(ValueError, match=rf"^contact_force_n must be above 0 and at most 5\.0 N, not {limit}$"):
            PatientGate(limit)


@pytest.mark.parametrize("name", ["measured_z_m", "force_n"])
@pytest.mark.parametrize("fingers", [4, 6])
def test_refuses_another_number_of_fingers(name, fingers):
    with pytest.raises(ValueError, match="zip"):
        Rig().step(**{name: [0.0] * fingers})


def test_nothing_is_ready_before_the_telemanipulator_was_measured():
    rig = Rig()
    out = rig.step(force_age_s=math.inf, measured_x_m=math.nan, wanted_x_m=0.1)
    assert not out.ready
    assert out.fault is None
    assert out.released
    assert out.limited == [Limit.RELEASED | Limit.FORCE_UNKNOWN | Limit.HEATER_CONTACT] * 5
    out = rig.step(measured_x_m=0.3, measured_y_m=-9.0, measured_z_m=[-1.0, 1.0, 0.0, 0.001, 0.002], engaged=False)
    assert out.ready
    assert (out.x_m, out.y_m) == (0.3, -PLANE_RANGE_M)
    assert out.z_m == [HEIGHT_LOW_M, HEIGHT_HIGH_M, 0.0, 0.001, 0.002]


@pytest.mark.parametrize("axis", ["x", "y"])
def test_plane_range_and_speed(axis):
    for goal in (*dense(-PLANE_RANGE_M, PLANE_RANGE_M, step=0.001), 7.0):
        rig = Rig()
        rig.x_m = rig.y_m = math.copysign(PLANE_RANGE_M - 0.003, goal)
        before = rig.x_m
        for _ in range(30):
            out = rig.step(**{f"wanted_{axis}_m": goal})
            now = out.x_m if axis == "x" else out.y_m
            inside = min(PLANE_RANGE_M, max(-PLANE_RANGE_M, goal))
            assert abs(now - before) <= PLANE_SPEED_M_S * DT + 1e-12
            assert bool(out.limited[3] & Limit.PLANE_RANGE) == (goal != inside)
            assert bool(out.limited[3] & Limit.PLANE_SPEED) == (abs(now - inside) > 1e-9)
            before = now
        assert now == pytest.approx(inside)


def test_height_range_and_speed():
    for goal in (*dense(HEIGHT_LOW_M, HEIGHT_HIGH_M, step=0.0001), -1.0, 1.0):
        rig = Rig(z_m=math.copysign(0.009, goal))
        before = rig.z_m[0]
        for _ in range(30):
            out = rig.step(wanted_z_m=goal)
            now = out.z_m[0]
            inside = min(HEIGHT_HIGH_M, max(HEIGHT_LOW_M, goal))
            assert abs(now - before) <= HEIGHT_SPEED_M_S * DT + 1e-12
            assert bool(out.limited[0] & Limit.HEIGHT_RANGE) == (goal != inside)
            assert bool(out.limited[0] & Limit.HEIGHT_SPEED) == (abs(now - inside) > 1e-9)
            before = now
        assert now == pytest.approx(inside)


def test_a_stalled_loop_does_not_jump():
    rig = Rig().met()
    out = rig.step(dt=0.06, wanted_x_m=0.5, wanted_z_m=-0.01)
    assert out.x_m == pytest.approx(PLANE_SPEED_M_S * LONGEST_TICK_S)
    assert out.z_m[0] == pytest.approx(0.006 - HEIGHT_SPEED_M_S * LONGEST_TICK_S)


@pytest.mark.parametrize("limit", [CONTACT_FORCE_N, 1.0])
def test_force_decides_how_fast_a_finger_goes_deeper(limit):
    lowered = []
    forces = dense(0.0, limit * BRAKE_SHARE, limit, step=0.01)
    for force in forces:
        rig = Rig(z_m=0.0, contact_force_n=limit).met()
        out = rig.step(wanted_z_m=-0.004, force_n=force)
        lowered.append(-out.z_m[0] / DT)
        if force > limit:
            assert out.z_m[0] > 0.0
        elif force >= limit * BRAKE_SHARE:
            assert out.z_m[0] == 0.0
        else:
            assert -HEIGHT_SPEED_M_S * DT - 1e-12 <= out.z_m[0] < 0.0
        assert bool(out.limited[0] & Limit.FORCE) == (lowered[-1] < HEIGHT_SPEED_M_S - 1e-9)
        assert rig.step(wanted_z_m=0.004, force_n=force).z_m[0] > out.z_m[0]  # up is always allowed
    assert lowered == sorted(lowered, reverse=True)


def test_set_point_does_not_run_ahead_of_a_blocked_finger():
    rig = Rig(z_m=0.0)
    rig.step()
    out = rig.run(100, wanted_z_m=HEIGHT_LOW_M, measured_z_m=0.0)
    assert out.z_m[0] == pytest.approx(-CONTACT_FORCE_N / SERVO_N_M)
    assert out.fault is None
    assert "force" in limit_names(out.limited[0])
    lifted = rig.step(wanted_z_m=HEIGHT_LOW_M, measured_z_m=0.004)  # pushed up: the set-point follows, not at once
    assert lifted.z_m[0] == pytest.approx(out.z_m[0] + HEIGHT_SPEED_M_S * DT)


@pytest.mark.parametrize("stiffness", [600.0, 6000.0])
def test_contact_force_stays_below_the_limit_on_an_object(stiffness):
    """A servo of 1000 N/m presses on a spring; the force is known 10 ms late."""
    rig = Rig(z_m=0.003)
    z_m, forces = 0.003, [0.0] * 6
    for _ in range(1500):
        out = rig.step(wanted_z_m=HEIGHT_LOW_M, measured_z_m=z_m, force_n=forces[-6])
        goal = (SERVO_N_M * out.z_m[0]) / (SERVO_N_M + stiffness) if out.z_m[0] < 0.0 else out.z_m[0]
        z_m += (goal - z_m) * DT / 0.01
        forces.append(max(0.0, -stiffness * z_m))
    assert max(forces) <= CONTACT_FORCE_N
    assert forces[-1] > 0.7 * CONTACT_FORCE_N


def test_a_gap_stops_then_retreats_until_clear_then_continues():
    rig = Rig(z_m=-0.002)
    rig.step()
    start = list(rig.z_m)
    for age in dense(GAP_S, step=0.0005):
        probe = Rig(z_m=-0.002)
        probe.step()
        out = probe.step(age=age, wanted_x_m=0.01)
        assert (out.x_m > 0.0) == (age <= GAP_S)
    stopped_s = 0.0
    heights = []
    while stopped_s < 1.0:
        stopped_s += DT
        out = rig.step(age=GAP_S + stopped_s, wanted_x_m=0.1, wanted_z_m=-0.01)
        assert out.x_m == 0.0
        assert out.released
        assert out.limited[0] & Limit.RELEASED
        heights.append(out.z_m[0])
        if stopped_s < STOP_S - DT:
            assert out.z_m == start
    rises = [b - a for a, b in itertools.pairwise(heights)]
    assert all(-1e-12 <= rise <= RETREAT_M_S * DT + 1e-12 for rise in rises)
    assert heights[-1] == CLEAR_HEIGHT_M
    out = rig.step(wanted_x_m=0.1, wanted_z_m=0.0)
    assert not out.released
    assert out.x_m == pytest.approx(APPROACH_PLANE_M_S * DT)
    assert out.z_m == [CLEAR_HEIGHT_M] * 5  # not lowered before the hand is where it should be
    assert out.limited[0] & Limit.APPROACH


def test_stopped_finger_that_presses_too_hard_leaves_at_once():
    rig = Rig(z_m=-0.002)
    rig.step()
    out = rig.step(engaged=False, force_n=one(CONTACT_FORCE_N + 0.01, CONTACT_FORCE_N))
    assert out.z_m == pytest.approx(one(-0.002 + RETREAT_M_S * DT, -0.002))


def test_unknown_force_stops_and_retreats():
    for age in [*dense(0.0, GAP_S, step=0.0005), math.inf, math.nan]:
        rig = Rig(z_m=-0.002)
        rig.step()
        known = 0.0 <= age <= GAP_S
        out = rig.step(wanted_x_m=0.1, wanted_z_m=0.0, force_age_s=age, heater_drive=0.5)
        assert (out.z_m[0] > -0.002) == known, age
        assert (out.x_m > 0.0) == known  # nor is the hand drawn over what it may press on
        assert out.released != known
        assert bool(out.limited[0] & Limit.FORCE_UNKNOWN) != known
        assert out.heater_drive[0] == (0.5 if known else 0.0)
        assert out.fault is None
    out = rig.run(600, wanted_z_m=-0.01, force_age_s=1.0)
    assert out.z_m == [CLEAR_HEIGHT_M] * 5
    assert rig.step(wanted_z_m=-0.01).z_m[0] < CLEAR_HEIGHT_M


@pytest.mark.parametrize("value", NOT_FINITE)
@pytest.mark.parametrize(
    "name",
    [
        "wanted_x_m",
        "wanted_y_m",
        "wanted_z_m",
        "measured_x_m",
        "measured_y_m",
        "measured_z_m",
        "force_n",
        "heater_drive",
    ],
)
def test_nan_or_infinity_is_a_fault(name, value):
    rig = Rig(z_m=-0.002)
    rig.step()
    out = rig.step(**{"heater_drive": 0.5} | {name: one(value, 0.0) if name[-1] != "m" or "z" in name else value})
    assert out.fault
    assert out.heater_drive == [0.0] * 5
    assert all(map(math.isfinite, [out.x_m, out.y_m, *out.z_m]))
    out = rig.run(600, wanted_z_m=-0.002)
    assert out.z_m == [CLEAR_HEIGHT_M] * 5  # latched: it retreats although all is well again
    rig.gate.clear_fault()
    assert rig.gate.fault is None
    assert rig.step(wanted_z_m=-0.002).z_m[0] < CLEAR_HEIGHT_M


@pytest.mark.parametrize("value", NOT_FINITE)
def test_a_time_of_nan_is_a_fault(value):
    rig = Rig()
    rig.step()
    rig.t_s = value
    out = rig.step(wanted_x_m=0.1, heater_drive=1.0)
    assert "time" in str(out.fault)
    assert out.x_m == 0.0
    assert out.heater_drive == [0.0] * 5


def test_the_gate_begins_stopped_and_in_the_middle():
    rig = Rig(z_m=-0.002)
    out = rig.step(force_age_s=math.inf)
    assert (out.ready, out.x_m, out.y_m, out.z_m) == (False, 0.0, 0.0, [CLEAR_HEIGHT_M] * 5)
    out = rig.step(engaged=False)
    assert (out.ready, out.released, out.fault) == (True, True, None)
    assert rig.run(round(STOP_S / DT) - 2, engaged=False).z_m == [-0.002] * 5
    assert rig.run(2, engaged=False).z_m[0] > -0.002


@pytest.mark.parametrize("stood_s", [TICK_AGE_S, math.nextafter(TICK_AGE_S, 1.0)])
def test_a_standstill_is_longer_than_the_oldest_tick(stood_s):
    rig = Rig()
    rig.t_s = -DT
    rig.step()
    out = rig.step(dt=stood_s, measured_x_m=0.01, wanted_x_m=0.0)
    assert (out.x_m > 0.0) == (stood_s > TICK_AGE_S)


def test_a_set_point_that_misses_by_rounding_only_is_not_limited():
    for missed_m in (ROUNDING_M, -ROUNDING_M, 2.0 * ROUNDING_M):
        for axis in "xy":
            rig = Rig()
            rig.step()
            out = rig.step(dt=0.0, **{f"wanted_{axis}_m": missed_m})
            assert out.limited == [Limit.PLANE_SPEED if missed_m > ROUNDING_M else 0] * 5


def test_each_limit_that_acts_is_named():
    drive, touching = one(2.0, -2.0), one(True, False)
    out = Rig().step(wanted_x_m=-9.0, wanted_z_m=one(-1.0, 0.006), heater_drive=drive, in_contact=touching)
    plane = Limit.PLANE_RANGE | Limit.PLANE_SPEED | Limit.APPROACH
    finger = Limit.HEIGHT_RANGE | Limit.HEIGHT_SPEED | Limit.HEATER_CONTACT
    assert out.limited == one(plane | finger, plane | Limit.HEATER_RANGE)
    out = Rig().step(age=1.0, sensor_age_s=one(1.0, 0.0), force_age_s=1.0)
    stopped = Limit.RELEASED | Limit.FORCE_UNKNOWN | Limit.HEATER_CONTACT
    assert out.limited == one(stopped | Limit.SENSOR_UNKNOWN, stopped)


def hot(plate_c: float) -> Fault:
    return Fault(FaultCode.SENSOR_PLATE_TOO_HOT, "index", value=plate_c, limit=SENSOR_PLATE_C)


def test_faults_have_codes_and_numbers():
    for changes, fault in (
        ({"wanted_z_m": math.nan}, Fault(FaultCode.MOTION_NOT_FINITE)),
        ({"measured_y_m": math.nan}, Fault(FaultCode.MEASUREMENT_NOT_FINITE, device=TELEMANIPULATOR)),
        ({"sensor_c": one(42.06, 33.0)}, hot(42.06)),
        ({"dt": math.nan}, Fault(FaultCode.TIME_NOT_FINITE)),
    ):
        rig = Rig()
        rig.step()
        assert rig.step(**changes).fault == fault
    for reading_c in (SENSOR_HIGH_C, math.nextafter(SENSOR_HIGH_C, 99.0)):
        assert (Rig().step(sensor_c=reading_c).fault is not None) == (reading_c == SENSOR_HIGH_C)


def test_a_time_of_nan_moves_nothing():
    rig = Rig(z_m=-0.002)
    rig.step()
    rig.t_s = math.nan
    out = rig.step(wanted_x_m=0.1)
    assert (out.x_m, out.z_m) == (0.0, [-0.002] * 5)


def test_first_fault_is_kept():
    rig = Rig()
    rig.gate.trip(FAILED)
    rig.gate.trip(FAILED_OTHERWISE)
    assert rig.step().fault == FAILED


def test_hot_sensor_plate_is_a_fault():
    for reading in dense(SENSOR_PLATE_C, step=0.01):
        rig = Rig()
        out = rig.step(sensor_c=one(reading, 33.0), heater_drive=-1.0)
        assert (out.fault is not None) == (reading > SENSOR_PLATE_C)
        if out.fault:
            assert out.fault == hot(reading)
            assert out.heater_drive == [0.0] * 5


def test_a_hot_reading_that_is_old_is_no_new_fault():
    rig = Rig()
    for age_s, hot_now in ((GAP_S, True), (GAP_S + 0.001, False), (math.inf, False)):
        out = rig.step(sensor_c=one(43.0, 33.0), sensor_age_s=one(age_s, 0.01))
        assert (out.fault is not None) == hot_now
        assert out.heater_drive[1] == 0.0
        rig.gate.clear_fault()


def test_heater_is_off_on_contact():
    for force in dense(0.0, TOUCHING_N, step=0.005):
        out = Rig().step(force_n=force, heater_drive=0.5)
        touching = force > TOUCHING_N
        assert out.heater_drive == [0.0 if touching else 0.5] * 5
        assert bool(out.limited[0] & Limit.HEATER_CONTACT) == touching
    out = Rig().step(in_contact=one(True, False), heater_drive=0.5)
    assert out.heater_drive == one(0.0, 0.5)


def test_heater_needs_engagement_motion_and_a_believable_reading():
    assert Rig().step(engaged=False, heater_drive=0.5).heater_drive == [0.0] * 5
    assert Rig().step(age=GAP_S + 0.001, heater_drive=0.5).heater_drive == [0.0] * 5
    for reading in (math.nan, -5.1, 60.1, math.inf):
        out = Rig().step(sensor_c=one(reading, 33.0), heater_drive=0.5)
        assert out.heater_drive == one(0.0, 0.5)
        assert out.limited[1] & Limit.SENSOR_UNKNOWN
        assert out.fault is None
    for age in [*dense(0.0, GAP_S, step=0.001), math.inf, math.nan]:
        known = 0.0 <= age <= GAP_S
        assert Rig().step(sensor_age_s=age, heater_drive=0.5).heater_drive == [0.5 if known else 0.0] * 5


def test_heater_drive_range():
    for wanted in dense(-1.0, 0.0, 1.0, step=0.01):
        out = Rig().step(heater_drive=wanted)
        assert out.heater_drive == [min(1.0, max(-1.0, wanted))] * 5
        assert bool(out.limited[0] & Limit.HEATER_RANGE) == (abs(wanted) > 1.0)


def test_reading_that_does_not_answer_the_heater_switches_it_off():
    rig = Rig()
    driven_s = 0.0
    while rig.step(heater_drive=1.0).heater_drive[0] > 0.0:
        driven_s += DT
        assert driven_s < 1.0  # 5 K of heating at most
    rig.gate.clear_fault()
    for _ in range(5000):
        out = rig.step(heater_drive=1.0, sensor_c=30.0)
        assert out.limited[0] & Limit.HEATER_TEST
        assert abs(out.heater_drive[0]) in (0.0, TEST_DRIVE)


@pytest.mark.parametrize("read_c", [(41.5, 34.0), (34.0, 41.5)], ids=["before", "after"])
@pytest.mark.parametrize("unseen", ["standstill", "no reading"])
def test_dose_counts_a_gap_at_the_hotter_of_its_two_ends(unseen, read_c):
    before_c, after_c = read_c
    for gap_s, spent in ((5.0, False), (13.5, True), (30.0, True)):
        rig = Rig()
        rig.run(100, sensor_c=before_c)
        if unseen == "no reading":
            rig.run(round(gap_s / 0.05), dt=0.05, sensor_c=before_c, sensor_age_s=1.0)
        rig.step(dt=gap_s if unseen == "standstill" else DT, sensor_c=after_c)
        out = rig.step(sensor_c=after_c)
        assert bool(out.limited[0] & Limit.DOSE) == spent


@pytest.mark.parametrize("value", NOT_FINITE)
@pytest.mark.parametrize("without_time", [0, 100], ids=["first", "later"])
def test_a_tick_without_a_time_does_not_keep_the_dose_permanently(without_time, value):
    rig = Rig()
    spent = []
    for tick in range(1700):
        hot_c = 41.5 if tick < 300 else 33.0
        rig.t_s += 0.05
        with_time_s, rig.t_s = rig.t_s, value if tick == without_time else rig.t_s
        spent.append(bool(rig.step(dt=0.0, sensor_c=hot_c).limited[0] & Limit.DOSE))
        rig.t_s = with_time_s
        rig.gate.clear_fault()
    assert (spent[299], spent[-1]) == (True, False)


class Heater:
    """A sensor's plate that warms by 5 K/s at full drive, and its reading 0.3 s behind."""

    def __init__(self, rig: Rig, works: float) -> None:
        self.rig, self.works = rig, works
        self.plate_c = self.reading_c = 33.0
        self.out = rig.step()
        self.work_s = 0.0

    def run(self, seconds: float, *, wanted: float = 0.4, **changes) -> None:
        for _ in range(round(seconds / DT)):
            self.out = self.rig.step(**{"heater_drive": wanted, "sensor_c": self.reading_c, **changes})
            drive = self.out.heater_drive[1]
            self.work_s += abs(drive) * DT
            self.plate_c += DT * (5.0 * self.works * drive - 0.05 * (self.plate_c - 33.0))
            self.reading_c += (self.plate_c - self.reading_c) * DT / 0.3


def named_twice(rig: Rig) -> None:
    """Two faults of the index finger's sensor, each cleared."""
    for _ in range(2):
        rig.gate.trip(FAILED)
        rig.gate.trip(FAILED_OTHERWISE)
        rig.step()
        rig.gate.clear_fault()


def test_a_second_fault_of_the_same_sensor_keeps_its_heater_off():
    rig = Rig()
    for again in (False, True):
        fault = rig.step(sensor_c=one(43.0, 33.0)).fault
        assert fault == hot(43.0)._replace(needs_test=again)
        rig.step(sensor_c=one(44.0, 33.0))  # until a person clears it is the same fault
        rig.gate.trip(Fault(FaultCode.SENSOR_CUT_OUT if again else FaultCode.ENCODER_STUCK, "little"))
        assert rig.gate.fault == fault
        rig.gate.clear_fault()
        assert rig.gate.fault is None
        out = rig.step(heater_drive=0.5)
        assert out.limited == one(Limit.HEATER_TEST if again else 0, 0)
        assert out.heater_drive == one(0.0 if again else 0.5, 0.5)


FIRST_PULSE_S = ROUND_S + WINDOW_S
"""A round without drive comes before."""


@pytest.mark.parametrize(
    "blocked",
    [
        {"in_contact": True},
        {"sensor_age_s": GAP_S + 0.01},
        {"sensor_c": math.nan},
        {"sensor_c": SENSOR_PLATE_C - 0.01},
        {"age": GAP_S + 0.01},
        {"dt": TICK_AGE_S + 0.01},
    ],
    ids=str,
)
@pytest.mark.parametrize("after_s", [0.3, 1.0])
def test_a_test_restarts_after_a_moment_without_drive(blocked, after_s):
    rig = Rig()
    reading = {"sensor_c": SENSOR_PLATE_C - 0.1, "heater_drive": 1.0}
    rig.step(**reading)
    named_twice(rig)
    rig.run(round(after_s / DT), **reading)
    assert rig.step(**reading | blocked).limited[1] & Limit.HEATER_TEST
    ticks = next(tick for tick in range(2000) if rig.step(**reading).heater_drive[1])
    assert ticks * DT == pytest.approx(FIRST_PULSE_S, abs=3.0 * DT)


def test_no_test_pulse_while_the_dose_is_spent():
    rig = Rig()
    named_twice(rig)
    rig.step(sensor_c=41.5)
    rig.step(sensor_c=41.5, dt=13.5)
    spent = Limit.HEATER_TEST | Limit.DOSE
    assert next(tick * 0.02 for tick in range(4000) if rig.step(dt=0.02).limited[1] != spent) > 30.0
    ticks = next(tick for tick in range(200) if rig.step(dt=0.02).heater_drive[1])
    assert ticks * 0.02 == pytest.approx(FIRST_PULSE_S, abs=0.05)


def test_a_sensor_that_faults_name_twice_in_ten_minutes_is_heated_again_once_a_test_pulse_moved_it():
    rig = Rig()
    named_twice(rig)
    heater = Heater(rig, 1.0)
    assert [bool(bits & Limit.HEATER_TEST) for bits in heater.out.limited] == one(True, False)
    heater.run(6.0)
    assert not heater.out.limited[1] & Limit.HEATER_TEST
    assert heater.out.heater_drive[1] == 0.4


@pytest.mark.parametrize("works", [0.0, -1.0], ids=["dead", "reversed"])
def test_a_heater_that_does_not_pass_its_test_gets_no_more_than_a_pulse_in_half_a_minute(works):
    rig = Rig()
    for again in (False, True):
        for finger in FINGERS:
            rig.gate.trip(Fault(FaultCode.SENSOR_CUT_OUT, finger))
        rig.step()
        assert rig.gate.fault.needs_test == again
        rig.gate.clear_fault()
    heater = Heater(rig, works)
    heater.run(TEST_EVERY_S + 5.0)
    assert heater.out.limited == [Limit.HEATER_TEST] * 5
    assert heater.work_s == pytest.approx(2 * 2 * 0.5 * TEST_DRIVE, rel=0.02)
    heater.works = 1.0
    heater.run(TEST_EVERY_S + 2.0)
    assert heater.out.heater_drive == [0.4] * 5


def test_no_test_pulse_in_contact_nor_across_a_standstill():
    rig = Rig()
    named_twice(rig)
    heater = Heater(rig, 1.0)
    heater.run(10.0, in_contact=True)
    for _ in range(20):
        heater.run(0.5)
        heater.run(DT, dt=0.2)
    assert heater.work_s == 0.0
    assert heater.out.limited[1] & Limit.HEATER_TEST


def test_a_fresh_reading_that_is_implausible_again_is_a_repeated_fault():
    rig = Rig()
    for times in range(2):
        rig.run(3, sensor_c=math.nan)
        out = rig.step(heater_drive=0.5)
        assert out.heater_drive == [0.0 if times else 0.5] * 5
    rig = Rig()
    for _ in range(3):
        rig.step(sensor_c=math.nan, sensor_age_s=GAP_S + 0.01)
        assert rig.step(heater_drive=0.5).heater_drive == [0.5] * 5
    rig = Rig()
    for _ in range(2):
        rig.step(sensor_c=math.nan)
        rig.step()
        rig.t_s += REPEATED_S
        rig.step()
    assert rig.step(heater_drive=0.5).heater_drive == [0.5] * 5


def test_a_plate_that_holds_or_warms_is_plausible():
    rig = Rig()
    for tick in range(1500):
        assert rig.step(heater_drive=1.0, sensor_c=23.0 + 4.0 * tick * DT).heater_drive[0] == 1.0
    for _ in range(5000):
        assert rig.step(heater_drive=0.1, sensor_c=35.0).heater_drive[0] == 0.1


def test_heater_looks_ahead_of_its_sensor():
    rig = Rig()
    for tick in range(3000):
        reading = 33.0 + 5.0 * tick * DT
        if rig.step(heater_drive=1.0, sensor_c=reading).limited[0] & Limit.SENSOR_TEMPERATURE:
            break
    assert SENSOR_PLATE_C - 3.0 < reading < SENSOR_PLATE_C - 2.0


def test_dose_is_spent_before_it_is_exceeded_and_comes_back():
    rig, dose = Rig(), 0.0
    for tick in range(20_000):
        reading = 41.5 + 0.05 * (tick // 500 % 2)
        if rig.step(sensor_c=reading, heater_drive=0.1).limited[0] & Limit.DOSE:
            break
        dose += (reading - DOSE_ABOVE_C) * DT
    assert 0.7 * DOSE_LIMIT_K_S < dose < DOSE_LIMIT_K_S - 2.0 * 1.4
    rig.run(400, dt=0.1, sensor_c=30.0)
    assert rig.step(heater_drive=0.1, sensor_c=30.0).heater_drive[0] == 0.0
    rig.run(300, dt=0.1, sensor_c=30.0)
    assert rig.step(heater_drive=0.1, sensor_c=30.0).heater_drive[0] == 0.1


def test_set_points_begin_at_the_hand_after_each_release():
    rig = Rig(z_m=-0.002)
    rig.step()
    rig.step(age=1.0)
    swung = {"measured_x_m": 0.003, "measured_y_m": -9.0, "measured_z_m": [-0.003, 0.02, 0.0, 0.001, 0.002]}
    out = rig.step(wanted_x_m=1.0, wanted_y_m=-1.0, wanted_z_m=1.0, **swung)
    assert out.x_m == pytest.approx(0.003 + APPROACH_PLANE_M_S * DT)
    assert out.y_m == -PLANE_RANGE_M
    rise = HEIGHT_SPEED_M_S * DT
    assert out.z_m == pytest.approx([-0.003 + rise, HEIGHT_HIGH_M, rise, 0.001 + rise, 0.002 + rise])


def test_set_points_begin_at_the_hand_after_a_standstill():
    """The telemanipulator has stopped by itself meanwhile, and may have raised its fingers."""
    for stood_s in (TICK_AGE_S - 0.001, TICK_AGE_S + 0.001, 1.0):
        rig = Rig(z_m=-0.002).met()
        out = rig.step(dt=stood_s, measured_x_m=0.01, measured_z_m=0.002, wanted_x_m=1.0, wanted_z_m=-0.002)
        begin_x_m, speed_m_s, begin_z_m = 0.0, PLANE_SPEED_M_S, -0.002
        if stood_s > TICK_AGE_S:
            begin_x_m, speed_m_s, begin_z_m = 0.01, APPROACH_PLANE_M_S, 0.002
        assert out.x_m == pytest.approx(begin_x_m + speed_m_s * LONGEST_TICK_S)
        assert out.z_m[0] == begin_z_m


def test_a_standstill_while_a_plate_is_heated_demands_no_test():
    """The sensor turns its heater off by itself meanwhile, so its reading owes no answer to this time."""
    for stood_s in (0.5, 1.0, 1.4):
        rig = Rig()
        rig.run(100, heater_drive=1.0, sensor_c=33.0)
        assert not rig.step(dt=stood_s, heater_drive=1.0, sensor_c=33.0).limited[0] & Limit.HEATER_TEST
        assert rig.step(heater_drive=1.0, sensor_c=33.0).heater_drive == [1.0] * 5


def come_back(rig: Rig, ticks: int, **wanted) -> list:
    """Engaged after a release, with a hand that went elsewhere meanwhile."""
    rig.met()
    rig.run(30, engaged=False)
    return [rig.step(**wanted) for _ in range(ticks)]


def test_a_hand_that_moved_meanwhile_is_approached_without_a_jump():
    rig = Rig()
    places = [(0.0, 0.0, 0.006)]
    outs = come_back(rig, 1000, wanted_x_m=0.08, wanted_y_m=-0.03, wanted_z_m=-0.002)
    for out in outs:
        places.append((out.x_m, out.y_m, out.z_m[1]))
        (x_m, y_m, z_m), (old_x_m, old_y_m, old_z_m) = places[-1], places[-2]
        assert max(abs(x_m - old_x_m), abs(y_m - old_y_m)) <= APPROACH_PLANE_M_S * DT + 1e-12
        assert 0.0 <= old_z_m - z_m <= APPROACH_DOWN_M_S * DT + 1e-12
        assert z_m == 0.006 or (x_m, y_m) == pytest.approx((0.08, -0.03))  # lowered only where it is meant
        there = z_m == pytest.approx(-0.002)
        assert bool(out.limited[1] & Limit.APPROACH) != there
    assert places[-1] == pytest.approx((0.08, -0.03, -0.002))
    took_s = next(tick for tick, place in enumerate(places) if place == pytest.approx(places[-1])) * DT
    assert took_s == pytest.approx(math.hypot(0.08, 0.03) / APPROACH_PLANE_M_S + 0.008 / APPROACH_DOWN_M_S, abs=4 * DT)
    assert "approach" in limit_names(outs[0].limited[0])


def test_a_hand_that_moved_aslant_is_approached_no_faster_and_straight():
    rig = Rig()
    before = (0.0, 0.0)
    for out in come_back(rig, 400, wanted_x_m=0.06, wanted_y_m=-0.03):
        assert math.dist(before, (out.x_m, out.y_m)) <= APPROACH_PLANE_M_S * DT + 1e-12
        assert out.y_m == pytest.approx(-0.5 * out.x_m)
        before = (out.x_m, out.y_m)
    assert before == pytest.approx((0.06, -0.03))


def test_a_finger_that_agreed_before_the_hand_had_come_is_lowered_slowly():
    """Under the hand is another place then, and the operator has lowered the finger since."""
    rig = Rig()
    come_back(rig, 100, wanted_x_m=0.08, wanted_z_m=0.006)
    heights, arrived = [0.006], False
    for _ in range(1000):
        out = rig.step(wanted_x_m=0.08, wanted_z_m=-0.002)
        heights.append(out.z_m[1])
        assert heights[-2] - heights[-1] <= APPROACH_DOWN_M_S * DT + 1e-12
        arrived = arrived or out.x_m == pytest.approx(0.08)
        assert arrived or heights[-1] == 0.006
    assert heights[-1] == pytest.approx(-0.002)


def test_once_met_the_hand_is_followed_ever_faster_and_without_a_jerk():
    rig = Rig()
    come_back(rig, 1, wanted_x_m=0.08)
    assert any(not rig.step(wanted_x_m=0.08).limited[0] & Limit.APPROACH for _ in range(1000))
    before, speeds = 0.08, []
    for _ in range(200):  # the hand runs off in the very moment
        out = rig.step(wanted_x_m=-0.5)
        assert not out.limited[0] & Limit.APPROACH
        speeds.append((before - out.x_m) / DT)
        before = out.x_m
    assert speeds[0] <= APPROACH_PLANE_M_S + WIDEN_M_S2 * DT + 1e-9
    assert all(after - now <= WIDEN_M_S2 * DT + 1e-9 for now, after in itertools.pairwise(speeds))
    assert speeds[-1] == pytest.approx(PLANE_SPEED_M_S)


def test_a_finger_is_raised_at_once_while_the_hand_still_comes():
    rig = Rig(z_m=0.001)
    rig.met()
    rig.step(engaged=False)
    out = rig.step(wanted_x_m=0.08, wanted_z_m=0.006)
    assert out.z_m[0] == pytest.approx(0.001 + HEIGHT_SPEED_M_S * DT)


def lowered_on(rig: Rig, stiffness: float, face_m: float = 0.002) -> tuple[float, float, float]:
    """Lowered as deep as it goes: largest force, fastest rise of it, and force in the end; it is known 10 ms late."""
    servo_m = z_m = rig.z_m[0]
    forces = [0.0] * 6
    for _ in range(3000):
        out = rig.step(wanted_z_m=-0.01, measured_z_m=z_m, force_n=forces[-6])
        assert out.fault is None
        servo_m += (out.z_m[0] - servo_m) * DT / 0.01
        z_m = servo_m if servo_m > face_m else (SERVO_N_M * servo_m + stiffness * face_m) / (SERVO_N_M + stiffness)
        forces.append(max(0.0, stiffness * (face_m - z_m)))
    rises = [(after - before) / DT for before, after in itertools.pairwise(forces)]
    return max(forces), max(rises), forces[-1]


@pytest.mark.parametrize("stiffness", [600.0, 6000.0])
def test_contact_in_the_approach_is_soft_and_stays_below_the_limit(stiffness):
    """What has risen meanwhile is met at the approach speed, by a servo of 1000 N/m."""
    rig = Rig()
    come_back(rig, 1, wanted_z_m=-0.01)
    most_n, rise_n_s, end_n = lowered_on(rig, stiffness)
    assert most_n <= CONTACT_FORCE_N
    assert rise_n_s <= SERVO_N_M * APPROACH_DOWN_M_S
    assert rise_n_s < 0.3 * lowered_on(Rig().met(), stiffness)[1]
    assert end_n > 0.7 * CONTACT_FORCE_N


def test_stale_motion_stops_and_raises_the_fingers_and_a_new_approach_follows():
    rig = Rig(z_m=-0.001).met()
    for tick in range(round((STOP_S + 0.1) / DT)):
        out = rig.step(age=GAP_S + tick * DT + 1e-6, wanted_x_m=0.05)
    assert (out.x_m, out.released) == (0.0, True)
    assert out.z_m[0] > -0.001
    out = rig.step(wanted_x_m=0.05, wanted_z_m=-0.001)
    assert out.x_m == pytest.approx(APPROACH_PLANE_M_S * DT)
    assert out.limited[0] & Limit.APPROACH


def pumped(rig: Rig, hz: float, low_n: float, high_n: float, seconds: float, *, lag: float, reach_m: float = 0.002):
    """A finger whose set-point is swung, on an object that loses `sin(lag)` of what is put in: outs, and forces."""
    middle_n, reach_n = 0.5 * (low_n + high_n), 0.5 * (high_n - low_n)
    forces, outs = [], []
    for tick in range(round(seconds / DT)):
        turn = 2.0 * math.pi * hz * tick * DT
        forces.append(middle_n + reach_n * math.sin(turn))
        place = -0.003 - reach_m * math.sin(turn - lag)
        outs.append(rig.step(wanted_z_m=place, measured_z_m=one(place, rig.z_m[0]), force_n=one(forces[-1], 0.0)))
    return outs, forces


def test_work_left_in_the_object_slows_the_finger_and_three_such_cycles_are_a_fault():
    rig = Rig(z_m=-0.003).met()
    outs, _ = pumped(rig, 8.0, 0.1, 4.3, 4.0, lag=1.5, reach_m=0.003)
    first = next(tick for tick, out in enumerate(outs) if out.limited[1] & Limit.ENERGY)
    assert not any(out.limited[0] & Limit.ENERGY for out in outs)
    left = math.pi * 0.003 * 2.1 * math.sin(1.5) * 8.0
    assert left > LEFT_W
    assert first * DT == pytest.approx(LEFT_J / (left - LEFT_W), rel=0.5)
    fault = next(tick for tick, out in enumerate(outs) if out.fault)
    assert fault_text(outs[fault].fault) == "index: force swings at 8 Hz by 4.2 N"
    assert 2.0 / 8.0 <= (fault - first) * DT <= 4.5 / 8.0
    assert outs[fault].released
    out = rig.run(600, wanted_z_m=-0.003)
    assert out.z_m == one(HEIGHT_HIGH_M, CLEAR_HEIGHT_M)  # latched: it has retreated, further where a force is left
    assert rig.gate.left_mj[0] == 0.0 < rig.gate.left_mj[1]
    rig.gate.clear_fault()
    assert rig.step().fault is None


def test_residual_work_restarts_after_missing_reports():
    rig = Rig(z_m=0.0).met()
    for z_m in (0.0, -0.002):
        rig.step(measured_z_m=one(z_m, 0.0), force_n=one(4.0, 0.0))
    assert rig.gate.left_mj == pytest.approx(one(8.0 - 1e3 * LEFT_W * DT, 0.0))
    rig.step(measured_z_m=one(-0.002, 0.0), force_n=one(4.0, 0.0), force_age_s=GAP_S + 0.01)
    assert rig.gate.left_mj == [0.0] * 5


@pytest.mark.parametrize("hz", [14.0, 25.0, 60.0])
def test_a_force_that_swings_faster_than_a_hand_is_a_fault_in_half_a_second(hz):
    rig = Rig(z_m=-0.003).met()
    outs, _ = pumped(rig, hz, 1.0, 1.2 + SWING_N, 1.0, lag=0.0)
    fault = next(tick for tick, out in enumerate(outs) if out.fault)
    assert fault_text(outs[fault].fault) == f"index: force swings at {hz:.0f} Hz by 0.6 N"
    assert fault * DT <= SWING_S + 2.0 / hz
    rig.gate.clear_fault()
    for _ in range(100):
        assert rig.step().fault is None


def test_a_force_from_before_it_followed_is_no_part_of_a_swing():
    rig, hz = Rig(z_m=-0.003), 14.0
    for tick in range(round(8.0 / hz / DT)):
        swings_n = 1.3 + 0.3 * math.sin(2.0 * math.pi * (hz * tick * DT - 0.35))  # the first peak after 0.6 cycles
        if rig.step(force_n=one(swings_n if tick else 2.5, 0.0)).fault:
            break
    assert tick * DT == pytest.approx((0.6 + SWING_CYCLES + 0.3) / hz, abs=0.01)


def test_a_force_that_swings_around_releases_is_no_fault():
    """Each gap in the packets stops the fingers: what the force did before one is no part of what it does after."""
    rig, live_s = Rig(z_m=-0.003).met(), 4.0 / 14.0
    for _ in range(5):
        outs, _ = pumped(rig, 14.0, 1.0, 1.2 + SWING_N, live_s, lag=0.0)
        assert outs[-1].fault is None
        assert rig.step(age=2.0 * GAP_S, measured_z_m=-0.003, force_n=one(1.8, 0.0)).fault is None
    assert pumped(rig, 14.0, 1.0, 1.2 + SWING_N, 2.0 * live_s, lag=0.0)[0][-1].fault


def test_tapping_and_pressing_in_rhythm_is_neither_limited_nor_a_fault():
    for hz, low_n, high_n in ((8.0, 0.0, 4.4), (5.0, 1.0, 4.4), (2.0, 0.0, 4.4)):
        outs, _ = pumped(Rig(z_m=-0.003).met(), hz, low_n, high_n, 4.0, lag=0.25)
        assert not any(out.limited[1] & Limit.ENERGY for out in outs)
        assert outs[-1].fault is None


def test_a_rhythm_after_the_limit_on_energy_has_acted_is_no_fault():
    outs, _ = pumped(Rig(z_m=-0.003).met(), 8.0, 0.1, 4.3, 1.0, lag=1.5, reach_m=0.003)
    until_it_acts = next(tick for tick, out in enumerate(outs, start=1) if out.limited[1] & Limit.ENERGY)
    rig = Rig(z_m=-0.003).met()
    outs, _ = pumped(rig, 8.0, 0.1, 4.3, until_it_acts * DT, lag=1.5, reach_m=0.003)
    assert outs[-1].limited[1] & Limit.ENERGY
    rig.run(500)
    outs, _ = pumped(rig, 5.0, 0.5, 1.5, 2.0, lag=0.25)
    assert not any(out.limited[1] & (Limit.ENERGY | Limit.FORCE) for out in outs)
    assert outs[-1].fault is None


DISOBEYED_S = MEMORY_S + PERSIST_S


def until_fault(rig: Rig, limit_s: float, **changes) -> tuple[float, str]:
    """Seconds until the gate finds that the telemanipulator does not obey, and which part of it."""
    for tick in range(round(limit_s / DT)):
        asked = {name: value(tick * DT) if callable(value) else value for name, value in changes.items()}
        out = rig.step(**asked)
        if out.fault is not None:
            assert out.released
            assert rig.step().fault == out.fault  # latched
            fault = out.fault
            assert (fault.code, fault.device) == (FaultCode.SET_POINT_MISSED, TELEMANIPULATOR)
            assert fault.value > fault.limit == (PLANE_MARGIN_M if fault.where in AXES else HEIGHT_MARGIN_M) * 1e3
            return tick * DT, fault.where
    return math.inf, ""


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("speed", [0.05, -0.3])
def test_a_hand_that_does_not_follow_is_a_fault(axis, speed):
    rig = Rig()
    stands = {f"wanted_{axis}_m": lambda t_s: speed * t_s, f"measured_{axis}_m": 0.0}
    took_s, why = until_fault(rig, 2.0, **stands)
    expected_s = DISOBEYED_S + PLANE_MARGIN_M / abs(speed)
    assert took_s == pytest.approx(expected_s, abs=0.02)
    assert why == f"hand's {axis}"


@pytest.mark.parametrize("drift_m_s", [0.02, -0.02, 0.3])
def test_motion_without_a_command_is_a_fault_live_and_released(drift_m_s):
    for engaged in (True, False):
        rig = Rig()
        rig.run(200, engaged=engaged)
        took_s, why = until_fault(
            rig, 2.0, engaged=engaged, wanted_x_m=0.0, measured_x_m=lambda t_s: drift_m_s * t_s, measured_y_m=0.0
        )
        assert took_s == pytest.approx(PLANE_MARGIN_M / abs(drift_m_s) + PERSIST_S, abs=0.02)
        assert why == "hand's x"


def test_a_hand_that_moves_after_its_release_is_a_fault_once_it_had_time_to_stop():
    rig = Rig()
    took_s, why = until_fault(rig, 2.0, engaged=False, measured_x_m=lambda t_s: 0.05 * t_s)
    assert took_s == pytest.approx(STOPPING_S + PLANE_MARGIN_M / 0.05 + PERSIST_S, abs=0.02)
    assert why == "hand's x"


def test_a_finger_that_does_not_rise_or_not_sink_is_a_fault():
    down = {"wanted_z_m": -0.003, "measured_z_m": 0.006}
    took_s, why = until_fault(Rig().met(), 1.0, force_n=one(0.0, 4.9), **down)
    assert took_s == pytest.approx(DISOBEYED_S + 0.05, abs=0.05)
    assert why == "index"
    up = {"wanted_z_m": 0.006, "measured_z_m": one(-0.003, 0.006, 4), "force_n": 1.0}
    took_s, why = until_fault(Rig(z_m=-0.003), 1.0, **up)
    assert took_s == pytest.approx(DISOBEYED_S + 0.03, abs=0.03)
    assert why == "little"


def test_a_released_finger_must_not_sink_and_must_retreat():
    for speed, name in ((-0.02, "sinks"), (0.0, "stays")):
        rig = Rig(z_m=-0.002)
        held = lambda t_s, speed=speed: one(-0.002 + speed * t_s, 0.006, 0)  # noqa: E731
        took_s, why = until_fault(rig, 2.0, engaged=False, measured_z_m=held, force_n=0.5)
        assert took_s < 1.0, name
        assert why == "thumb"


def test_a_finger_that_an_object_holds_back_is_no_fault():
    for force in (0.5, 4.0):
        pressed = {"wanted_z_m": -force / SERVO_N_M - 0.9 * HEIGHT_MARGIN_M, "measured_z_m": 0.0}
        assert until_fault(Rig(z_m=0.0), 2.0, force_n=force, **pressed) == (math.inf, "")
    assert until_fault(Rig(z_m=0.0), 2.0, force_n=0.0, **pressed)[0] < 1.0  # what holds it back is no object


def test_a_released_finger_may_sink_with_the_object_by_the_deflection_of_its_servo():
    rig = Rig(z_m=0.0)
    for tick in range(100 + round(STOPPING_S / DT) + 5):
        rig.step(engaged=tick < 100, wanted_z_m=-0.003, measured_z_m=0.0, force_n=3.0)
    took_s, _ = until_fault(rig, 0.3, engaged=False, measured_z_m=-0.003, force_n=0.0)
    assert took_s > MEMORY_S  # until it must have retreated


def test_a_released_finger_whose_force_sensor_reads_below_zero_is_no_fault():
    assert until_fault(Rig(), 1.0, engaged=False, force_n=-3.0) == (math.inf, "")


def test_single_wrong_lost_or_late_reports_are_no_fault():
    rig = Rig()
    late: list[float] = [0.0] * 40
    for tick in range(3000):
        wanted = 0.1 * math.sin(2.0 * tick * DT)
        if tick % 45 < 44:
            late.append(rig.x_m)  # every 45th report is lost, and each is 80 ms late
        wrong = 0.5 if tick % 60 < 40 and tick > 100 else 0.0
        out = rig.step(
            wanted_x_m=wanted, measured_x_m=late[-40], measured_z_m=one(rig.z_m[1] + wrong * 0.01, rig.z_m[0])
        )
        assert out.fault is None


def test_old_reports_do_not_count_towards_a_fault():
    rig = Rig()
    rig.step()
    for tick in range(3000):
        age_s = 0.0 if tick * DT < 0.8 * PERSIST_S else 0.03
        assert rig.step(wanted_x_m=0.1, measured_x_m=0.2, force_age_s=age_s).fault is None
    assert until_fault(rig, 1.0, wanted_x_m=0.1, measured_x_m=0.2)[0] < PERSIST_S


@pytest.mark.parametrize("engaged", [True, False])
def test_an_unreported_hand_may_stand_anywhere(engaged):
    rig = Rig()
    rig.run(200, engaged=engaged)
    rig.step(force_age_s=GAP_S + 0.01)
    elsewhere = {"wanted_x_m": 0.2, "measured_x_m": 0.2, "measured_z_m": 0.009}
    assert until_fault(rig, 1.0, engaged=False, **elsewhere) == (math.inf, "")
    assert rig.step(**elsewhere).x_m == 0.2


def test_fingers_without_a_sensor_take_no_part():
    parked = {"wanted_z_m": 0.0, "measured_z_m": one(0.0, 0.0102), "sensor_age_s": one(0.0, math.inf)}
    rig = Rig()
    rig.run(60, wanted_z_m=0.0)
    assert until_fault(rig, 1.0, **parked) == (math.inf, "")
    assert until_fault(rig, 1.0, **parked | {"sensor_age_s": 0.0})[0] < 1.0


def test_a_cleared_disobedience_is_found_again():
    rig = Rig()
    drifts = {"engaged": False, "measured_x_m": lambda t_s: 0.02 * t_s}
    assert until_fault(rig, 2.0, **drifts)[0] < 2.0
    rig.gate.clear_fault()
    assert rig.step(engaged=False).fault is None
    assert until_fault(rig, 2.0, **drifts)[0] < 2.0


numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.floats(-1.0, 1.0), st.sampled_from([42.0, 5.0, *NOT_FINITE])
)
ages = st.one_of(st.floats(0.0, 0.2), numbers)


def five(calm):
    return st.one_of(
        st.lists(calm, min_size=5, max_size=5),
        st.lists(calm, min_size=5, max_size=5),
        st.lists(numbers, min_size=5, max_size=5),
    )


def single(calm):
    return st.one_of(calm, calm, calm, numbers)


plane, height = st.floats(-0.7, 0.7), st.floats(-0.012, 0.012)
tick_inputs = st.fixed_dictionaries(
    {
        "engaged": st.booleans(),
        "age": ages,
        "dt": st.floats(0.0, 0.3),
        "wanted_x_m": single(plane),
        "wanted_y_m": single(plane),
        "wanted_z_m": five(height),
        "measured_x_m": single(plane),
        "measured_y_m": single(plane),
        "measured_z_m": five(height),
        "force_n": five(st.floats(0.0, 7.0)),
        "force_age_s": ages,
        "heater_drive": five(st.floats(-1.5, 1.5)),
        "sensor_c": five(st.floats(20.0, 41.9)),
        "sensor_age_s": st.lists(ages, min_size=5, max_size=5),
        "in_contact": st.lists(st.booleans(), min_size=5, max_size=5),
        "clear": st.booleans(),
    }
)


@settings(max_examples=150, deadline=None)
@given(st.lists(tick_inputs, min_size=1, max_size=20))
def test_every_output_of_every_sequence_keeps_the_limits(sequence):
    rig = Rig()
    before = None
    for tick in sequence:
        before_s = rig.t_s
        request = dict(tick)
        if request.pop("clear"):
            rig.gate.clear_fault()
        out = rig.step(**request)
        live = tick["engaged"] and 0.0 <= tick["age"] <= GAP_S and out.fault is None and out.ready
        force_known = 0.0 <= tick["force_age_s"] <= GAP_S
        live = live and force_known
        assert out.released != live
        if live and before is not None and (before.released or rig.t_s - before_s > TICK_AGE_S):
            x_m, y_m = (min(PLANE_RANGE_M, max(-PLANE_RANGE_M, tick[f"measured_{axis}_m"])) for axis in "xy")
            z_m = [min(HEIGHT_HIGH_M, max(HEIGHT_LOW_M, height)) for height in tick["measured_z_m"]]
            before = replace(before, x_m=x_m, y_m=y_m, z_m=z_m)
        assert max(abs(out.x_m), abs(out.y_m)) <= PLANE_RANGE_M
        for i in range(5):
            assert HEIGHT_LOW_M <= out.z_m[i] <= HEIGHT_HIGH_M
            assert -1.0 <= out.heater_drive[i] <= 1.0
            reading_ok = 0.0 <= tick["sensor_age_s"][i] <= GAP_S and tick["sensor_c"][i] <= SENSOR_PLATE_C
            may_heat = live and force_known and reading_ok and not tick["in_contact"][i]
            if not (may_heat and tick["force_n"][i] <= TOUCHING_N):
                assert out.heater_drive[i] == 0.0
            if before is not None and before.ready:
                rise = out.z_m[i] - before.z_m[i]
                reach = min(LONGEST_TICK_S, tick["dt"])
                if out.limited[i] & Limit.APPROACH and tick["force_n"][i] <= CONTACT_FORCE_N:
                    assert rise >= -APPROACH_DOWN_M_S * reach - 1e-9
                assert abs(rise) <= HEIGHT_SPEED_M_S * reach + 1e-9
                if not live:
                    assert -1e-12 <= rise <= RETREAT_M_S * reach + 1e-9
                elif tick["force_n"][i] >= BRAKE_SHARE * CONTACT_FORCE_N:
                    assert rise >= -1e-12
        if before is not None and before.ready:
            reach = PLANE_SPEED_M_S * min(LONGEST_TICK_S, tick["dt"]) if live else 0.0
            assert max(abs(out.x_m - before.x_m), abs(out.y_m - before.y_m)) <= reach + 1e-9
        before = out

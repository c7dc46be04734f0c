"""Limits all outputs before motor, Peltier element and finger force: the operator-side gate.

All outputs are within `common.limits`, for any request. Pure: numbers and a time in, numbers out. A fault latches and
takes all outputs of all fingers to neutral; only `clear_fault` ends it, and outputs then start from zero. Missing input
gives neutral outputs instead of the last values.
"""

import math
from collections.abc import Sequence

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.limits import (
    GAP_S,
    MODULE_TIMEOUT_S,
    MOTOR_FLOOR_RPM,
    MOTOR_MAX_RPM,
    PLATE_COOLING_K_S,
    PLATE_FAULT_C,
    PLATE_HEATING_K_S,
    WIDE,
    PlateRange,
)
from common.safety.repeated_fault import RepeatedFault
from common.safety.thermal_dose import ThermalDose
from common.timing.timeouts import TICK_AGE_S
from operator_site.safety.force_limits import ForceLimits
from operator_site.safety.gated_output import SKIN_NEUTRAL_C, GatedOutput, Outputs
from operator_site.safety.limit_flags import RATE_ROUNDING_K, Limit
from operator_site.safety.plate_following import CHECK_S, PlateFollowing
from operator_site.safety.sampled_wall import SampledWall

PLATE_MARGIN_K = PLATE_FAULT_C - WIDE.high_c
"""Distance outside of its profile from which a plate is only driven back, K."""
LOOK_AHEAD_S = 0.25
"""Time by which a plate's temperature is extrapolated, s; sensor and drive lag by this time."""
TEMPERATURE_AGE_S = GAP_S
"""Maximum age of a plate's reading, s."""
LONGEST_CHECK_S = 0.05
"""Longest time that one check of a plate counts for, s, after a pause of the loop."""
TEST_DRIVE = 0.2
"""Drive of the test pulse after repeated faults."""
TEST_LEAST_K = 0.3
"""Minimum change of a sound plate by the test pulse, K: half of the usual change."""
_EPSILON = 1e-9

_RELEASED, _FORCE_RANGE, _FORCE_RAMP, _PASSIVITY = (
    limit.value for limit in (Limit.RELEASED, Limit.FORCE_RANGE, Limit.FORCE_RAMP, Limit.PASSIVITY)
)


class OperatorGate:
    """State of the limits: ramps, doses, and the following of each plate."""

    def __init__(self, profile: PlateRange, wall: SampledWall) -> None:
        """Begin with neutral outputs.

        Args:
            profile: temperature range of the plates, within the wide one.
            wall: bound of the walls that the exoskeleton can display passively.

        Raises:
            ValueError: the profile reaches outside the wide one.
        """
        if not WIDE.low_c <= profile.low_c < profile.high_c <= WIDE.high_c:
            raise ValueError(f"plate profile {profile} must lie within {WIDE}")
        n = len(FINGERS)
        self._profile = profile
        self._t_s = math.nan
        self._fault: Fault | None = None
        self._wall = wall
        self._force = [ForceLimits(wall) for _ in range(n)]
        self._set_c = [SKIN_NEUTRAL_C] * n
        self._drive = [0.0] * n
        self._driven = [False] * n
        self._dose = [ThermalDose() for _ in range(n)]
        self._spent = [False] * n
        self._follow = [PlateFollowing() for _ in range(n)]
        self._repeated = [RepeatedFault(TEST_DRIVE, TEST_LEAST_K) for _ in range(n)]
        self._named: set[int] = set()
        self._checked_s = -math.inf

    @property
    def fault(self) -> Fault | None:
        """The latched fault, if any."""
        return self._fault

    @property
    def undriven(self) -> list[bool]:
        """Whether each plate gets no drive: its dose is spent, or after repeated faults it gets only a test pulse."""
        return [repeated.needs_test or spent for repeated, spent in zip(self._repeated, self._spent, strict=True)]

    @property
    def produced_mj(self) -> list[dict[str, float]]:
        """Energy that came out at each finger beyond what it put in, mJ: `now`, and the `most` in this session."""
        energies = (force.energy for force in self._force)
        return [{"now": 1e3 * energy.produced_j, "most": 1e3 * energy.most_produced_j} for energy in energies]

    def begin_session(self) -> None:
        """Forget the largest generated energy; faults and doses are kept."""
        for force in self._force:
            force.energy.most_produced_j = 0.0

    def show(self, wall: SampledWall) -> None:
        """Set the bound of the walls, which falls while the loop holds forces for longer."""
        if wall is not self._wall:
            self._wall = wall
            for force in self._force:
                force.show(wall)

    def trip(self, fault: Fault) -> None:
        """Latch a fault; the first one is kept.

        A second fault of the same plate or module within ten minutes requires a test. Until a person clears the fault,
        further faults of this plate count as the same one.
        """
        plate = fault.plate
        if plate is not None and plate not in self._named:
            self._named.add(plate)
            if self._repeated[plate].named(self._t_s):
                fault = fault._replace(needs_test=True)
        self._fault = self._fault or fault

    def clear_fault(self) -> None:
        """End a latched fault, by a deliberate act of a person; doses are kept."""
        self._fault = None
        self._named.clear()
        self._follow = [PlateFollowing() for _ in FINGERS]

    def step(
        self,
        t_s: float,
        engaged: bool,
        last_input_age_s: float,
        wanted: Outputs,
        *,
        plate_measured_c: Sequence[float],
        measurement_age_s: Sequence[float],
        z_m: Sequence[float],
        height_age_s: float,
    ) -> GatedOutput:
        """Pass requests for all five fingers through every limit.

        Args:
            t_s: time on a steady clock, s.
            engaged: whether both sites agree that outputs may act.
            last_input_age_s: age of the last accepted input from which the requests follow, s.
            wanted: requests of the renderer.
            plate_measured_c: last reading of each plate, C; NaN from a faulty sensor.
            measurement_age_s: age of each reading, s; infinite before the first.
            z_m: last measured height of each finger, m.
            height_age_s: age of the heights, s.
        """
        dt_s = self._elapsed(t_s)
        self._inspect(wanted, last_input_age_s)
        known = [0.0 <= age <= TEMPERATURE_AGE_S for age in measurement_age_s]
        if dt_s < math.inf:
            if dt_s > MODULE_TIMEOUT_S:  # the modules have turned their drives off by themselves
                self._follow = [PlateFollowing() for _ in FINGERS]
            self._watch_plates(t_s, known, plate_measured_c)
        self._watch_forces(t_s, z_m, height_age_s)
        if dt_s > TICK_AGE_S:
            self._begin_from_neutral()
            dt_s = 0.0  # no ramp has risen during the standstill
        fresh = 0.0 <= last_input_age_s <= GAP_S
        live = engaged and fresh and self._fault is None
        limited = list(wanted.limited) if live else [bits | _RELEASED for bits in wanted.limited]
        pushed_n = self._forces(t_s, dt_s, live, last_input_age_s, wanted.force_n, limited)
        turning_rpm = _motors(live, wanted.motor_rpm, limited)
        for finger in range(len(FINGERS)):
            measured_c = plate_measured_c[finger] if known[finger] else math.nan
            self._set_c[finger] = self._plate_set(finger, dt_s, live, wanted.plate_set_c[finger], measured_c, limited)
            self._drive[finger] = self._plate_drive(finger, live, wanted.peltier_drive[finger], measured_c, limited)
        return GatedOutput(Outputs(pushed_n, turning_rpm, list(self._set_c), list(self._drive), limited, self._fault))

    def _elapsed(self, t_s: float) -> float:
        if not math.isfinite(t_s):
            self.trip(Fault(FaultCode.TIME_NOT_FINITE))
            return math.inf  # all falling ramps have ended
        dt_s = max(0.0, t_s - self._t_s)  # 0 in the first step, because a comparison with NaN is false
        self._checked_s = min(self._checked_s, t_s)  # a clock that was set back must not delay the checks
        self._t_s = t_s
        return dt_s

    def _begin_from_neutral(self) -> None:
        """Begin from neutral after a standstill, because the devices have become safe by themselves."""
        for force in self._force:
            force.begin_from_neutral()
        for repeated in self._repeated:
            repeated.interrupt()
        self._driven = [False] * len(FINGERS)

    def _inspect(self, wanted: Outputs, age_s: float) -> None:
        """Latch a fault if a request is no number, because the renderer is broken then."""
        # A sum is not finite if one part is not; requests are far too small to overflow it.
        total = sum(wanted.force_n) + sum(wanted.motor_rpm) + sum(wanted.plate_set_c) + sum(wanted.peltier_drive)
        if not math.isfinite(total):
            self.trip(Fault(FaultCode.REQUEST_NOT_FINITE))
        if math.isnan(age_s):
            self.trip(Fault(FaultCode.AGE_NOT_A_NUMBER))

    def _watch_plates(self, t_s: float, known: list[bool], plate_measured_c: Sequence[float]) -> None:
        check = t_s - self._checked_s >= CHECK_S - _EPSILON
        since_s = min(LONGEST_CHECK_S, t_s - self._checked_s)
        for finger, plate_c in enumerate(plate_measured_c):
            if not known[finger]:
                if self._follow[finger].started:
                    self._follow[finger] = PlateFollowing()
                continue
            if not math.isfinite(plate_c):
                self.trip(Fault(FaultCode.PLATE_NOT_BELIEVED, FINGERS[finger]))
                continue
            if plate_c > PLATE_FAULT_C:
                self.trip(Fault(FaultCode.PLATE_TOO_HOT, FINGERS[finger], value=plate_c, limit=PLATE_FAULT_C))
            self._spent[finger] = self._dose[finger].step(t_s, plate_c)
            if check:
                wrong = self._follow[finger].step(since_s, self._drive[finger], plate_c)
                if wrong and not self._repeated[finger].needs_test:  # else the test decides
                    self.trip(Fault(wrong, FINGERS[finger]))
        if check:
            self._checked_s = t_s

    def _watch_forces(self, t_s: float, z_m: Sequence[float], age_s: float) -> None:
        measured_s, known = t_s - age_s, 0.0 <= age_s <= GAP_S
        for finger, force in enumerate(self._force):
            wrong = force.observe(t_s, measured_s, z_m[finger] if known else math.nan)
            if wrong:
                self.trip(wrong._replace(where=FINGERS[finger]))

    def _forces(
        self, t_s: float, dt_s: float, live: bool, age_s: float, wanted_n: Sequence[float], limited: list[int]
    ) -> list[float]:
        out = []
        for finger, force in enumerate(self._force):
            out.append(force.step(t_s, dt_s, live, age_s, wanted_n[finger]))
            if live and force.out_of_range:
                limited[finger] |= _FORCE_RANGE
            if force.overdrawn:
                limited[finger] |= _PASSIVITY
            if force.ramped:
                limited[finger] |= _FORCE_RAMP
        return out

    def _plate_set(
        self, finger: int, dt_s: float, live: bool, wanted_c: float, measured_c: float, limited: list[int]
    ) -> float:
        """Return the set-point, C, within profile and rates; it starts from the plate's own temperature."""
        low, high = self._profile.low_c, self._profile.high_c
        may_drive = live and not math.isnan(measured_c) and not self._repeated[finger].needs_test
        driven, self._driven[finger] = self._driven[finger], may_drive
        if driven and may_drive:
            base = self._set_c[finger]
        else:
            base = min(high, max(low, SKIN_NEUTRAL_C if math.isnan(measured_c) else measured_c))
            if not may_drive:
                return base
        target = wanted_c
        if not low <= wanted_c <= high:
            target = min(high, max(low, wanted_c))
            limited[finger] |= Limit.PLATE_RANGE.value
        change = min(PLATE_HEATING_K_S * dt_s, max(-PLATE_COOLING_K_S * dt_s, target - base))
        if abs(target - base - change) > RATE_ROUNDING_K:
            limited[finger] |= Limit.PLATE_RATE.value
        return base + change

    def _plate_drive(self, finger: int, live: bool, wanted: float, measured_c: float, limited: list[int]) -> float:
        if self._repeated[finger].needs_test:
            limited[finger] |= Limit.PLATE_TEST.value
            wanted = self._repeated[finger].step(self._t_s, measured_c, live and not self._spent[finger])
        if math.isnan(measured_c):
            limited[finger] |= Limit.PLATE_UNKNOWN.value
            return 0.0
        if not live:
            return 0.0
        if self._spent[finger]:
            limited[finger] |= Limit.DOSE.value
            return 0.0
        drive = wanted
        if not -1.0 <= wanted <= 1.0:
            drive = min(1.0, max(-1.0, wanted))
            limited[finger] |= Limit.DRIVE_RANGE.value
        if (
            measured_c + LOOK_AHEAD_S * self._follow[finger].rate_k_s > PLATE_FAULT_C
            or (drive > 0.0 and measured_c > self._profile.high_c + PLATE_MARGIN_K)
            or (drive < 0.0 and measured_c < self._profile.low_c - PLATE_MARGIN_K)
        ):
            limited[finger] |= Limit.PLATE_TEMPERATURE.value
            return 0.0
        return drive


def _motors(live: bool, motor_rpm: Sequence[float], limited: list[int]) -> list[float]:
    """Return the motor speeds, rpm: zero, or within the motor's range."""
    if not live:
        return [0.0] * len(motor_rpm)
    out = []
    for finger, rpm in enumerate(motor_rpm):
        allowed = min(MOTOR_MAX_RPM, rpm) if rpm >= MOTOR_FLOOR_RPM else 0.0
        if allowed != rpm:
            limited[finger] |= Limit.MOTOR_RANGE.value
        out.append(allowed)
    return out

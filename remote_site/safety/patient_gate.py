"""The patient-side gate: limits every command to the telemanipulator and the thermal sensors' heaters.

A warm plate and a robot touch a person here. For any input, set-points stay within range and speed, and a finger that
presses too hard rises. A report of pain lowers the force limit until `end_pain_limit`. A silent operator causes a stop,
then a retreat. The patient's own stop causes a retreat at once. No plate is heated on skin. A telemanipulator that does
not obey is a fault. Pure: numbers and a time in, numbers out. A fault latches; only `clear_fault` ends it.
"""

import math
from collections.abc import Sequence

from common.faults.fault import TELEMANIPULATOR, Fault, FaultCode, replaces
from common.fingers import FINGER_Y_M, FINGERS
from common.limits import CONTACT_FORCE_N, GAP_S, SENSOR_PLATE_C
from common.timing.timeouts import TICK_AGE_S
from remote_site.safety.following_error import FollowingError
from remote_site.safety.heater_limits import SENSOR_HIGH_C, HeaterLimits
from remote_site.safety.limit_flags import (
    DOSE,
    FORCE_UNKNOWN,
    HEATER_CONTACT,
    HEATER_RANGE,
    HEATER_TEST,
    RELEASED,
    SENSOR_TEMPERATURE,
    SENSOR_UNKNOWN,
)
from remote_site.safety.pain_limit import PainLimit
from remote_site.safety.patient_stop import SwitchReading, patient_stop
from remote_site.safety.servo import LONGEST_TICK_S
from remote_site.safety.setpoints import STOP_S, TOUCHING_N, GatedCommand, HeightSetpoint, PlaneSetpoint

_ALL = (True,) * len(FINGERS)


class PatientGate:
    """Keeps set-points, doses and the latched fault."""

    def __init__(self, contact_force_n: float = CONTACT_FORCE_N) -> None:
        """Use a force limit, at most CONTACT_FORCE_N.

        Raises:
            ValueError: the limit is not in 0..5 N.
        """
        if not 0.0 < contact_force_n <= CONTACT_FORCE_N:
            raise ValueError(f"contact_force_n must be above 0 and at most {CONTACT_FORCE_N} N, not {contact_force_n}")
        self._contact_force_n = self._force_limit_n = contact_force_n
        self.pain_limit = PainLimit()
        self._t_s = math.nan
        self._fault: Fault | None = None
        self._ready = False
        self._live = False
        self._follow = FollowingError()
        self._plane = PlaneSetpoint()
        self._fingers = [HeightSetpoint(contact_force_n) for _ in FINGERS]
        self._stopped_s = 0.0
        self._drive = [0.0] * len(FINGERS)
        self._heaters = [HeaterLimits() for _ in FINGERS]
        self._named: set[int] = set()

    @property
    def fault(self) -> Fault | None:
        """The latched fault; None without one."""
        return self._fault

    @property
    def left_mj(self) -> list[float]:
        """Work that each finger has left in the touched object beyond the permitted permanent power, mJ."""
        return [1e3 * finger.left.left_j for finger in self._fingers]

    @property
    def patient_limit_n(self) -> float | None:
        """Force limit that follows the patient's own threshold, N; None while the default limit holds."""
        return self._force_limit_n if self._force_limit_n < self._contact_force_n else None

    def continue_pain_limit(self, limit_n: float) -> None:
        """Continue with the force limit that followed the patient before a restart, N."""
        self.pain_limit.limit_n = limit_n
        self._limit_force(min(limit_n, self._contact_force_n))

    def end_pain_limit(self) -> None:
        """Return to the default force limit, by a deliberate act of a person who has asked the patient.

        The operator's fingers may be far below the remote ones, which approach them slowly.
        """
        self.pain_limit.end()
        self._limit_force(self._contact_force_n)
        for finger in self._fingers:
            finger.lower_slowly()

    def trip(self, fault: Fault) -> None:
        """Latch a fault; the first one is kept, but the patient's stop takes the place of any other.

        A second fault of the same thermal sensor within ten minutes makes a test necessary. Until a person clears,
        further faults of it count as the same one.
        """
        plate = fault.plate
        if plate is not None and plate not in self._named:
            self._named.add(plate)
            if self._heaters[plate].repeated.named(self._t_s):
                fault = fault._replace(needs_test=True)
        if self._fault is None or replaces(fault.code, self._fault.code):
            self._fault = fault

    def clear_fault(self) -> None:
        """End a latched fault, by a deliberate act of a person. Doses are kept."""
        self._fault = None
        self._follow = FollowingError()
        self._named.clear()

    def step(
        self,
        t_s: float,
        engaged: bool,
        motion_age_s: float,
        *,
        wanted_x_m: float,
        wanted_y_m: float,
        wanted_z_m: Sequence[float],
        measured_x_m: float,
        measured_y_m: float,
        measured_z_m: Sequence[float],
        force_n: Sequence[float],
        force_age_s: float,
        heater_drive: Sequence[float],
        sensor_c: Sequence[float],
        ambient_c: Sequence[float],
        sensor_age_s: Sequence[float],
        in_contact: Sequence[bool],
        patient_switch: SwitchReading | None = None,
        pain: float | None = None,
    ) -> GatedCommand:
        """Pass wanted motion and heat through every limit.

        Args:
            t_s: time on a steady clock, s.
            engaged: whether both sites agree that outputs may act.
            motion_age_s: time since the last accepted motion packet, s.
            wanted_x_m, wanted_y_m, wanted_z_m: place of the operator's hand, and heights of five fingertips, m.
            measured_x_m, measured_y_m, measured_z_m: place of the telemanipulator, m.
            force_n: contact force of each finger, N.
            force_age_s: age of the telemanipulator's measurements, s; infinite before the first.
            heater_drive: wanted drive of each sensor's heater, -1..1, positive heats.
            sensor_c: last reading of each sensor plate, C; NaN where it is implausible.
            ambient_c: last reading of the air at each sensor, C; NaN where it is implausible.
            sensor_age_s: age of each reading, s; infinite for a finger without a sensor, which takes no part.
            in_contact: whether each finger touches an object.
            patient_switch: the patient's stop switch; None at a site without one.
            pain: the patient's answer, 0..10; NaN while it is unknown, None at a site without a pain slider.
        """
        dt_s = self._elapsed(t_s)
        self._inspect_motion(wanted_x_m + wanted_y_m + sum(wanted_z_m) + sum(heater_drive))
        measured = (measured_x_m, measured_y_m, *measured_z_m)
        known = self._inspect_measured(dt_s, force_age_s, measured, force_n, sensor_age_s)
        if pain is not None and known:
            self._follow_pain(measured_x_m, measured_y_m, force_n, pain)
        self._watch_forces(dt_s, known, measured_z_m, force_n)
        for number, (plate_c, age_s) in enumerate(zip(sensor_c, sensor_age_s, strict=True)):
            if SENSOR_PLATE_C < plate_c <= SENSOR_HIGH_C and age_s <= GAP_S:
                self.trip(Fault(FaultCode.SENSOR_PLATE_TOO_HOT, FINGERS[number], value=plate_c, limit=SENSOR_PLATE_C))
        leave = self._patient_stops(patient_switch)
        live = engaged and known and 0.0 <= motion_age_s <= GAP_S and self._fault is None and not leave
        limits = (0 if live else RELEASED) | (0 if known else FORCE_UNKNOWN)
        # After the patient's stop, the retreat begins in this tick.
        self._stopped_s = 0.0 if live else max(self._stopped_s + dt_s, STOP_S if leave else 0.0)
        if dt_s > TICK_AGE_S:
            # After a standstill the devices may have become safe by themselves, and the fingers may have risen.
            self._live, self._drive = False, [0.0] * len(FINGERS)
            for heater in self._heaters:
                heater.repeated.interrupt()
        if known and (not self._ready or (live and not self._live)):
            self._start_from(measured)
        self._live = live
        tick_s = min(LONGEST_TICK_S, dt_s)
        if live:
            limits |= self._plane.follow(tick_s, wanted_x_m, wanted_y_m)
        limited, heights_m, hand_met = [limits] * len(FINGERS), [], self._plane.met
        for number, finger in enumerate(self._fingers):
            pressed_n, plate_c = force_n[number] if known else math.nan, sensor_c[number]
            if live:
                limited[number] |= finger.follow(tick_s, wanted_z_m[number], measured_z_m[number], pressed_n, hand_met)
            else:
                finger.retreat(tick_s, pressed_n, self._stopped_s)
            heights_m.append(finger.z_m)
            touching = in_contact[number] or not pressed_n <= TOUCHING_N
            if touching:
                limited[number] |= HEATER_CONTACT
            heater, allowed = self._heaters[number], live and not touching
            heater.step(self._t_s, dt_s, self._drive[number], plate_c, ambient_c[number], sensor_age_s[number])
            self._drive[number], acted = self._heat(heater, allowed, heater_drive[number], plate_c)
            limited[number] |= acted
        x_m, y_m = self._plane.x_m, self._plane.y_m
        if known:
            self._follow.commanded(self._t_s, (x_m, y_m, *heights_m), not live)
        return GatedCommand(self._ready, not live, x_m, y_m, heights_m, self._drive[:], limited, self._fault)

    def _elapsed(self, t_s: float) -> float:
        if not math.isfinite(t_s):
            self.trip(Fault(FaultCode.TIME_NOT_FINITE))
            return 0.0
        dt_s = max(0.0, t_s - self._t_s)  # 0 the first time: a comparison with NaN is false
        self._t_s = t_s
        return dt_s

    def _inspect_motion(self, total: float) -> None:
        # One sum is not finite as soon as one part is not; wanted values are far too small to overflow it.
        if not math.isfinite(total):
            self.trip(Fault(FaultCode.MOTION_NOT_FINITE))

    def _inspect_measured(
        self,
        dt_s: float,
        age_s: float,
        measured: tuple[float, ...],
        force_n: Sequence[float],
        sensor_age_s: Sequence[float],
    ) -> bool:
        """Return whether place and forces are known; trip when the telemanipulator does not obey."""
        fresh = 0.0 <= age_s <= GAP_S
        if fresh and math.isfinite(sum(measured) + sum(force_n)):
            # A finger without a sensor takes no part.
            taking_part = [age_s != math.inf for age_s in sensor_age_s] if math.inf in sensor_age_s else _ALL
            disobeys = self._follow.step(dt_s, age_s, measured, force_n, taking_part)
            if disobeys:
                self.trip(disobeys)
            return True
        if fresh:
            self.trip(Fault(FaultCode.MEASUREMENT_NOT_FINITE, device=TELEMANIPULATOR))
        self._follow = FollowingError()  # after a gap the hand may be anywhere
        return False

    def _patient_stops(self, switch: SwitchReading | None) -> bool:
        """Return whether the fingers must leave the patient; trip when the patient stops, or the switch fails."""
        leave, fault = patient_stop(switch)
        if fault is not None:
            self.trip(fault)
        return leave

    def _follow_pain(self, x_m: float, y_m: float, force_n: Sequence[float], pain: float) -> None:
        """Lower the force limit when the patient reports pain."""
        places_y_m = [y_m + beside_m for beside_m in FINGER_Y_M]
        self.pain_limit.step(self._t_s, force_n, [x_m] * len(FINGERS), places_y_m, pain)
        if self.pain_limit.limit_n < self._force_limit_n:
            self._limit_force(self.pain_limit.limit_n)

    def _limit_force(self, limit_n: float) -> None:
        self._force_limit_n = limit_n
        for finger in self._fingers:
            finger.limit_force(limit_n)

    def _watch_forces(self, dt_s: float, known: bool, z_m: Sequence[float], force_n: Sequence[float]) -> None:
        t_s, live = self._t_s, self._live and known
        for name, finger, measured_m, pressed_n in zip(FINGERS, self._fingers, z_m, force_n, strict=True):
            wrong = finger.observe(t_s, dt_s, measured_m if known else math.nan, pressed_n, live)
            if wrong:
                self.trip(wrong._replace(where=name))

    def _start_from(self, measured: tuple[float, ...]) -> None:
        """Start the set-points at the measured place, because the telemanipulator may have stopped by itself."""
        self._ready = True
        x_m, y_m, *heights_m = measured
        self._plane.let_go(x_m, y_m)
        for finger, z_m in zip(self._fingers, heights_m, strict=True):
            finger.let_go(z_m)

    def _heat(self, heater: HeaterLimits, allowed: bool, wanted: float, sensor_c: float) -> tuple[float, int]:
        """Return a heater's drive, -1..1, and `Limit` bits of what acted."""
        acted = 0
        if heater.repeated.needs_test:
            acted = HEATER_TEST
            free = allowed and heater.known and not heater.spent and not heater.too_hot
            wanted = heater.repeated.step(self._t_s, sensor_c, free)
        if not heater.known:
            acted |= SENSOR_UNKNOWN
        elif heater.spent:
            acted |= DOSE
        elif heater.too_hot:
            acted |= SENSOR_TEMPERATURE
        elif allowed:
            drive = min(1.0, max(-1.0, wanted))
            return drive, acted if drive == wanted else acted | HEATER_RANGE
        return 0.0, acted

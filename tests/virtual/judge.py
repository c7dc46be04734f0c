"""Judges limits and hold times at every tick, from the actuators and from what the network delivered."""

from collections.abc import Callable, Iterable

from common.config.site_models import RemoteConfig
from common.limits import (
    AGE_DEFAULT_S,
    CONTACT_FORCE_N,
    FINGER_FORCE_N,
    FORCE_RAMP_UP_N_S,
    FORCE_SAFE_S,
    GAP_S,
    MODULE_TIMEOUT_S,
    MOTOR_FLOOR_RPM,
    MOTOR_MAX_RPM,
    MOTOR_SAFE_S,
    MOTOR_STILL_S,
    PLATE_FAULT_C,
    SENSOR_PLATE_C,
    THERMAL_SAFE_S,
)
from common.wire.packets import LinkState
from teletaction.testbed.memory_lines import MemoryBus, MemoryLine
from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE
from tests.virtual.configurations import EXOSKELETON, TACTTIP, THERMAL
from tests.virtual.session import TICK_S, Truth, VirtualSession

LATE_S = 2 * TICK_S + 1e-9
"""What ticks of the operator's site add to a hold time: one to notice, one to act."""
REMOTE_LATE_S = 2.0 / RemoteConfig.model_fields["rate_hz"].default + 1e-9
"""The same of the remote site."""
SERVO_S = 0.100
"""Time after which a stopped remote finger and hand stand still."""
REPAIRED_S = 0.200
"""Servos that were broken and obey again have gone back to their set-points after this."""
QUANTUM_N = 0.01
"""Of a force on the exoskeleton's bus."""
STILL_M = 0.1e-3
"""Standing still, for a hand and its fingers that are held by servos."""


CLOCKS_AGREE_S = 0.005
"""Half a round trip of a good network, and some. What is acted on may truly be older than the agreed age by as much as
the sites do not know of each other's clocks: half a round trip, whatever its two ways took, at most the age itself."""


def check_limits(_: VirtualSession, now: Truth) -> None:
    """Everything at a finger or a patient is inside the table of limits."""
    assert 0.0 <= now.force_n <= FINGER_FORCE_N, now
    assert 0.0 <= now.motor_rpm <= MOTOR_MAX_RPM, now
    assert -1.0 <= now.peltier <= 1.0, now
    assert now.plate_c <= PLATE_FAULT_C, now
    assert -1.0 <= now.heater <= 1.0, now
    assert now.sensor_c <= SENSOR_PLATE_C, now
    assert now.contact_n <= CONTACT_FORCE_N, now


def moment(now: Truth, since_s: float, what: str) -> str:
    """Name a moment that is `since_s` after the last valid `what`."""
    return f"{since_s:.3f} s after the last valid {what}: {now}"


def check_operator_safe(now: Truth, since_s: float) -> None:
    """The operator's actuators are neutral as far as they must be `since_s` after the last valid input."""
    assert since_s <= FORCE_SAFE_S + LATE_S or now.force_n == 0.0, moment(now, since_s, "touch")
    assert since_s <= MOTOR_SAFE_S + LATE_S or now.motor_mv == 0, moment(now, since_s, "touch")
    assert since_s <= MOTOR_STILL_S + LATE_S or now.motor_rpm < MOTOR_FLOOR_RPM, moment(now, since_s, "touch")
    assert since_s <= THERMAL_SAFE_S + LATE_S or now.peltier == 0.0, moment(now, since_s, "touch")


def check_ramp(truth: Iterable[Truth], engaged_s: float) -> None:
    """Force rises from zero no faster than it may, from the tick in which both sites engaged."""
    for now in truth:
        assert now.force_n <= FORCE_RAMP_UP_N_S * (now.time_s - engaged_s + TICK_S) + QUANTUM_N, now


class RemoteStandstill:
    """Judges the remote site without valid input: heater off, the hand stands still, the finger only goes up."""

    def __init__(self) -> None:
        self._x_m: float | None = None
        self._highest_m = 0.0
        self._broken_s = float("-inf")

    def check(self, now: Truth, since_s: float, disobeyed: bool) -> None:
        """Judge a moment that is `since_s` after the last valid input; of broken servos no standstill is asked."""
        assert since_s <= THERMAL_SAFE_S + REMOTE_LATE_S or now.heater == 0.0, moment(now, since_s, "motion")
        if disobeyed:
            self._broken_s = now.time_s
        if since_s <= GAP_S + SERVO_S + REMOTE_LATE_S or now.time_s - self._broken_s <= REPAIRED_S:
            self._x_m = None
        elif self._x_m is None:
            self._x_m, self._highest_m = now.x_m, now.z_m
        else:
            assert abs(now.x_m - self._x_m) <= STILL_M, f"{moment(now, since_s, 'motion')}, x was {self._x_m}"
            assert now.z_m >= self._highest_m - STILL_M, f"{moment(now, since_s, 'motion')}, z was {self._highest_m}"
            self._highest_m = max(self._highest_m, now.z_m)


class HoldTimes:
    """Watches both sites: outputs are safe within the hold times of the last input that could be valid.

    Valid input is a packet that truly arrived and was truly younger than `age_s`: the sites themselves are not asked.
    """

    def __init__(self, age_s: float) -> None:
        self.age_s = age_s
        self._touch_s = self._motion_s = 0.0
        self._remote = RemoteStandstill()

    def __call__(self, session: VirtualSession, now: Truth) -> None:
        """Judge one tick."""
        ways = session.network.ways
        touch, motion = ways["touch", TO_OPERATOR], ways["motion", TO_REMOTE]
        if touch.arrived_s == now.time_s and touch.arrived_age_s <= self.age_s:
            self._touch_s = now.time_s
        if motion.arrived_s == now.time_s and motion.arrived_age_s <= self.age_s:
            self._motion_s = now.time_s
        check_operator_safe(now, now.time_s - self._touch_s)
        self._remote.check(now, now.time_s - self._motion_s, session.disobeyed)


class Latches:
    """Watches both sites: while a fault is latched nothing is put out, once the ramp to neutral has ended."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}
        self._remote = RemoteStandstill()

    def __call__(self, session: VirtualSession, now: Truth) -> None:
        """Judge one tick."""
        for side, its_session in (
            ("remote", session.remote.server.session),
            ("operator", session.operator.client.session),
        ):
            if its_session.state is LinkState.FAULT:
                self._since_s.setdefault(side, now.time_s)
            else:
                self._since_s.pop(side, None)
        # A fault needs no gap to be noticed: the ramps begin at once, unless the device cannot be reached.
        if "operator" in self._since_s:
            noticed_s = GAP_S if session.sim_operator.bus.hears else 0.0
            check_operator_safe(now, noticed_s + now.time_s - self._since_s["operator"])
        noticed_s = GAP_S if session.sim_remote.bus.hears else 0.0
        remote_s = noticed_s + now.time_s - self._since_s["remote"] if "remote" in self._since_s else 0.0
        self._remote.check(now, remote_s, session.disobeyed)


class DeviceTimeouts:
    """Watches every device that does not hear its driver any more: it brings its own outputs to rest."""

    def __init__(self) -> None:
        self._since_s: dict[MemoryLine | MemoryBus, float] = {}

    def __call__(self, session: VirtualSession, now: Truth) -> None:
        """Judge one tick."""
        if self._lost_s(session.wiring.lines[TACTTIP], now) > MODULE_TIMEOUT_S + LATE_S:
            assert (now.motor_mv, now.peltier) == (0, 0.0), now
        if self._lost_s(session.wiring.lines[THERMAL], now) > MODULE_TIMEOUT_S + LATE_S:
            assert now.heater == 0.0, now
        if self._lost_s(session.wiring.buses[EXOSKELETON], now) > FORCE_SAFE_S + LATE_S:
            assert now.force_n == 0.0, now

    def _lost_s(self, line: MemoryLine | MemoryBus, now: Truth) -> float:
        """How long nothing has reached a device, s."""
        if line.hears:
            self._since_s.pop(line, None)
            return 0.0
        return now.time_s - self._since_s.setdefault(line, now.time_s)


def judges(
    max_age_s: float = AGE_DEFAULT_S, clocks_agree_s: float = CLOCKS_AGREE_S
) -> list[Callable[[VirtualSession, Truth], None]]:
    """All that must hold at every tick of a session with this agreed age, where clocks are known this well, s."""
    return [check_limits, HoldTimes(max_age_s + clocks_agree_s), Latches(), DeviceTimeouts()]

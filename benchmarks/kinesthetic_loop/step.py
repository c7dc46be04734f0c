"""One kinesthetic step of the operator site: heights from the bus, contacts, the gate's limits, forces to the bus.

Time spent in python-can is counted apart. The baseline is the least that Python can do instead: five bare springs.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import cast

import can

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver, FrameSender, database
from common.config.site_models import RenderingConfig
from common.faults.fault import Fault
from common.fingers import FINGERS
from common.limits import FINGER_FORCE_N
from operator_site.devices.exoskeleton import Exoskeleton
from operator_site.force.passive_contact import PassiveContact
from operator_site.safety.force_limits import ForceLimits
from operator_site.safety.sampled_wall import SampledWall
from teletaction.session.step_cost import quickest_s

_SITE = RenderingConfig()
WALL = SampledWall(_SITE.exoskeleton_damping_n_s_m, 0.001, _SITE.exoskeleton_delay_s)
SURFACE_M, STIFFNESS_N_M = 0.0, WALL.stiffest_n_m
"""Height of the bench, m, and the largest stiffness that the site displays, N/m."""
PARTS = ("bus", "decode", "contacts", "limits", "encode")
"""Parts of a tick: python-can's receiving and sending, checking heights, computing forces, the gate's limits on them,
and encoding their frame. `contacts` and `limits` are the kinesthetic step itself, without the gate's plates and
motors."""
_NOTHING = (0.0,) * len(FINGERS)


class TimedBus:
    """A python-can bus that counts the time spent in it."""

    def __init__(self, bus: can.BusABC) -> None:
        self.spent_s = 0.0
        self._bus = bus

    def recv(self, timeout: float) -> can.Message | None:
        """Receive the next frame."""
        began_s = time.perf_counter()
        message = self._bus.recv(timeout)
        self.spent_s += time.perf_counter() - began_s
        return message

    def send(self, message: can.Message) -> None:
        """Send a frame."""
        began_s = time.perf_counter()
        self._bus.send(message)
        self.spent_s += time.perf_counter() - began_s

    def shutdown(self) -> None:
        """Close the bus."""
        self._bus.shutdown()

    def take_s(self) -> float:
        """The time spent since the last call, s."""
        spent_s, self.spent_s = self.spent_s, 0.0
        return spent_s


@dataclass(slots=True)
class KinestheticStep:
    """The force loop of the operator site by itself.

    Attributes:
        spent_s: cost of each part of each step, s, in the order of PARTS.
        answered_s: time by the device's clock, s, at which the heights were measured that each sent force answers.
    """

    address: CanAddress
    exoskeleton: Exoskeleton = field(init=False)
    spent_s: list[tuple[float, ...]] = field(default_factory=list)
    answered_s: list[float] = field(default_factory=list)
    _contacts: list[PassiveContact] = field(init=False)
    fault: Fault | None = None
    _limits: list[ForceLimits] = field(init=False)
    _t_s: float = math.nan
    _heights_s: float = math.nan
    _pushed_n: Sequence[float] = _NOTHING
    _bus: TimedBus | None = None

    def __post_init__(self) -> None:
        self.exoskeleton = Exoskeleton(self.address)
        self._contacts = [PassiveContact(WALL) for _ in FINGERS]
        self._limits = [ForceLimits(WALL) for _ in FINGERS]

    def connect(self, t_s: float) -> bool:
        """Whether heights of the exoskeleton have arrived; call it until they have."""
        line = self.exoskeleton.line
        heard = not math.isinf(self.exoskeleton.read(t_s).oldest_s)
        if heard and self._bus is None and line._bus is not None:
            self._bus = TimedBus(line._bus)
            line._bus = cast(can.BusABC, self._bus)
        return heard

    def catch_up(self) -> None:
        """Discard frames that came while this step waited for its turn: old places in a row are no motion."""
        while self.exoskeleton.line.poll():
            pass

    def tick(self, t_s: float) -> None:
        """Read, compute contacts, limit and write, at the time `t_s`."""
        assert self._bus
        began_s = time.perf_counter()
        hand = self.exoskeleton.read(t_s)
        for fault in self.exoskeleton.faults(t_s):
            self.fault = self.fault or fault
        read_s = time.perf_counter()
        receiving_s = self._bus.take_s()
        force_n = []
        for contact, z_m, pushed_n in zip(self._contacts, hand.place.z_m, self._pushed_n, strict=True):
            contact.let_through(pushed_n)
            force_n.append(contact.step(t_s, z_m, SURFACE_M, STIFFNESS_N_M))
        rendered_s = time.perf_counter()
        dt_s, self._t_s = max(0.0, t_s - self._t_s), t_s
        self._pushed_n, wrong = let_through(self._limits, t_s, dt_s, t_s - hand.oldest_s, force_n, hand.place.z_m)
        self.fault = self.fault or wrong
        limited_s = time.perf_counter()
        self.exoskeleton.push(t_s, self._pushed_n, enabled=True)
        ended_s = time.perf_counter()
        if heights := self.exoskeleton.line.came.get("FingerHeights"):
            self._heights_s = heights[-1][0]
        self.answered_s.append(self._heights_s)
        sending_s = self._bus.take_s()
        decoding_s, encoding_s = read_s - began_s - receiving_s, ended_s - limited_s - sending_s
        pushing_s, limiting_s = rendered_s - read_s, limited_s - rendered_s
        self.spent_s.append((receiving_s + sending_s, decoding_s, pushing_s, limiting_s, encoding_s))


def let_through(
    limits: Sequence[ForceLimits], t_s: float, dt_s: float, age_s: float, force_n: Sequence[float], z_m: Sequence[float]
) -> tuple[list[float], Fault | None]:
    """Forces that the gate passes of five wanted ones, N, and the fault that it finds."""
    wrong = None
    for finger, height_m in zip(limits, z_m, strict=True):
        wrong = finger.observe(t_s, t_s - age_s, height_m) or wrong
    return [finger.step(t_s, dt_s, True, age_s, wanted) for finger, wanted in zip(limits, force_n, strict=True)], wrong


def bare_springs(data: bytes) -> bytes:
    """Baseline: five springs from a frame of heights to a frame of forces, without any check or bus."""
    heights, forces = int.from_bytes(data, "little"), 0
    for finger in range(5):
        counts = (heights >> 12 * finger & 0xFFF ^ 0x800) - 0x800
        force_n = min(FINGER_FORCE_N, max(0.0, -STIFFNESS_N_M * counts * 5e-6))
        forces |= round(force_n * 100.0) << 10 * finger
    return (forces | 1 << 50).to_bytes(8, "little")


class BareStep:
    """Tick of the bare loop: five bare springs.

    Attributes:
        spent_s: cost of each step, s.
    """

    def __init__(self) -> None:
        self.spent_s: list[tuple[float, ...]] = []
        self._frame = FrameSender("FingerHeights").encode(dict.fromkeys(FINGERS, -1.234)).data

    def catch_up(self) -> None:
        """Do nothing; no frames come."""

    def tick(self, _t_s: float) -> None:
        """Compute five bare springs."""
        began_s = time.perf_counter()
        bare_springs(bytes(self._frame))
        self.spent_s.append((time.perf_counter() - began_s,))


def part_costs_us(repeat: int) -> dict[str, float]:
    """Cost of each part of a step in a loop of nothing else, us: the best mean of five runs of `repeat` calls."""
    heights, receiver = FrameSender("FingerHeights"), FrameReceiver("FingerHeights")
    forces = FrameSender("FingerForces")
    frames = [bytes(heights.encode(dict.fromkeys(FINGERS, -1.234)).data) for _ in range(16)]
    values = {"enabled": 1.0, **dict.fromkeys(FINGERS, 0.49)}
    described, signed = database(), {**values, "counter": 1, "crc": 0}
    measured, pushed = (described.get_message_by_name(name) for name in ("FingerHeights", "FingerForces"))
    turn = iter(range(10**9))
    contacts, limits = [PassiveContact(WALL) for _ in FINGERS], [ForceLimits(WALL) for _ in FINGERS]

    def push() -> None:
        t_s = 1e-3 * next(turn)
        for contact in contacts:
            contact.step(t_s, -0.001, SURFACE_M, STIFFNESS_N_M)

    def limit() -> None:
        let_through(limits, 1e-3 * next(turn), 1e-3, 0.0, [0.49] * len(FINGERS), [-0.001] * len(FINGERS))

    calls: dict[str, Callable[[], object]] = {
        "bare springs": lambda: bare_springs(frames[0]),
        "cantools decode": lambda: measured.decode(frames[0]),
        "cantools encode": lambda: pushed.encode(signed, strict=False),
        "decode": lambda: receiver.decode(frames[next(turn) % 16]),
        "encode": lambda: forces.encode(values),
        "contacts": push,
        "limits": limit,
    }
    return {name: 1e6 * quickest_s(call, repeat, rounds=5) for name, call in calls.items()}

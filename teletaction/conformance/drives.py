"""Common part of the two kinds of module with drives: a plate on a Peltier element, and reports of the drives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from common.buses.serial_messages import (
    BadPayload,
    DeviceFlag,
    DeviceKind,
    Frame,
    HeaterCommand,
    MessageId,
    TactTipCommand,
    TactTipState,
    ThermalReading,
)
from common.buses.thermometry import COUNT_MAX, ntc_c, ssr_c
from common.limits import PLATE_PEAK_C
from teletaction.conformance.checklist import NotApplicable, Unsafe
from teletaction.conformance.every_module import device_times_s
from teletaction.conformance.module_talk import REPORTS, ModuleTalk, Span

QUIET_S = 0.15
"""Silence after the last command, s, in which the time-out acts and a report shows it."""
WARMEST_C, COLDEST_C = 40.0, 5.0
"""Upper and lower limit of the plate in trials other than those of the cut-out, C."""
MILD_PERMILLE, MILD_MV = 100, 500
PLATE_PERMILLE, PLATE_S = 300, 1.0
REPEAT_S = 0.02
MOST_UNREAD = 5


@dataclass(frozen=True, slots=True)
class DriveState:
    """Content of a report: device time, temperatures, flags, and applied outputs."""

    device_s: float
    plate_c: float
    counts: tuple[int, int]
    flags: int
    permille: int
    motor_mv: int

    @property
    def applied(self) -> tuple[int, int]:
        """Peltier drive and motor voltage."""
        return self.permille, self.motor_mv

    @property
    def timed_out(self) -> bool:
        """Whether the report says that no command is in force."""
        return bool(self.flags & DeviceFlag.COMMAND_TIMEOUT)

    @property
    def cut_out(self) -> bool:
        """Whether the report says that the temperature limit acts."""
        return bool(self.flags & DeviceFlag.THERMAL_CUT_OUT)


OFF = (0, 0)


class Drives:
    """The drives of one module on trial.

    Attributes:
        talk: the module.
        mild: drive of the trials, thousandths of full drive, and motor voltage, mV, 0 without a motor.
        warmest_c: temperature of the plate above which the trial ends, C.
        away_s: longest time between two commands of the last `hold`, s, caused by the host.
    """

    def __init__(self, talk: ModuleTalk) -> None:
        self.talk = talk
        self.tacttip = talk.kind is DeviceKind.TACTTIP
        self.mild = (MILD_PERMILLE, MILD_MV if self.tacttip else 0)
        self.warmest_c = WARMEST_C
        self.away_s = 0.0
        self._driving = False
        self._pulse_number = 0
        self._unread = 0
        talk.watch = self._look

    def command(self, permille: int, motor_mv: int = 0) -> bytes:
        """Return the payload of a command."""
        return TactTipCommand(motor_mv, permille).encode() if self.tacttip else HeaterCommand(permille).encode()

    @property
    def command_id(self) -> MessageId:
        """Message id of the module's commands."""
        return MessageId.TACTTIP_COMMAND if self.tacttip else MessageId.HEATER_COMMAND

    @property
    def refused(self) -> Mapping[str, bytes]:
        """Payloads of commands with one value out of range each."""
        if not self.tacttip:
            return {f"{permille} thousandths": HeaterCommand.LAYOUT.pack(permille) for permille in (1001, -1001, 32767)}
        wrong = {
            "motor 3001 mV": (3001, 0, 0, 0, 1),
            "1001 thousandths": (0, 1001, 0, 0, 1),
            "-1001 thousandths": (0, -1001, 0, 0, 1),
            "pulse of 3001 mV": (0, 0, 3001, 10, 1),
            "pulse of 50 001 us": (0, 0, 0, 50_001, 1),
        }
        return {what: TactTipCommand.LAYOUT.pack(*values) for what, values in wrong.items()}

    def drive(self, permille: int, motor_mv: int = 0) -> None:
        """Send one command."""
        self._driving = self._driving or bool(permille or motor_mv)
        self.talk.say(self.command_id, self.command(permille, motor_mv))

    def pulse(self, motor_mv: int, pulse_mv: int, pulse_us: int) -> TactTipCommand:
        """Return a command with a pulse of a new number, and the voltage after the pulse."""
        self._pulse_number = (self._pulse_number + 1) & 0xFF
        return TactTipCommand(motor_mv, 0, pulse_mv, pulse_us, self._pulse_number)

    def say(self, command: TactTipCommand) -> None:
        """Send one command of a TactTip."""
        self._driving = True
        self.talk.say(self.command_id, command.encode())

    def listen(self, seconds: float) -> list[DriveState]:
        """Return the reports of the next `seconds`."""
        return self.states(self.talk.listen(seconds))

    def hold(self, permille: int, motor_mv: int, seconds: float, each_s: float = REPEAT_S) -> list[DriveState]:
        """Repeat a command for `seconds`; return the reports of that time."""
        spans = []
        self.away_s, sent_s = 0.0, self.talk.end.now()
        until_s = sent_s + seconds
        while (now_s := self.talk.end.now()) < until_s:
            self.away_s, sent_s = max(self.away_s, now_s - sent_s), now_s
            self.drive(permille, motor_mv)
            spans.append(self.talk.listen(each_s))
        return self.states_of(spans)

    @cached_property
    def each_way(self) -> tuple[list[DriveState], list[DriveState], list[DriveState]]:
        """Reports at rest, with the plate heated for 1 s, and cooled for 1 s; driven only once, for all duties.

        Raises:
            NotApplicable: the plate is too hot or too cold at the start.
        """
        self.ready()
        at_rest = self.listen(0.2)
        return at_rest, self.hold(PLATE_PERMILLE, 0, PLATE_S), self.hold(-PLATE_PERMILLE, 0, PLATE_S)

    def states_of(self, spans: Sequence[Span]) -> list[DriveState]:
        """Return the readable reports of several spans, with one device time over all of them."""
        return self.states(Span([heard for span in spans for heard in span.frames], 0))

    def states(self, span: Span) -> list[DriveState]:
        """Return the readable reports of a span."""
        reports = self.talk.reports(span)
        found = (_drive_state(heard.frame, at_s) for heard, at_s in zip(reports, device_times_s(reports), strict=False))
        return [state for state in found if state is not None]

    def settle(self, longer_s: float = 0.0) -> None:
        """Command everything off, then send nothing until the time-out has acted, and for `longer_s` more.

        Raises:
            Unsafe: no reports come.
        """
        for _ in range(2):  # one frame may be lost
            self.drive(0)
        span = self.talk.listen(QUIET_S + longer_s)
        # This host may have paused instead: listen once more.
        if not self.talk.reports(span) and not self.talk.reports(self.talk.listen(QUIET_S)):
            raise Unsafe("no more reports")

    def ready(self) -> DriveState:
        """Return the last report before a trial; raise NotApplicable if the plate is too hot or too cold for one."""
        before = self.listen(0.1)
        if not before:
            raise NotApplicable("no sound reports")
        if not COLDEST_C < before[-1].plate_c < WARMEST_C - 2.0:
            raise NotApplicable(f"the plate is at {before[-1].plate_c:.1f} C: nothing is driven")
        return before[-1]

    def words(self, applied: tuple[int, int]) -> str:
        """Return the applied outputs as text."""
        return f"{applied[0]} thousandths" + (f" and {applied[1]} mV" if self.tacttip else "")

    def _look(self, frame: Frame) -> None:
        if frame.message_id != REPORTS[self.talk.kind] or not self._driving:
            return
        state = _drive_state(frame)
        self._unread = 0 if state is not None else self._unread + 1
        if self._unread > MOST_UNREAD:
            raise Unsafe("unreadable reports while it is driven")
        if state is not None and not COLDEST_C <= state.plate_c <= self.warmest_c:
            raise Unsafe(f"the plate is at {state.plate_c:.1f} C")


def _drive_state(frame: Frame, device_s: float = 0.0) -> DriveState | None:
    """Return the content of one report; None if it is unreadable."""
    try:
        if frame.message_id == MessageId.THERMAL_READING:
            reading = ThermalReading.decode(frame.payload)
            counts = (reading.plate_counts, reading.ambient_counts)
            return DriveState(device_s, ssr_c(counts[0]), counts, reading.flags, reading.heater_permille, 0)
        report = TactTipState.decode(frame.payload)
    except BadPayload:
        return None
    counts = (report.plate_counts, report.hot_side_counts)
    # A broken sensor measures nothing, so its plate counts as too hot.
    plate_c = ntc_c(counts[0]) if 0 < counts[0] < COUNT_MAX else PLATE_PEAK_C + 1.0
    return DriveState(device_s, plate_c, counts, report.flags, report.peltier_permille, report.motor_mv)

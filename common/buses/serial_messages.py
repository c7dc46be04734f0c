"""Protocol of the serial devices: messages, little endian, and the frames that carry them.

    frame = COBS(id u8, sequence u8, payload, crc u16 little endian), 0x00

A frame contains no zero byte, so a reader resynchronises at the next zero after any damage. The CRC is
CRC-16/CCITT-FALSE over id, sequence and payload. docs/protocols.md describes the protocol for firmware. Its golden
bytes test this file.
"""

import binascii
import math
import struct
from dataclasses import dataclass
from enum import IntEnum
from types import FunctionType
from typing import Any, ClassVar, NamedTuple, TypeVar

from common.fingers import FINGERS

try:  # compiled, where there is a wheel for the machine; both give the same bytes
    from corncobs import DecodeError, decode, encode
except ImportError:
    from cobs.cobs import DecodeError, decode, encode

COMPILED = not isinstance(encode, FunctionType)
"""Whether COBS is compiled here; a pure Python form is slower."""
MAX_FRAME = 250
"""Maximum size of a frame before COBS, bytes: one COBS block. It also bounds the buffer on a line without zeros."""
_CRC_INIT = 0xFFFF


class MessageId(IntEnum):
    """First byte of every frame."""

    IDENTIFY = 0x01
    IDENTITY = 0x02
    TEXTURE_SAMPLES = 0x10
    THERMAL_READING = 0x20
    HEATER_COMMAND = 0x21
    TACTTIP_COMMAND = 0x30
    TACTTIP_STATE = 0x31
    PATIENT_SWITCH_STATE = 0x40


class DeviceKind(IntEnum):
    """Kind of a serial device, from its answer to IDENTIFY."""

    TEXTURE_SENSOR = 1
    THERMAL_SENSOR = 2
    TACTTIP = 3
    PATIENT_SWITCH = 4
    """The patient's stop switch. It belongs to no finger; its finger is 0."""


class DeviceFlag(IntEnum):
    """Bits of a device's status byte."""

    COMMAND_TIMEOUT = 0x01
    """No valid command for 100 ms: the device has turned its own drives off."""
    THERMAL_CUT_OUT = 0x02
    """The device's own temperature limit has turned its drive off."""
    SATURATED = 0x04
    """At least one sample since the last message was clipped."""


class BadPayload(ValueError):
    """A frame with a good CRC whose content does not fit its id."""


def _unpack(layout: struct.Struct, payload: bytes, what: str) -> tuple[Any, ...]:
    if len(payload) != layout.size:
        raise BadPayload(f"{what}: {len(payload)} bytes, expected {layout.size}")
    return layout.unpack(payload)


@dataclass(frozen=True, slots=True)
class Identity:
    """A device's answer to IDENTIFY."""

    kind: DeviceKind
    finger: int
    serial: str
    firmware: int
    rate_hz: int
    range_low: float
    range_high: float
    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<BB8sHHff")

    def encode(self) -> bytes:
        """Payload bytes; the serial number is ASCII, at most 8 characters."""
        serial = self.serial.encode("ascii").ljust(8, b" ")
        return self.LAYOUT.pack(
            self.kind, self.finger, serial, self.firmware, self.rate_hz, self.range_low, self.range_high
        )

    @classmethod
    def decode(cls, payload: bytes) -> "Identity":
        """Check and unpack.

        Raises:
            BadPayload: wrong length, unknown kind or finger, a serial number that is not ASCII, or a range that is not
                finite.
        """
        kind, finger, serial, firmware, rate_hz, low, high = _unpack(cls.LAYOUT, payload, "identity")
        assert isinstance(serial, bytes)
        try:
            kind, name = DeviceKind(int(kind)), serial.decode("ascii").strip()
        except ValueError as error:
            raise BadPayload(f"identity: {error}") from None
        if int(finger) >= len(FINGERS):
            raise BadPayload(f"identity: no finger {finger!r}")
        if not (math.isfinite(float(low)) and math.isfinite(float(high))):
            raise BadPayload(f"identity: range {low!r} to {high!r}")
        return cls(kind, int(finger), name, int(firmware), int(rate_hz), float(low), float(high))


@dataclass(slots=True)
class TextureSamples:
    """A chunk of the piezo signal: signed 12-bit counts at the sensor's rate, oldest first."""

    device_time_us: int
    counts: bytes
    """int16 little endian, -2048..2047 for -10..+10 V."""
    ID: ClassVar[MessageId] = MessageId.TEXTURE_SAMPLES
    HEAD: ClassVar[struct.Struct] = struct.Struct("<IB")
    HIGH_BYTES: ClassVar[bytes] = bytes(range(0x08)) + bytes(range(0xF8, 0x100))
    """Valid second bytes of a count: 12 bits, sign extended to 16."""

    def encode(self) -> bytes:
        """Payload bytes."""
        return self.HEAD.pack(self.device_time_us & 0xFFFFFFFF, len(self.counts) // 2) + self.counts

    @classmethod
    def decode(cls, payload: bytes) -> "TextureSamples":
        """Check and unpack.

        Raises:
            BadPayload: the length does not fit the number of samples, or a sample exceeds 12 bits.
        """
        if len(payload) < cls.HEAD.size:
            raise BadPayload(f"texture samples: {len(payload)} bytes are too few")
        time_us, count = cls.HEAD.unpack_from(payload)
        counts = payload[cls.HEAD.size :]
        if len(counts) != 2 * count:
            raise BadPayload(f"texture samples: {count} samples announced, {len(counts)} bytes follow")
        if counts[1::2].translate(None, cls.HIGH_BYTES):
            raise BadPayload("texture samples: beyond 12 bits")
        return cls(time_us, counts)


@dataclass(slots=True)
class ThermalReading:
    """One reading of the remote thermal sensor: 12-bit counts (`common.buses.thermometry`) and the heater drive."""

    device_time_us: int
    plate_counts: int
    ambient_counts: int
    flags: int
    heater_permille: int
    """Present heater drive after all limits of the device, thousandths of full drive."""
    ID: ClassVar[MessageId] = MessageId.THERMAL_READING
    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<IHHBh")

    def encode(self) -> bytes:
        """Payload bytes."""
        return self.LAYOUT.pack(
            self.device_time_us & 0xFFFFFFFF, self.plate_counts, self.ambient_counts, self.flags, self.heater_permille
        )

    @classmethod
    def decode(cls, payload: bytes) -> "ThermalReading":
        """Check and unpack.

        Raises:
            BadPayload: wrong length, counts beyond 12 bits, or a drive beyond full drive.
        """
        time_us, plate, ambient, flags, heater = _unpack(cls.LAYOUT, payload, "thermal reading")
        if plate > 4095 or ambient > 4095:
            raise BadPayload(f"thermal reading: counts {plate}, {ambient} are beyond 12 bits")
        _check_drive(heater)
        return cls(time_us, plate, ambient, flags, heater)


DRIVE_FULL = 1000
"""Full drive of a Peltier element or heater, thousandths. A drive is signed; positive heats the finger's side."""


@dataclass(slots=True)
class HeaterCommand:
    """Drive of the thermal sensor's Peltier element, -1000..1000 thousandths."""

    drive_permille: int
    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<h")

    def encode(self) -> bytes:
        """Return the payload bytes; raises ValueError where the drive is beyond full drive."""
        _check_drive(self.drive_permille)
        return self.LAYOUT.pack(self.drive_permille)

    @classmethod
    def decode(cls, payload: bytes) -> "HeaterCommand":
        """Check and unpack; raises BadPayload on a wrong length or a drive beyond full drive."""
        (drive,) = _unpack(cls.LAYOUT, payload, "heater command")
        _check_drive(drive)
        return cls(drive)


MOTOR_MAX_MV = 3000
MOTOR_PULSE_MAX_US = 50_000


@dataclass(slots=True)
class TactTipCommand:
    """Drives of one fingertip module: motor voltage 0..3000 mV, Peltier -1000..1000 thousandths.

    The motor gets `pulse_mv`, 0..3000 mV, for `pulse_us`, 0..50 000 us, and then `motor_mv`. The module times the pulse
    from the first command with this `pulse_number` (0..255). A late next command therefore neither prolongs nor repeats
    the pulse. A command without a pulse (0 us) ends it.
    """

    motor_mv: int
    peltier_permille: int
    pulse_mv: int = 0
    pulse_us: int = 0
    pulse_number: int = 0
    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<HhHHB")

    def encode(self) -> bytes:
        """Return the payload bytes; raises ValueError where a drive is out of its range."""
        self._check()
        return self.LAYOUT.pack(
            self.motor_mv, self.peltier_permille, self.pulse_mv, self.pulse_us, self.pulse_number & 0xFF
        )

    @classmethod
    def decode(cls, payload: bytes) -> "TactTipCommand":
        """Check and unpack; raises BadPayload on a wrong length or a drive out of range."""
        command = cls(*_unpack(cls.LAYOUT, payload, "TactTip command"))
        command._check()
        return command

    def _check(self) -> None:
        _check_motor(self.motor_mv)
        _check_drive(self.peltier_permille)
        _check_motor(self.pulse_mv)
        if not 0 <= self.pulse_us <= MOTOR_PULSE_MAX_US:
            raise BadPayload(f"motor pulse of {self.pulse_us} us is outside 0..{MOTOR_PULSE_MAX_US}")


@dataclass(slots=True)
class TactTipState:
    """Measurements of a fingertip module: NTC counts (`common.buses.thermometry.ntc_c`) and the applied drives."""

    device_time_us: int
    plate_counts: int
    hot_side_counts: int
    flags: int
    motor_mv: int
    peltier_permille: int
    """Present Peltier drive after all limits of the device, thousandths of full drive."""
    ID: ClassVar[MessageId] = MessageId.TACTTIP_STATE
    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<IHHBHh")

    def encode(self) -> bytes:
        """Payload bytes."""
        return self.LAYOUT.pack(
            self.device_time_us & 0xFFFFFFFF,
            self.plate_counts,
            self.hot_side_counts,
            self.flags,
            self.motor_mv,
            self.peltier_permille,
        )

    @classmethod
    def decode(cls, payload: bytes) -> "TactTipState":
        """Check and unpack; raises BadPayload on a wrong length, counts beyond 12 bits or a drive out of range."""
        time_us, plate, hot, flags, motor, peltier = _unpack(cls.LAYOUT, payload, "TactTip state")
        if plate > 4095 or hot > 4095:
            raise BadPayload(f"TactTip state: counts {plate}, {hot} are beyond 12 bits")
        _check_motor(motor)
        _check_drive(peltier)
        return cls(time_us, plate, hot, flags, motor, peltier)


SLIDER_FULL = 1000
"""End of the pain slider, thousandths: the worst pain, 10 on the scale 0..10."""


@dataclass(slots=True)
class PatientSwitchState:
    """State of the patient's stop switch, whose contact is normally closed: an open one is a press.

    A device with a pain slider adds the slider's position, 0..1000 thousandths; None without a slider.
    """

    device_time_us: int
    closed: bool
    pain_permille: int | None = None
    ID: ClassVar[MessageId] = MessageId.PATIENT_SWITCH_STATE
    LAYOUT: ClassVar[struct.Struct] = struct.Struct("<IB")
    WITH_SLIDER: ClassVar[struct.Struct] = struct.Struct("<IBH")

    def encode(self) -> bytes:
        """Return the payload bytes; raises ValueError where the slider is beyond its end."""
        head = (self.device_time_us & 0xFFFFFFFF, self.closed)
        if self.pain_permille is None:
            return self.LAYOUT.pack(*head)
        _check_slider(self.pain_permille)
        return self.WITH_SLIDER.pack(*head, self.pain_permille)

    @classmethod
    def decode(cls, payload: bytes) -> "PatientSwitchState":
        """Check and unpack.

        Raises:
            BadPayload: a wrong length, a contact that is neither 0 nor 1, or a slider beyond its end.
        """
        if len(payload) == cls.WITH_SLIDER.size:
            time_us, contact, pain = cls.WITH_SLIDER.unpack(payload)
            _check_slider(pain)
        else:
            (time_us, contact), pain = _unpack(cls.LAYOUT, payload, "patient switch state"), None
        if contact > 1:
            raise BadPayload(f"patient switch state: contact {contact} is neither 0 nor 1")
        return cls(time_us, bool(contact), pain)


def _check_drive(permille: int) -> None:
    if not -DRIVE_FULL <= permille <= DRIVE_FULL:
        raise BadPayload(f"Peltier drive {permille} is outside -{DRIVE_FULL}..{DRIVE_FULL} thousandths")


def _check_slider(permille: int) -> None:
    if not 0 <= permille <= SLIDER_FULL:
        raise BadPayload(f"pain slider {permille} is outside 0..{SLIDER_FULL} thousandths")


def _check_motor(motor_mv: int) -> None:
    if not 0 <= motor_mv <= MOTOR_MAX_MV:
        raise BadPayload(f"motor voltage {motor_mv} mV is outside 0..{MOTOR_MAX_MV}")


Report = TypeVar("Report", TextureSamples, ThermalReading, TactTipState, PatientSwitchState)
"""A message that a device sends at its own rate."""


class Frame(NamedTuple):
    """One checked frame."""

    message_id: int
    sequence: int
    payload: bytes


def encode_frame(message_id: int, sequence: int, payload: bytes = b"") -> bytes:
    """Wrap one message for the line.

    Raises:
        ValueError: the id or the sequence number is not a byte, or the payload is too long.
    """
    if len(payload) + 4 > MAX_FRAME:
        raise ValueError(f"payload of {len(payload)} bytes is longer than {MAX_FRAME - 4}")
    body = bytes((message_id, sequence)) + payload
    crc = binascii.crc_hqx(body, _CRC_INIT)
    return bytes(encode(body + crc.to_bytes(2, "little"))) + b"\0"


@dataclass(slots=True)
class FrameReader:
    """Turns chunks of bytes into frames or reports; counts damaged and lost frames."""

    damaged: int = 0
    """Number of byte sequences between two zeros that were no valid frame."""
    lost: int = 0
    """Number of frames that were sent, by the sequence numbers, and not read."""
    repeated: int = 0
    """Number of frames with the sequence number of the frame before, and of reports with the device time of the report
    before: the sender's buffer, counter or measurement stands still."""
    malformed: int = 0
    """Number of undamaged frames with a report of invalid content."""
    _pending: bytes = b""
    _sequence: int | None = None
    _device_time_us: int | None = None

    def feed(self, chunk: bytes) -> list[Frame]:
        """Take a chunk of any length; return the frames that it completes."""
        return [Frame(body[0], body[1], body[2:]) for body in self._bodies(chunk)]

    def reports(self, chunk: bytes, kind: type[Report]) -> list[Report]:
        """Take a chunk of any length; return the reports of one kind that it completes, and skip all other frames.

        A report with the device time of the one before is skipped, too, because it contains no new measurement.
        """
        found = []
        for body in self._bodies(chunk):
            if body[0] == kind.ID:
                try:
                    report = kind.decode(body[2:])
                except BadPayload:
                    self.malformed += 1
                    continue
                if report.device_time_us == self._device_time_us:
                    self.repeated += 1
                    continue
                self._device_time_us = report.device_time_us
                found.append(report)
        return found

    def _bodies(self, chunk: bytes) -> list[bytes]:
        """Return id, sequence and payload of each frame that a chunk completes."""
        *pieces, self._pending = (self._pending + chunk).split(b"\0")
        if len(self._pending) > 2 * MAX_FRAME:
            self._pending = self._pending[-MAX_FRAME:]
            self.damaged += 1
        bodies = []
        for piece in pieces:
            if not piece:
                continue
            body = _checked(piece)
            if not body:
                self.damaged += 1
                continue
            if body[1] == self._sequence:
                self.repeated += 1
            elif self._sequence is not None:
                self.lost += (body[1] - self._sequence - 1) & 0xFF
            self._sequence = body[1]
            bodies.append(body)
        return bodies


def _checked(piece: bytes) -> bytes:
    """Return id, sequence and payload from the bytes between two zeros; empty where they are no frame."""
    try:
        body = bytes(decode(piece))
    except DecodeError:
        return b""
    if not 4 <= len(body) <= MAX_FRAME:
        return b""
    checked = body[:-2]
    return checked if binascii.crc_hqx(checked, _CRC_INIT) == body[-1] << 8 | body[-2] else b""

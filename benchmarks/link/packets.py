"""Packets as a session exchanges them, and their sizes on the wire."""

from collections.abc import Sequence

from common.wire.messages import (
    NO_TOUCH,
    Event,
    EventKind,
    ExplorationMode,
    ThermalReason,
    ThermalStatus,
    Touch,
    TouchRow,
    motion_packet,
    pack_hand,
    pack_rows,
)
from common.wire.packets import LinkState, N
from common.wire.touch_summary import NOTHING, TouchSummary

SESSION = 0x1F2E_3D4C_5B6A_7988
"""Session number of every packet here; as long on the wire as the random number of a real session."""
USUAL_EVENTS = 4
"""Taps and grooves in one touch packet; a session on grooved blocks has this many in half a second."""
_FIRST_NS = 10**15
_MATERIALS = ("pine", "aluminium", "pvc", "ceramic_tile", "skin_dermis")
_IN_CONTACT = TouchRow(
    mode=ExplorationMode.STROKING,
    contact=1,
    contact_force_n=1.23,
    x_m=-0.0504,
    y_m=0.0012,
    surface_z_m=-0.002,
    stiffness_n_m=1234.5,
    stiffness_ln_sd=0.03,
    damping_n_s_m=1.8,
    slope_x=-0.02,
    slope_y=0.01,
    k_tap=800.0,
    b_tap_per_s=90.0,
    k_stroke_v=6300.0,
    k_stroke_f=210.0,
    groove_rad_s=310.0,
    b_groove_per_s=80.0,
    conductivity_w_mk=0.12,
    density_kg_m3=510.0,
    specific_heat_j_kgk=1380.0,
    effusivity_ln_sd=0.08,
    object_c=23.1,
    object_c_sd=0.4,
    probability=0.97,
    thermal_status=ThermalStatus.IDENTIFIED,
    thermal_reason=ThermalReason.NONE,
)

# A message within CurveZMQ (RFC 26) within ZMTP: flags and length, "\x07MESSAGE", a short nonce, the box's
# authenticator, and inside the box the message's own flags.
_CURVE_BYTES = 8 + 8 + 16 + 1
_TCP_IP_BYTES = 20 + 20 + 12
"""Length of the IPv4 and TCP headers with time stamps, bytes."""


def touch_parts(touching: int = N) -> Touch:
    """A touch packet in which `touching` fingers (0..5) stroke an object, with USUAL_EVENTS events if any does."""
    rows = [_IN_CONTACT if finger < touching else NO_TOUCH for finger in range(N)]
    names = tuple(name if finger < touching else "" for finger, name in enumerate(_MATERIALS))
    happened = tuple(
        Event(10_000 + n, EventKind.GROOVE, n % touching, _FIRST_NS + n, _FIRST_NS + n, 310.0)
        for n in range(USUAL_EVENTS if touching else 0)
    )
    summaries = tuple(
        TouchSummary(((name, 0.97),), 0.021, 0.002, 4.1e-3, 0.1e-3) if name else NOTHING for name in names
    )
    return Touch(SESSION, 0, _FIRST_NS, LinkState.ENGAGED, pack_rows(rows), names, happened, summaries)


def next_touch(like: Touch, sequence: int, time_ns: int) -> Touch:
    """The same touch in another packet."""
    return Touch(
        SESSION, sequence, time_ns, LinkState.ENGAGED, like.floats, like.materials, like.events, like.summaries
    )


def next_motion(sequence: int, time_ns: int) -> bytes:
    """A motion packet of fingertips that do not move."""
    return motion_packet(SESSION, sequence, time_ns, LinkState.ENGAGED, _AT_REST)


_AT_REST = pack_hand(0.005, 0.005, [0.005] * N)


def framed_bytes(packet: int) -> int:
    """Bytes of the TCP stream for a packet of `packet` bytes, encrypted."""
    body = _CURVE_BYTES + packet
    return body + (2 if body <= 255 else 9)


def wire_bytes(packet: int) -> int:
    """Bytes of the IP packet that carries a packet of `packet` bytes; packets are shorter than a full segment."""
    return framed_bytes(packet) + _TCP_IP_BYTES


def size_table(rates_hz: Sequence[float]) -> list[dict[str, float]]:
    """Bytes of a packet and of a second of packets, touch and motion, for each number of touching fingers."""
    rows = []
    motion = wire_bytes(len(next_motion(10_000, _FIRST_NS)))
    for touching in range(N + 1):
        packet = len(next_touch(touch_parts(touching), 10_000, _FIRST_NS).encode())
        for rate_hz in rates_hz:
            row = {"touching": touching, "rate_hz": rate_hz, "touch_packet_bytes": packet}
            row["touch_wire_bytes"] = wire_bytes(packet)
            row["touch_bytes_s"] = rate_hz * wire_bytes(packet)
            row["motion_wire_bytes"] = motion
            row["motion_bytes_s"] = rate_hz * motion
            rows.append(row)
    return rows

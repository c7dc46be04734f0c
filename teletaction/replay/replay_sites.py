"""Repeats one site's computation on its recording, tick by tick, without devices, link or clock."""

from collections.abc import Sequence

from msgspec.structs import replace

from common.config.site_models import RenderingConfig
from common.fingers import FINGERS
from common.wire.messages import Touch
from operator_site.coupling.coupling import DIRECT, Coupling
from operator_site.gated_rendering import GatedRendering
from operator_site.recorded_rows import Rendered, RenderingInput
from operator_site.safety.gated_output import GatedOutput
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.identification.perception import Perception
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_result import ThermalResult
from teletaction.replay.replay_comparison import Comparison, Fields
from teletaction.replay.replay_named import NamedTouches

Line = dict[str, object]
_RENDERED = ("force_n", "motor_rpm", "plate_set_c", "peltier", "limits")


class RemoteReplay:
    """Repeats the identification of a remote site."""

    def __init__(self, fingers: Sequence[str], materials: MaterialTable, surfaces: SurfaceTable, period_s: float):
        """Identify with the recorded tables.

        Args:
            fingers: names of the site's fingers.
            materials: calibrated materials.
            surfaces: calibrated surfaces.
            period_s: period of the ticks, s, after which a tick is late and solutions wait; infinity: nothing waits.
        """
        self.ticks = 0
        self.named = NamedTouches()
        self.packets = Comparison(touch_fields)
        self._perception = Perception(fingers, materials, surfaces, period_s=period_s)
        self._answered: dict[int, tuple[object, object]] = {}

    @property
    def postponed(self) -> int:
        """Number of late ticks in which a due solution waited."""
        return self._perception.postponed

    def sensed(self, time_s: float, recorded: bytes) -> list[Line]:
        """Take the readings of one tick; return its events and its changes of the identified material."""
        if self.ticks:
            self._perception.work()  # for the tick before, whose packet has been compared
        self.ticks += 1
        happened = self._perception.step(SensorFrame.unpack(recorded))
        self.named.take(time_s, happened)
        lines: list[Line] = [
            {
                "time_s": time_s,
                "finger": FINGERS[event.finger],
                "event": event.kind.name.lower(),
                "value": event.value,
                "name": event.name,
            }
            for event in happened
        ]
        for finger, touch in self._perception.touches.items():
            answer = touch.thermal.answer
            said = answer.status, answer.best
            if said != self._answered.get(finger):
                self._answered[finger] = said
                lines.append({"time_s": time_s, "finger": FINGERS[finger], **_answer(answer)})
        return lines

    def touch(self, time_s: float, recorded: bytes) -> bytes:
        """Return the packet that would be sent now, and compare it with the packet that was sent."""
        sent = Touch.decode(recorded)
        packet = self._perception.packet(sent.session, sent.sequence, sent.time_ns, sent.state).encode()
        self.packets.add(self.ticks - 1, time_s, recorded, packet)
        return packet


class OperatorReplay:
    """Repeats rendering and gate of an operator site."""

    def __init__(self, config: RenderingConfig, period_s: float, gap_s: float):
        """Render with the recorded configuration: `period_s` of the ticks, s, and maximum gap between packets, s."""
        self.ticks = 0
        self.rows = Comparison(rendered_fields)
        self.missing_touches: set[int] = set()
        """Sequence numbers of rendered touch packets that the recording lacks."""
        self._rendering = GatedRendering(config, period_s, gap_s)
        self._newest: Touch | None = None
        self._coupling = DIRECT
        self._output: GatedOutput | None = None

    def touch(self, recorded: bytes) -> None:
        """Take an accepted touch packet."""
        self._newest = Touch.decode(recorded)

    def coupling(self, recorded: bytes) -> None:
        """Take a change of clutch or motion scale."""
        self._coupling = Coupling.unpack(recorded)

    def input(self, recorded: bytes) -> GatedOutput:
        """Take the input of one tick; return the output to the devices."""
        self.ticks += 1
        now = RenderingInput.unpack(recorded)
        touch = None if now.touch is None else self._touch_of(now.touch)
        self._output = self._rendering.step(now, touch, self._coupling)
        return self._output

    def rendered(self, time_s: float, recorded: bytes) -> bytes:
        """Return the row of the output that would be sent now, and compare it with the recorded row."""
        output = self._output
        if output is None:
            return recorded  # the recording lacks its input: nothing to compare
        # The rest of the row is input, and the wall time at which it was written.
        replayed = replace(
            Rendered.unpack(recorded),
            force_n=output.force_n,
            motor_rpm=output.motor_rpm,
            plate_set_c=output.plate_set_c,
            peltier=output.peltier_drive,
            limits=output.limited,
            fault=output.fault,
        ).pack()
        self.rows.add(self.ticks - 1, time_s, recorded, replayed)
        return replayed

    def _touch_of(self, sequence: int) -> Touch | None:
        if self._newest is not None and self._newest.sequence == sequence:
            return self._newest
        self.missing_touches.add(sequence)
        return None


def _answer(answer: ThermalResult) -> Line:
    return {
        "status": answer.status.name.lower(),
        "material": answer.material,
        "best": answer.best,
        "probability": answer.probability,
        "object_c": answer.object_c,
        "object_c_sd": answer.object_c_sd,
        "reason": answer.reason.code or None,
    }


def touch_fields(packet: bytes) -> Fields:
    """Return the results of identification in a touch packet, by name."""
    touch = Touch.decode(packet)
    fields: dict[str, object] = {}
    for finger, row, material in zip(FINGERS, touch.rows, touch.materials, strict=True):
        fields |= {f"{finger}.{name}": value for name, value in row._asdict().items()}
        fields[f"{finger}.material"] = material
    fields |= {
        f"{finger}.summary": [list(map(list, summary[0])), *summary[1:]]
        for finger, summary in zip(FINGERS, touch.summaries, strict=True)
    }
    for event in touch.events:
        fields[f"event {event.ident}"] = [int(event.kind), event.finger, event.time_ns, event.value, event.name]
    return fields


def rendered_fields(row: bytes) -> Fields:
    """Return the output to the devices in a row of operator/rendered, by name."""
    rendered = Rendered.unpack(row)
    fields: dict[str, object] = {}
    for name in _RENDERED:
        fields |= {f"{finger}.{name}": value for finger, value in zip(FINGERS, getattr(rendered, name), strict=True)}
    return {**fields, "fault": rendered.fault}

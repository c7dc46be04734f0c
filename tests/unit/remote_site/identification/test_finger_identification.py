"""One finger from approach to lift: modes, events and thermal answer."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from msgspec import structs
from numpy.typing import NDArray

from common.exploration.hand_motion import HandMotion
from common.fingers import FINGERS
from common.wire.messages import Event, EventKind, ExplorationMode, ThermalReason, ThermalStatus, TouchRow
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.devices.texture_sensor import VOLTS_PER_COUNT
from remote_site.identification.finger_identification import FingerIdentification
from remote_site.identification.perception import FOREIGN_SHARE
from remote_site.identification.touch_events import TouchEvents
from remote_site.identification.touch_summary import TouchSummaries
from remote_site.thermal.heater_control import OFFSETS_K, STAGGER_K
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalResult
from sim_sensors.traces.simulated_stroke import StrokeTrace, simulate_stroke
from tests.unit.remote_site.made_touches import AMBIENT_C, MATERIALS, made_touches, measured, pressed, true_table
from tests.unit.remote_site.made_touches import SENSOR as MADE_SENSOR
from tests.unit.remote_site.shipped_tables import SURFACES
from tests.unit.remote_site.simulated_strokes import to_and_fro

NAMES = {"aluminium": "metal", "ceramic_tile": "stone", "pvc": "plastic"}
"""Materials whose constants can be rendered, and the made-up ones that they are here."""
CONTACT_S, PRESS_N = 0.5, pressed()
FINGER, COUNT = 1, len(FINGERS)


@dataclass(frozen=True)
class Touched:
    """Result of one tick."""

    row: TouchRow
    contact: bool
    thermal: ThermalResult
    measuring: bool
    no_differences: int
    events: list[Event]


@pytest.fixture(scope="module")
def rendered_knowledge() -> ThermalKnowledge:
    """Of materials that the operator site can render."""
    table = true_table({name: MATERIALS[made] for name, made in NAMES.items()})
    return ThermalKnowledge.of(table, foreign_share=FOREIGN_SHARE)


def explore(
    knowledge: ThermalKnowledge,
    sensor: Callable[[float], float],
    stroke_from: float = 99.0,
    seconds: float = 4.5,
    fault: ThermalReason = ThermalReason.NONE,
    lift_s: float = 4.2,
    spoiled: Callable[[float, PlateReading], PlateReading | None] = lambda _, reading: reading,
) -> list[Touched]:
    hand, events = HandMotion(), TouchEvents()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    rng = np.random.default_rng(0)
    touches = []
    for k in range(round(500 * seconds)):
        t = 0.002 * k
        touching = CONTACT_S <= t < lift_s
        x = 0.05 * max(0.0, t - stroke_from)
        noise = (0.012 * rng.normal(size=10) / VOLTS_PER_COUNT).round().astype("<i2")
        reading = PlateReading(sensor(t), AMBIENT_C, (fault if t > 2.0 else ThermalReason.NONE).code, 2000 * k, 0)
        sensed = SensorFrame(
            t,
            x,
            0.0,
            (-3e-4 if touching else 0.02 * max(0.5 - t, 0.0),) * COUNT,
            (float(PRESS_N(np.array(t - CONTACT_S))) if touching else 0.0,) * COUNT,
            (noise.tobytes() if k % 5 < 2 else None,) * COUNT,
            (spoiled(t, reading) if k % 5 == 0 else None,) * COUNT,
            None,
        )
        hand.step(t, x, 0.0)
        events.step(sensed)
        finger.step(sensed)
        thermal = finger.thermal
        touches.append(
            Touched(finger.row, finger.contact, thermal.answer, thermal.measuring, thermal.no_differences, events.new)
        )
        thermal.own.work()
    return touches


def on(name: str) -> Callable[[float], float]:
    """Readings of a plate at 33 C that meets a material at CONTACT_S."""
    (touch,) = made_touches(name, 1, seed=4)
    return lambda t: float(touch.sensor_c[min(max(round(100 * t), 0), len(touch.sensor_c) - 1)])


def warm(preheat_k: float = OFFSETS_K[0]) -> Callable[[float], float]:
    """Readings of a plate that meets something as warm as it is."""
    rng = np.random.default_rng(0)
    return lambda t: float(measured(np.array([AMBIENT_C + preheat_k]), MADE_SENSOR, rng)[0])


def test_a_tap_is_an_event_with_its_speed(knowledge: ThermalKnowledge) -> None:
    touches = explore(knowledge, warm(), seconds=1.5)
    taps = [event for touch in touches for event in touch.events if event.kind is EventKind.TAP]
    assert [event.value for event in taps] == pytest.approx([0.02], abs=0.005)


def test_a_plate_is_used_in_contact_and_not_before(knowledge: ThermalKnowledge) -> None:
    touches = explore(knowledge, lambda t: 25.0 + 0.1 * np.sin(50.0 * t), seconds=1.5)
    assert not touches[100].measuring
    assert touches[250].contact
    assert touches[-1].contact
    used = [k for k, touch in enumerate(touches) if touch.measuring]
    assert used == list(range(250, len(touches)))


@pytest.mark.long
@pytest.mark.parametrize("preheat_k", sorted({OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K}))
def test_an_object_as_warm_as_the_plate_asks_for_another_preheat(knowledge: ThermalKnowledge, preheat_k: float) -> None:
    touches = explore(knowledge, warm(preheat_k))
    answer = touches[2000].thermal
    assert (answer.status, answer.reason) == (ThermalStatus.UNIDENTIFIABLE, ThermalReason.NO_DIFFERENCE)
    assert touches[2000].row.conductivity_w_mk == 0.0
    assert touches[-1].no_differences == 1
    assert touches[-1].thermal.status is ThermalStatus.NO_CONTACT


def test_a_plate_that_reads_always_the_same_is_a_fault_and_asks_for_nothing(knowledge: ThermalKnowledge) -> None:
    touches = explore(knowledge, lambda t: 33.0)
    assert touches[2000].thermal.reason is ThermalReason.READING_STUCK
    assert touches[-1].no_differences == 0


@pytest.mark.long
def test_stroking_ends_the_thermal_touch(knowledge: ThermalKnowledge) -> None:
    touches = explore(knowledge, on("plastic"), stroke_from=0.65)
    assert touches[2000].row.mode is ExplorationMode.STROKING
    assert touches[2000].thermal.reason is ThermalReason.STROKED


@pytest.mark.long
def test_a_sensor_fault_ends_the_thermal_touch(knowledge: ThermalKnowledge) -> None:
    touches = explore(knowledge, on("metal"), fault=ThermalReason.SENSOR_OPEN)
    assert touches[2000].thermal.reason is ThermalReason.SENSOR_OPEN


def test_a_touch_of_a_faulty_sensor_says_what_is_wrong_with_it(knowledge: ThermalKnowledge) -> None:
    """Its contact is found between two readings."""

    def faulty(t: float, reading: PlateReading) -> PlateReading | None:
        return None if 0.495 < t < 0.525 else structs.replace(reading, fault=ThermalReason.SENSOR_OPEN.code)

    touches = explore(knowledge, on("metal"), seconds=1.5, spoiled=faulty)
    assert {touch.thermal.reason for touch in touches if touch.contact} == {ThermalReason.SENSOR_OPEN}


def short(t: float, reading: PlateReading) -> PlateReading:
    """One shorted reading, 0.1 s before contact."""
    code = ThermalReason.SENSOR_SHORTED.code
    return PlateReading(-50.0, AMBIENT_C, code, reading.device_us, 0) if abs(t - 0.4) < 1e-6 else reading


def silent(t: float, reading: PlateReading) -> PlateReading | None:
    """Silence before contact, in which the plate has cooled by 3 K."""
    if t < 0.1:
        return PlateReading(reading.sensor_c + 3.0, AMBIENT_C, "", reading.device_us, 0)
    return None if t < 0.35 else reading


@pytest.mark.parametrize("spoiled", [short, silent])
def test_a_touch_starts_from_sound_readings_without_a_gap(
    knowledge: ThermalKnowledge, spoiled: Callable[[float, PlateReading], PlateReading | None]
) -> None:
    sound = explore(knowledge, on("stone"), seconds=2.0)[-1].thermal
    found = explore(knowledge, on("stone"), seconds=2.0, spoiled=spoiled)[-1].thermal
    assert (found.best, found.reason) == (sound.best, ThermalReason.NONE)
    assert found.object_c == pytest.approx(sound.object_c, abs=0.3)


@pytest.mark.parametrize(
    ("ambient_c", "reason"), [(-50.0, ThermalReason.SENSOR_SHORTED), (150.0, ThermalReason.SENSOR_OPEN)]
)
def test_a_broken_ambient_thermometer_is_a_fault_of_the_sensor(
    knowledge: ThermalKnowledge, ambient_c: float, reason: ThermalReason
) -> None:
    def spoiled(_: float, reading: PlateReading) -> PlateReading:
        return PlateReading(reading.sensor_c, ambient_c, "", reading.device_us, 0)

    found = explore(knowledge, on("stone"), seconds=2.0, spoiled=spoiled)[-1].thermal
    assert (found.status, found.reason, found.object_c) == (ThermalStatus.UNIDENTIFIABLE, reason, None)


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_general_constants_come_before_the_name_of_the_material_and_its_own_after(
    rendered_knowledge: ThermalKnowledge, name: str
) -> None:
    touches = explore(rendered_knowledge, on(NAMES[name]), seconds=6.5, lift_s=6.2)
    named = [touch for touch in touches if touch.thermal.material is not None]
    assert {touch.thermal.material for touch in named} == {name}
    materials = [event for touch in touches for event in touch.events if event.kind is EventKind.MATERIAL]
    assert [event.name for event in materials] == [name]

    def constants(touch: Touched) -> tuple[float, float, float]:
        return touch.row.conductivity_w_mk, touch.row.density_kg_m3, touch.row.specific_heat_j_kgk

    def effusivity(touch: Touched) -> float:
        return float(np.sqrt(np.prod(constants(touch))))

    before = touches[round(500 * (CONTACT_S + 0.5))]
    assert before.thermal.effusivity is not None
    assert effusivity(before) > 0.0
    if before.thermal.material is None:
        assert effusivity(before) == pytest.approx(before.thermal.effusivity, rel=1e-6)
    assert len({constants(touch) for touch in named}) == 1


def stroked(
    finger: FingerIdentification,
    hand: HandMotion,
    events: TouchEvents,
    made: StrokeTrace,
    x_m: NDArray[np.float64],
    counts: NDArray[np.signedinteger[Any]],
) -> Iterator[None]:
    """Step a finger over a stroke, in chunks of ten samples at these places, m; pause after each chunk."""
    for first in range(0, len(counts) - 9, 10):
        t_s, x, force_n = float(made.time_s[first + 9]), float(x_m[first + 9]), float(made.force_n[first + 9])
        chunk = (counts[first : first + 10].tobytes(),) * COUNT
        sensed = SensorFrame(t_s, x, 0.0, (0.0,) * COUNT, (force_n,) * COUNT, chunk, (None,) * COUNT, None)
        hand.step(t_s, x, 0.0)
        events.step(sensed)
        finger.step(sensed)
        yield


def test_no_distance_of_grooves_spans_a_fault_of_the_sensor(knowledge: ThermalKnowledge) -> None:
    stroke = simulate_stroke("widely_grooved_pvc", 7, 80.0, 1.0, length_m=0.07)
    counts = (stroke.pressure_v / VOLTS_PER_COUNT).round().astype("<i2")
    middle = len(counts) // 2
    counts[middle : middle + 40] = 2047
    x_m = np.cumsum(1e-3 * stroke.speed_mm_s) / 2000.0
    hand, events = HandMotion(), TouchEvents()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    grooves, faulty = 0, False
    for _ in stroked(finger, hand, events, stroke, x_m, counts):
        grooves += sum(event.kind is EventKind.GROOVE for event in events.new)
        faulty = faulty or finger.texture_fault is not None
    assert faulty
    assert grooves > 3
    assert finger.period.estimate() is None, "each side of the fault has too few grooves for a period"


def test_no_distance_of_grooves_spans_lost_samples(knowledge: ThermalKnowledge) -> None:
    stroke = simulate_stroke("widely_grooved_pvc", 7, 50.0, 1.0, length_m=0.2)
    counts = (stroke.pressure_v / VOLTS_PER_COUNT).round().astype("<i2")
    x_m = np.cumsum(1e-3 * stroke.speed_mm_s) / 2000.0
    hand, events = HandMotion(), TouchEvents()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    period = None
    for first in range(0, len(counts) - 9, 10):
        last = first + 9
        t_s, x, force_n = float(stroke.time_s[last]), float(x_m[last]), float(stroke.force_n[last])
        chunk = None if first % 450 < 40 else counts[first : last + 1].tobytes()  # 20 of 225 ms are lost
        sensed = SensorFrame(t_s, x, 0.0, (0.0,) * COUNT, (force_n,) * COUNT, (chunk,) * COUNT, (None,) * COUNT, None)
        hand.step(t_s, x, 0.0)
        events.step(sensed)
        finger.step(sensed)
        period = finger.period.estimate() or period
    assert period is not None
    assert period.period_m == pytest.approx(0.008, rel=0.01)


@pytest.mark.parametrize("broken", ["silent", "saturated"])
def test_nothing_is_known_of_the_surface_without_the_sensor(knowledge: ThermalKnowledge, broken: str) -> None:
    stroke = simulate_stroke("closely_grooved_pvc", 7, 80.0, 1.0, length_m=0.1)
    counts = (stroke.pressure_v / VOLTS_PER_COUNT).round().astype("<i2")
    x_m = np.cumsum(1e-3 * stroke.speed_mm_s) / 2000.0
    hand, events, summaries = HandMotion(), TouchEvents(), TouchSummaries()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    shown = []
    for first in range(0, len(counts) * 2 // 3, 10):
        last = first + 9
        t_s, x, force_n = float(stroke.time_s[last]), float(x_m[last]), float(stroke.force_n[last])
        chunk: bytes | None = counts[first : last + 1].tobytes()
        if first > len(counts) // 2:
            chunk = None if broken == "silent" else np.full(10, 2047, "<i2").tobytes()
        sensed = SensorFrame(t_s, x, 0.0, (0.0,) * COUNT, (force_n,) * COUNT, (chunk,) * COUNT, (None,) * COUNT, None)
        hand.step(t_s, x, 0.0)
        events.step(sensed)
        finger.step(sensed)
        summaries.step(t_s, {FINGER: finger})
        shown.append(summaries.summaries[FINGER])
    before = shown[len(shown) * 3 // 4 - 2]
    assert before.roughness_v is not None
    assert before.groove_m is not None
    assert finger.contact
    assert (shown[-1].roughness_v, shown[-1].groove_m) == (None, None)


@pytest.mark.parametrize(
    ("surface", "then", "known"),
    [
        ("closely_grooved_pvc", None, True),
        ("closely_grooved_pvc", "plain_pvc", False),
        ("arbitrarily_grooved_pvc", None, False),
    ],
)
def test_a_period_is_shown_on_regular_grooves_only(
    knowledge: ThermalKnowledge, surface: str, then: str | None, known: bool
) -> None:
    made = simulate_stroke(surface, 7, 80.0, 1.0, length_m=0.14, then=then)
    counts = (made.pressure_v / VOLTS_PER_COUNT).round().astype("<i2")
    x_m = np.cumsum(1e-3 * made.speed_mm_s) / 2000.0
    hand, events, summaries = HandMotion(), TouchEvents(), TouchSummaries()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    grooves, shown_m = 0, []
    for number, _ in enumerate(stroked(finger, hand, events, made, x_m, counts)):
        grooves += sum(event.kind is EventKind.GROOVE for event in events.new)
        summaries.step(float(made.time_s[10 * number + 9]), {FINGER: finger})
        if finger.mode is ExplorationMode.STROKING:
            shown_m.append(summaries.summaries[FINGER].groove_m)
    assert grooves > 10
    assert (shown_m[-1] is not None) is known
    if known:
        assert shown_m[-1] == pytest.approx(0.002, rel=0.01)


def test_the_way_around_a_turn_is_no_distance_of_grooves(knowledge: ThermalKnowledge) -> None:
    made, direction = to_and_fro("widely_grooved_pvc", 0.012, 12)
    counts = (made.pressure_v / VOLTS_PER_COUNT).round().astype("<i2")
    x_m = np.cumsum(direction * 1e-3 * made.speed_mm_s) / 2000.0
    hand, events = HandMotion(), TouchEvents()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    for _ in stroked(finger, hand, events, made, x_m, counts):
        pass
    period = finger.period.estimate()
    assert period is not None
    assert not period.irregular
    assert period.period_m == pytest.approx(0.008, rel=0.02)


def test_a_force_sensor_with_an_offset_identifies_the_same_stiffness(knowledge: ThermalKnowledge) -> None:
    hand, events = HandMotion(), TouchEvents()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    for k in range(round(500 * 2.4)):
        t_s = 0.002 * k
        z_m = float(np.interp(t_s, [0.8, 1.3, 1.6], [10e-3, 0.5e-3, -1.5e-3]))
        force_n = 0.08 + max(0.0, -1000.0 * z_m)
        sensed = SensorFrame(t_s, 0.0, 0.0, (z_m,) * COUNT, (force_n,) * COUNT, (None,) * COUNT, (None,) * COUNT, None)
        hand.step(t_s, 0.0, 0.0)
        events.step(sensed)
        finger.step(sensed)
    assert finger.surface.known
    assert finger.row.stiffness_n_m == pytest.approx(1000.0, rel=0.05)


@pytest.mark.parametrize("offset_n", [0.0, 0.25])
def test_a_force_sensor_with_an_offset_gives_the_same_roughness(knowledge: ThermalKnowledge, offset_n: float) -> None:
    made = simulate_stroke("sandpaper", 7, 80.0, 1.0, length_m=0.07)
    counts = (made.pressure_v / VOLTS_PER_COUNT).round().astype("<i2")
    x_m = np.cumsum(1e-3 * made.speed_mm_s) / 2000.0
    z_m = np.interp(made.time_s, [0.0, 0.3], [10e-3, 0.0])
    hand, events = HandMotion(), TouchEvents()
    finger = FingerIdentification(FINGER, knowledge, SURFACES, hand, events)
    for first in range(0, len(counts) - 9, 10):
        last = first + 9
        t_s, x, z = float(made.time_s[last]), float(x_m[last]), float(z_m[last])
        force_n = offset_n + float(made.force_n[last])
        chunk = (counts[first : last + 1].tobytes(),) * COUNT
        sensed = SensorFrame(t_s, x, 0.0, (z,) * COUNT, (force_n,) * COUNT, chunk, (None,) * COUNT, None)
        hand.step(t_s, x, 0.0)
        events.step(sensed)
        finger.step(sensed)
        if finger.roughness is not None:
            roughness_v = finger.roughness[0]
    assert roughness_v == pytest.approx(0.156, rel=0.03)

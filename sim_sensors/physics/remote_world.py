"""Simulate the remote world of one session: five fingers of a robot hand over a bench of objects.

The world is pure physics. Only `step` advances it, on simulated time. All randomness comes from the seed.
For constants and simplifications see docs/decisions/0002-simulated-world.md.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGER_Y_M, FINGERS
from common.scenes.scene import BENCH_M, Scene
from sim_sensors.physics.bench import Bench, BenchObject
from sim_sensors.physics.fingertip import HIGH_Z_M, Fingertip
from sim_sensors.physics.hand_servo import follow
from sim_sensors.physics.plate_travel import PlateTravel
from sim_sensors.physics.surface import GROOVE_DEPTH_M
from sim_sensors.physics.texture_touch import NOISE_V, TextureTouch
from sim_sensors.physics.thermal_touch import STEP_S, SensorSpread, ThermalTouch, draw_touch_factor
from sim_sensors.physics.thermistor_contacts import ThermistorContacts
from sim_sensors.physics.true_mode import CONTACT_N, TrueMode

HOVER_M = 0.006
"""Height of the fingers above the bench at the start, m."""
FORCE_NOISE_N = 0.01
_ROWS = 256
"""Number of rows of noise drawn at once."""
_FREE = -1


@dataclass(frozen=True, slots=True)
class TruthEvent:
    """A true event at a finger, from noise-free motion.

    `finger` is an index into FINGERS. `mode` is the true mode (0 free, 1 tapping, 2 quiescent, 3 stroking).
    `approach_m_s` is the finger's downward speed at the last contact.
    """

    time_s: float
    finger: int
    kind: Literal["contact", "release", "groove"]
    object: str
    object_c: float
    material: str
    approach_m_s: float
    mode: int


class RemoteWorld:
    """Objects, robot hand and the sensors on its fingers; arrays always have five elements, in the order of FINGERS.

    Each `step` updates `time_s`, the hand's position `x_m`, `y_m`, its speed along the bench `speed_m_s`, the
    fingertip heights `z_m`, the true forces `force_n` and the measured ones `measured_force_n`. It also updates the
    truth: `mode`, `object_index` (-1: no object) and `plate_c`. The lists `heights_m`, `forces_n` and `read_n` hold
    the numbers of `z_m`, `force_n` and `measured_force_n`.
    """

    def __init__(
        self,
        scene: Scene,
        seed: int,
        fingers: tuple[str, ...] = FINGERS,
        *,
        texture_noise_v: float = NOISE_V,
        groove_depth_m: float = GROOVE_DEPTH_M,
    ) -> None:
        """Draw the random properties of a session.

        Args:
            scene: the objects on the bench.
            seed: source of all randomness; the same seed gives the same world, independent of the hand's actions.
            fingers: the fingers that take part; the others stay up and touch nothing.
            texture_noise_v: noise of the texture sensors, rms, V.
            groove_depth_m: depth of all grooves, m.

        Raises:
            ValueError: a name that is not in FINGERS.
        """
        strangers = set(fingers) - set(FINGERS)
        if strangers:
            raise ValueError(f"unknown finger {sorted(strangers)[0]!r}; known: {', '.join(FINGERS)}")
        bench_rng, sensor_rng, thermal_rng, texture_rng, self._touch_rng, force_rng = (
            np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(6)
        )
        count = len(FINGERS)
        self.scene = scene
        self.bench = Bench(scene, bench_rng, groove_depth_m)
        self._present = tuple(name in fingers for name in FINGERS)
        self._thermal = ThermalTouch(SensorSpread.draw(count, sensor_rng), scene.ambient_c, thermal_rng)
        self._texture = TextureTouch(count, self.bench.heights_m, self.bench.slopes, texture_rng, texture_noise_v)
        self._fingers = [finger for finger, here in enumerate(self._present) if here]
        self._tips = [Fingertip(HOVER_M if here else HIGH_Z_M) for here in self._present]
        self._truth = [TrueMode() for _ in FINGERS]
        self._below = [_FREE] * count
        self._touched = [_FREE] * count
        self._warmed = [_FREE] * count
        """Object that each finger touched last, -1: none; a new touch there meets the heat left by the finger."""
        self._factor = [1.0] * count
        self._events: list[TruthEvent] = []
        self._ground = PlateTravel()
        self._thermal_due_s = 0.0
        self._velocity = (0.0, 0.0)
        self.shift_m = (0.0, 0.0, 0.0)
        """Movement of the objects with the patient along x, y and z, m; the relief of their surface stays."""
        self.time_s = 0.0
        self.x_m = 0.0
        self.y_m = 0.0
        self.speed_m_s = 0.0
        self.heights_m = [tip.z_m for tip in self._tips]
        self.forces_n = self.read_n = [0.0] * count
        self._force_noise = normal_rows(force_rng, count)
        self._lay_tracks()

    @property
    def z_m(self) -> NDArray[np.float64]:
        """Heights of the fingertips, m."""
        return np.array(self.heights_m)

    @property
    def force_n(self) -> NDArray[np.float64]:
        """True contact forces, N."""
        return np.array(self.forces_n)

    @property
    def measured_force_n(self) -> NDArray[np.float64]:
        """Measured contact forces, N."""
        return np.array(self.read_n)

    @property
    def mode(self) -> NDArray[np.int64]:
        """True mode of each finger."""
        return np.array([truth.mode for truth in self._truth], dtype=np.int64)

    @property
    def object_index(self) -> NDArray[np.int64]:
        """Index of the object that each finger touches, -1: none."""
        return np.array(self._touched, dtype=np.int64)

    @property
    def plate_c(self) -> NDArray[np.float64]:
        """True temperatures of the sensors' plates, C."""
        return self._thermal.plate_c

    @property
    def thermistor_contacts(self) -> ThermistorContacts:
        """Contacts of the sensors' resistors with their plates."""
        return self._thermal.contacts

    def step(
        self,
        dt_s: float,
        setpoint_x_m: float,
        setpoint_y_m: float,
        setpoint_z_m: NDArray[np.float64],
        heater_drive: NDArray[np.float64],
    ) -> None:
        """Advance by `dt_s` (2 ms at 500 Hz; up to 10 ms) with constant set-points.

        Args:
            dt_s: time to advance, s.
            setpoint_x_m: wanted hand x, m; held within the bench.
            setpoint_y_m: wanted hand y, m; held within the bench.
            setpoint_z_m: wanted fingertip heights (5,), m.
            heater_drive: Peltier drives (5,), -1..1.

        Raises:
            ValueError: `dt_s` out of range or a set-point that is not finite.
        """
        heights: list[float] = setpoint_z_m.tolist()
        if not 0.0 < dt_s <= STEP_S:
            raise ValueError(f"dt_s must be in (0, {STEP_S}] s, not {dt_s}")
        if not math.isfinite(setpoint_x_m + setpoint_y_m + sum(heights) + sum(heater_drive.tolist())):
            raise ValueError("set-points and heater drives must be finite")
        before_x, before_s = self.x_m, self.time_s
        self.time_s += dt_s
        self._move_hand(dt_s, setpoint_x_m, setpoint_y_m)
        self._move_fingers(dt_s, heights)
        self._observe(before_x, before_s)
        self._conduct(dt_s, heater_drive)

    def take_texture_counts(self) -> NDArray[np.int16]:
        """Return new texture samples, (5, m) counts at 2 kHz, +-2048 = +-10 V; m is a multiple of 10."""
        return self._texture.take_counts()

    def ssr_counts(self) -> NDArray[np.int16]:
        """Return the latest readings of the plates' resistors, (5,) counts 0..4095; new every 10 ms."""
        return self._thermal.ssr_counts()

    def ambient_counts(self) -> NDArray[np.int16]:
        """Return the latest readings of the ambient sensors, (5,) counts 0..4095."""
        return self._thermal.ambient_counts()

    def take_events(self) -> list[TruthEvent]:
        """Return the true events since the last call, in order of time."""
        events, self._events = self._events, []
        return events

    def _move_hand(self, dt_s: float, target_x_m: float, target_y_m: float) -> None:
        vx, vy = self._velocity
        self.x_m, vx = follow(dt_s, self.x_m, vx, min(max(target_x_m, -BENCH_M), BENCH_M))
        self.y_m, vy = follow(dt_s, self.y_m, vy, min(max(target_y_m, -BENCH_M), BENCH_M))
        self._velocity = (vx, vy)
        self.speed_m_s = math.hypot(vx, vy)

    def _move_fingers(self, dt_s: float, heights: list[float]) -> None:
        """Move the fingers that take part, and give the texture sensors their present state."""
        bench, belows, moved = self.bench, self._below, False
        dx_m, dy_m, dz_m = self.shift_m
        x_m = self.x_m - dx_m
        for finger in self._fingers:
            tip, before = self._tips[finger], belows[finger]
            y_m = self.y_m + FINGER_Y_M[finger] - dy_m
            index = bench.find(x_m, y_m, before)
            if index != before:
                belows[finger], moved = index, True
            if index == _FREE:
                tip.step(dt_s, heights[finger], 0.0, 0.0)
            elif (bed := bench.objects[index].bed) is not None:
                surface_m, stiffness_n_m = bed.under(self.time_s, x_m, y_m, tip.z_m - dz_m, self._velocity)
                tip.step(dt_s, heights[finger], surface_m + dz_m, stiffness_n_m)
            else:
                below = bench.objects[index]
                tip.step(dt_s, heights[finger], below.surface_z_m + dz_m, below.stiffness_n_m)
            touched = index if tip.force_n > 0.0 else _FREE
            if touched != self._touched[finger]:
                self._change_object(finger, touched)
        if moved:
            self._lay_tracks()
        self.heights_m = [tip.z_m for tip in self._tips]
        self.forces_n = forces = [tip.force_n for tip in self._tips]
        noise = next(self._force_noise)
        self.read_n = [force + FORCE_NOISE_N * by for force, by in zip(forces, noise, strict=True)]
        gain, track, origin = self._tracks
        self._texture.step(self.time_s, self.x_m, force_n=forces, gain=gain, track=track, origin_m=origin)

    def _lay_tracks(self) -> None:
        """Find the profiles below the texture sensors: gain, start in `Bench.heights_m`, and x of that start."""
        gain, track, origin = [0.0] * len(FINGERS), [0] * len(FINGERS), [0.0] * len(FINGERS)
        for finger, index in enumerate(self._below):
            if index != _FREE:
                below = self.bench.objects[index]
                gain[finger], track[finger], origin[finger] = below.relief_per_m, below.track[finger], below.low_x_m
        self._tracks = gain, track, origin

    def _change_object(self, finger: int, index: int) -> None:
        """Set the object that the thermal sensor touches; a new contact draws a new conductance."""
        before = self._touched[finger]
        self._touched[finger] = index
        if index == _FREE:
            self._thermal.release(finger)
            return
        if before == _FREE:
            self._factor[finger] = draw_touch_factor(self._touch_rng)
        touched = self.bench.objects[index]
        conductance = touched.conductance_w_m2k * self._factor[finger]
        self._thermal.touch(finger, touched.column, touched.object_c, conductance, touched.area_share)
        if before == _FREE and index != self._warmed[finger]:
            self._thermal.settle(finger)
        self._warmed[finger] = index

    def _observe(self, before_x_m: float, before_s: float) -> None:
        """Update the true modes, and record contacts and crossed grooves."""
        for finger in self._fingers:
            truth, force_n = self._truth[finger], self.forces_n[finger]
            was = truth.contact
            if not was and force_n < CONTACT_N:
                continue
            truth.step(self.time_s, force_n, self.x_m, self.y_m, self.speed_m_s)
            below = self._below[finger]
            if truth.contact != was:
                self._add(self.time_s, finger, "contact" if truth.contact else "release")
            elif was and below != _FREE and self.bench.objects[below].grooves_x_m:
                self._cross_grooves(finger, self.bench.objects[below], before_x_m, before_s)

    def _cross_grooves(self, finger: int, below: BenchObject, before_x_m: float, before_s: float) -> None:
        grooves = below.grooves_x_m
        start, end = bisect_right(grooves, before_x_m), bisect_right(grooves, self.x_m)
        if start == end:
            return
        crossed = grooves[start:end] if start < end else grooves[end:start][::-1]
        for groove in crossed:
            part = (groove - before_x_m) / (self.x_m - before_x_m)
            self._add(before_s + part * (self.time_s - before_s), finger, "groove")

    def _add(self, time_s: float, finger: int, kind: Literal["contact", "release", "groove"]) -> None:
        """Record an event; a finger that slid off an edge has no object at its release."""
        index = self._below[finger]
        below = None if index == _FREE else self.bench.objects[index]
        self._events.append(
            TruthEvent(
                time_s,
                finger,
                kind,
                below.name if below else "",
                below.object_c if below else self.scene.ambient_c,
                below.material if below else "air",
                self._tips[finger].approach_m_s,
                self._truth[finger].mode,
            )
        )

    def _conduct(self, dt_s: float, heater_drive: NDArray[np.float64]) -> None:
        self._ground.move(self.x_m, self.y_m)
        self._thermal_due_s += dt_s
        if self._thermal_due_s >= STEP_S - 1e-9:
            self._thermal_due_s -= STEP_S
            speed_m_s = self._ground.take_speed_m_s(STEP_S)
            self._thermal.step(np.where(self._present, heater_drive, 0.0), self.force_n, speed_m_s)


def normal_rows(rng: np.random.Generator, count: int) -> Iterator[list[float]]:
    """Yield rows of `count` standard normal numbers without end, as one draw for each row gives them.

    Nothing else may draw from `rng`.
    """
    while True:
        yield from rng.standard_normal((_ROWS, count)).tolist()

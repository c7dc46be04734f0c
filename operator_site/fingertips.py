"""Renders force, vibration and heat at the operator's five fingertips from the remote site's touch.

Runs at the site's rate (500 Hz; heat at 100 Hz). The results are requests, which the gate limits before they reach
the devices.
"""

import math
from collections.abc import Sequence

from common.config.site_models import VibrationScale
from common.fingers import FINGERS
from common.limits import COMFORT, GAP_S, PlateRange
from common.scenes.materials import materials
from common.wire.messages import NO_TOUCH, OBJECT_UNKNOWN_SD_K, Event, EventKind, TouchRow
from operator_site.coupling.coupling import DIRECT, Coupling
from operator_site.force.coupled_contact import ForceCeiling, WorkspaceEdge
from operator_site.force.passive_contact import PassiveContact
from operator_site.safety.gated_output import Outputs
from operator_site.safety.limit_flags import Limit
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.contact_prediction import LEAD_S, ContactPrediction, contact_c, contact_in_s
from operator_site.thermal.plates import PlateController, PlateSetpoint
from operator_site.thermal.scene_skin import SceneSkin, SkinState, prepare, touched_object
from operator_site.thermal.skin_model import STEP_S, Touched
from operator_site.thermal.tissue import Body
from operator_site.vibration.grooves import GrooveTiming
from operator_site.vibration.vibration import FingerVibration, PlayedEvents

NEAR_SURFACE_M = 0.3e-3
"""Height above the remote surface below which a finger counts as touching for heat, m; allows for height errors."""

PLANE_REACHES_M = 1e-3
"""Largest extrapolated rise or fall of a sloping surface from the place where it was measured, m; surfaces bend."""

MOST_STEPS = 10
"""Maximum number of skin steps in one tick, 0.1 s.

After a longer standstill the outputs are neutral, and the skin continues from its state without catching up.
"""

LATEST_TAP_S = 0.2
"""Longest delay of a tap that arrived while the outputs were at rest, s; a later one is not displayed.

On a busy machine the outputs rest for some milliseconds when a device's reading is late.
"""

_STIFFNESS_LIMIT = Limit.STIFFNESS.value


class Fingertips:
    """Renders touch for five fingertips."""

    def __init__(
        self,
        wall: SampledWall,
        profile: PlateRange = COMFORT,
        body: Body | None = None,
        vibration: VibrationScale = "speed",
    ) -> None:
        """Begin at rest; `wall` is the bound of the walls that the exoskeleton can display passively."""
        n = len(FINGERS)
        self._wall = wall
        self._contacts = [PassiveContact(wall) for _ in range(n)]
        self._ceiling, self._edge = ForceCeiling(), WorkspaceEdge(wall)
        self._approaches = [ContactPrediction() for _ in range(n)]
        self._vibrations = [FingerVibration(vibration) for _ in range(n)]
        self._played = PlayedEvents()
        self._groove_timing = GrooveTiming()
        self._skin = SceneSkin(body=body)
        prepare(materials().values(), self._skin.body.air_w_m2k)
        self.skin: SkinState = self._skin.state()
        """State of the skin model, for display and recording."""
        self._display = PlateSetpoint(profile, self.skin.surface_c)
        self._loops = [PlateController() for _ in range(n)]
        self._drive = [0.0] * n
        self._touching = [False] * n
        self._contact_in_s = [math.inf] * n
        self._driven = [False] * n
        self._t_s = math.nan
        self._heat_t_s = math.nan
        self._surface_m = [0.0] * n
        self._rows: Sequence[TouchRow] = (NO_TOUCH,) * n
        self._objects: list[Touched | None] = [None] * n
        self._events: Sequence[Event] = ()
        self._taps: dict[int, tuple[float, Event]] = {}
        """Last tap of each finger that arrived while the outputs were at rest, with the time of its arrival, s."""
        self.impulses_played: list[Event] = []
        """Taps and grooves that began in the last step; their packet may be an earlier one."""

    def begin_session(self) -> None:
        """Forget the played events, because a new session numbers its own."""
        self._played = PlayedEvents()
        self._events = ()
        self._taps.clear()
        self._ceiling.begin_session()

    def show(self, wall: SampledWall) -> None:
        """Set the bound of the walls; no stiffer surface is displayed from now on."""
        if wall is not self._wall:
            self._wall = wall
            for contact in self._contacts:
                contact.show(wall)
            self._edge.show(wall)

    def step(
        self,
        t_s: float,
        engaged: bool,
        *,
        rows: Sequence[TouchRow],
        events: Sequence[Event],
        speed_m_s: float,
        x_m: float,
        y_m: float,
        z_m: Sequence[float],
        pushed_n: Sequence[float],
        plate_c: Sequence[float],
        plate_age_s: Sequence[float],
        coupling: Coupling = DIRECT,
        hand_z_m: Sequence[float] = (),
    ) -> Outputs:
        """Return the requests of this tick; `limited` marks what plates and exoskeleton cannot display.

        Args:
            t_s: time on a steady clock, s.
            engaged: whether outputs act; otherwise the plate loops rest, taps wait and other events are discarded.
            rows: touch rows of the last accepted touch; pass the same object until there is a new one, as each object
                is read only once.
            events: events of the last packet, played or not.
            speed_m_s: commanded stroke speed, m/s.
            x_m, y_m: commanded place of the remote hand, m; with a direct coupling, the hand's place.
            z_m: commanded height of each fingertip, m.
            pushed_n: force that the gate let through to each finger since the last step, N.
            plate_c: last reading of each plate, C; NaN without one.
            plate_age_s: age of each reading, s; infinite for a plate that gets no drive.
            coupling: coupling of the hand, from which the commands follow.
            hand_z_m: height of each fingertip of the hand, m; not used with a direct coupling.
        """
        dt_s = t_s - self._t_s
        dt_s = dt_s if 0.0 < dt_s <= 0.1 else 0.0
        self._t_s = t_s
        if rows is not self._rows:
            self._rows = rows
            self._objects = [_object(row) for row in rows]
        fresh = self._fresh(t_s, engaged, events)
        self.impulses_played = []
        direct, ceiling = coupling.direct, self._ceiling
        if not direct:
            ceiling.step(dt_s, coupling.open, pushed_n)
        force, rpm = [], []
        for finger, row in enumerate(self._rows):
            height_m, stiffness_n_m = z_m[finger], row.stiffness_n_m
            approach_m_s = self._approaches[finger].step(t_s, height_m)
            surface_m = self._surface_m[finger] = _surface_below(row, x_m, y_m)
            contact = self._contacts[finger]
            if contact.force_n > pushed_n[finger]:
                contact.let_through(pushed_n[finger])
            if not engaged:
                contact.rest()
            if direct:
                newton = contact.step(t_s, height_m, surface_m, stiffness_n_m, row.damping_n_s_m, approach_m_s)
                force.append(newton)
            else:
                own_m, pushed = hand_z_m[finger], pushed_n[finger]
                newton = self._coupled(t_s, finger, row, own_m, surface_m, approach_m_s, coupling)
                wall_n = self._edge.step(t_s, finger, own_m, coupling, pushed, rests=not engaged or ceiling.released)
                force.append(max(newton, min(ceiling.force_n, wall_n)))
            # The displayed force sets the stroke's force; before a surface is known, the remote finger's force does.
            pressed, ahead_s = row.contact_force_n, math.inf
            if stiffness_n_m > 0.0:
                pressed, ahead_s = newton, contact_in_s(height_m - surface_m, approach_m_s)
            self._contact_in_s[finger] = ahead_s
            mine = [event for event in fresh if event.finger == finger] if fresh else ()
            speed = self._vibrations[finger].step(
                t_s,
                row.mode,
                speed_m_s,
                pressed,
                surface=row,
                events=mine,
                contact_in_s=ahead_s,
                approach_m_s=approach_m_s,
            )
            if mine and speed > 0.0:
                self.impulses_played += [event for event in mine if event.kind is not EventKind.MATERIAL]
            rpm.append(speed)
        set_c = self._plates(t_s, dt_s, engaged, z_m, plate_c, plate_age_s)
        limited = list(self._display.limited)
        for finger, contact in enumerate(self._contacts):
            if contact.capped:
                limited[finger] |= _STIFFNESS_LIMIT
        return Outputs(force, rpm, set_c, list(self._drive), limited)

    def _plates(
        self,
        t_s: float,
        dt_s: float,
        engaged: bool,
        z_m: Sequence[float],
        plate_c: Sequence[float],
        plate_age_s: Sequence[float],
    ) -> list[float]:
        """Return the plates' set-points, C; each skin step also updates the drives."""
        for finger, age_s in enumerate(plate_age_s):
            drives = engaged and age_s <= GAP_S
            if drives is not self._driven[finger]:
                self._driven[finger] = drives
                if drives:
                    self._display.restart(finger, plate_c[finger])
                    self._loops[finger].reset()
        due = self._heat_steps(t_s)
        heat = due > 0
        if heat:
            self._heat(z_m, due, plate_age_s)
        set_c = self._display.step(dt_s)
        if heat:
            load_w_m2 = self._display.load_w_m2()
            for finger, loop in enumerate(self._loops):
                fresh_c = plate_c[finger] if self._driven[finger] else math.nan
                self._drive[finger] = loop.step(t_s, set_c[finger], fresh_c, load_w_m2[finger])
        return set_c

    def _fresh(self, t_s: float, engaged: bool, events: Sequence[Event]) -> Sequence[Event]:
        """Return the events to play in this tick; taps wait while outputs do not act."""
        fresh: Sequence[Event] = ()
        if events is not self._events:
            self._events, fresh = events, self._played.new(events)
        if not engaged:
            self._groove_timing.clear()
            self._taps |= {event.finger: (t_s, event) for event in fresh if event.kind is EventKind.TAP}
            fresh = ()
        elif self._taps:
            fresh = [event for came_s, event in self._taps.values() if t_s - came_s <= LATEST_TAP_S] + list(fresh)
            self._taps.clear()
        if fresh or self._groove_timing.waits:
            fresh = self._groove_timing.step(t_s, fresh)
        return fresh

    def _coupled(
        self,
        t_s: float,
        finger: int,
        row: TouchRow,
        hand_m: float,
        surface_m: float,
        approach_m_s: float,
        coupling: Coupling,
    ) -> float:
        """Return the force of the surface on a finger of the hand, N, through its coupling.

        Args:
            t_s: time, s.
            finger: number of the finger.
            row: touch row of the remote finger.
            hand_m: height of the hand's finger, m.
            surface_m: height of the remote surface below the command, m.
            approach_m_s: smoothed speed of the command into the surface, m/s.
            coupling: coupling of the hand.
        """
        contact, n = self._contacts[finger], coupling.scale
        stiffness_n_m = row.stiffness_n_m / n
        if self._ceiling.released:  # a free hand meets no surface
            contact.rest()
            stiffness_n_m = 0.0
        height_m = coupling.hand_height_m(finger, surface_m)
        newton = contact.step(t_s, hand_m, height_m, stiffness_n_m, row.damping_n_s_m / n, approach_m_s * n)
        return min(self._ceiling.force_n, newton)

    def _heat_steps(self, t_s: float) -> int:
        """Return the number of due skin steps; after a standstill longer than MOST_STEPS only one is due."""
        since_s = t_s - self._heat_t_s
        if not 0.0 <= since_s < (MOST_STEPS + 1) * STEP_S:
            self._heat_t_s = t_s
            return 1
        steps = math.floor(since_s / STEP_S + 0.01)
        self._heat_t_s += steps * STEP_S
        return steps

    def _heat(self, z_m: Sequence[float], steps: int, plate_age_s: Sequence[float]) -> None:
        """Advance the skin of all fingers in the scene by a number of steps of 10 ms.

        Without drive a plate does not display the scene. A free finger on it is therefore at rest, so that the plate
        does not heat or cool it later for an earlier touch.
        """
        for finger, row in enumerate(self._rows):
            near = row.stiffness_n_m > 0.0 and z_m[finger] < self._surface_m[finger] + NEAR_SURFACE_M
            touched = None
            if near or row.contact > 0.0:
                touched = self._objects[finger]
            self._touching[finger] = touched is not None
            exact = row.effusivity_ln_sd == row.object_c_sd == 0.0
            self._skin.touch(finger, touched, row.object_c, exact=exact)
            if touched is None and plate_age_s[finger] == math.inf:
                self._skin.settle(finger)
        for _ in range(steps):
            self.skin = self._skin.step()
        self._display.aim(self.skin, self._touching, self._ahead_c())

    def _ahead_c(self) -> dict[int, float]:
        """Return the expected contact temperature, C, of each approaching finger whose plate must start now."""
        found = {}
        for finger, contact_s in enumerate(self._contact_in_s):
            if self._touching[finger] or contact_s > LEAD_S:
                continue
            touched = self._objects[finger]
            if touched is not None:
                goal_c = contact_c(self.skin.surface_c[finger], touched, self._rows[finger].object_c)
                if contact_s <= self._display.needs_s(finger, goal_c):
                    found[finger] = goal_c
        return found


def _object(row: TouchRow) -> Touched | None:
    """Return the object that a row describes; None if its material or its temperature is not known."""
    if row.object_c == 0.0 and row.object_c_sd >= OBJECT_UNKNOWN_SD_K:
        return None
    return touched_object(row.conductivity_w_mk, row.density_kg_m3, row.specific_heat_j_kgk)


def _surface_below(row: TouchRow, x_m: float, y_m: float) -> float:
    """Return the surface height, m, below the operator's hand, from the plane at the remote hand, which lags behind."""
    if row.slope_x == row.slope_y == 0.0:
        return row.surface_z_m
    rise_m = row.slope_x * (x_m - row.x_m) + row.slope_y * (y_m - row.y_m)
    return row.surface_z_m + min(PLANE_REACHES_M, max(-PLANE_REACHES_M, rise_m))

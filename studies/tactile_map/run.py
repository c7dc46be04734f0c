"""Tactile map: a sweep finds a warm spot, a rough lesion and a stiff nodule without knowing their places.

Five simulated fingers explore the scene `phantom_sweep` by its script. Sensors, identification and packets are those of
a session, on virtual time. The map is built from the packets as on the console. A target is found where the map stands
out most, and its value is the one identified nearest to that place. One plate cannot distinguish a warmer object from
one that takes less heat, so two fingers rest once more on the warm place.

In the scene `phantom_nodules`, five fingers press in rows, and the map outlines the hidden nodules.
"""

import math
from typing import Any

import numpy as np

from common.fingers import FINGER_Y_M, FINGERS, FingerName
from common.scenes.scene import Scene, SceneObject, load_scene
from common.scenes.script import Presses, Step, Strokes
from operator_site.console.map.map_tiles import CONFIDENT_SD, picture
from operator_site.console.map.tactile_map import TactileMap
from sim_sensors.operator_hand.hand import ScriptedHand
from sim_sensors.operator_hand.hand_plan import Segment
from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, results_of
from studies.running import Progress, tables_of
from teletaction.report.found_lumps import found_lumps
from teletaction.report.found_targets import Found, find_target, judged
from teletaction.testbed.remote_fingers import RemoteFingers
from teletaction.testbed.rendered_fingers import TICK_S

SCENE = "phantom_sweep"
TARGETS = {thing.name: thing for thing in load_scene(SCENE).objects if thing.target is not None}
SEEDS = 4
NODULES_SCENE, NODULES_SEEDS = "phantom_nodules", 5
SURE = 0.9
"""Probability from which on a nodule counts as found."""
WARM_UP_S = 3.0
"""Time before the first touch in which the sensors reach their pre-heat, s."""
PACKET_EVERY = 2
"""Ticks between two packets that the map takes; the link's deadband omits more packets than this."""
MEASURING: tuple[FingerName, ...] = ("thumb", "index")
MEASURED_S = 6.0
GOAL_M, GOAL_K, GOAL_SHARE = 5e-3, 0.5, 0.20
tables = tables_of("targets", "nodules")
COMPARED = (
    Compared("targets", "place_error_mm", "less", ("seed", "target"), absolute=1.0),
    Compared("targets", "within_goal", "more", ("seed", "target")),
    Compared("nodules", "probability", "more", ("seed", "nodule"), absolute=0.05),
    Compared("", "false_outlines", "less"),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Explore both scenes once if `quick`, else often; each session draws its own sensors, tissue and contacts."""
    pieces: dict[str, list[Piece]] = {
        "sweeps": [(_session, (quick, seed + number)) for number in range(1 if quick else SEEDS)],
        "palpations": [(_palpated, (seed + number,)) for number in range(1 if quick else NODULES_SEEDS)],
    }
    sessions, palpated = results_of(pieces, work, progress).values()
    rows = [row for session in sessions for row in session["targets"]]
    nodules = [row for session in palpated for row in session["nodules"]]
    return {
        "targets": rows,
        "nodules": nodules,
        "false_outlines": sum(session["false_outlines"] for session in palpated),
        "palpated_s": palpated[0]["seconds"],
        "seconds": sessions[-1]["seconds"],
        "maps": sessions[0]["maps"],
        "objects": {name: thing.model_dump() for name, thing in TARGETS.items()},
        "goals": {"place_m": GOAL_M, "temperature_k": GOAL_K, "stiffness_share": GOAL_SHARE},
        "problems": [_problem(row) for row in rows if not row["within_goal"]]
        + [
            f"seed {row['seed']}: the {row['nodule']} nodule has a probability of {row['probability']}"
            for row in nodules
            if (row["probability"] or 0.0) < SURE
        ],
    }


def _session(quick: bool, seed: int) -> dict[str, Any]:
    """Sweep once; return the found targets, the durations, and the maps before the second rest on the warm place."""
    scene = quick_scene() if quick else load_scene(SCENE)
    sweep = Sweep(scene, seed, MEASURING if quick else FINGERS)
    seconds, tactile = _durations(sweep.explore(scene.script)), sweep.map
    quantities = {name: str(thing.target) for name, thing in TARGETS.items()}
    found = {name: find_target(tactile, quantity) for name, quantity in quantities.items()}
    maps = {quantity: _shown(tactile, quantity) for quantity in quantities.values()}
    if (warm := found["warm_spot"]) is not None:
        sweep.measure(warm)
    rows = [{"seed": seed} | _judge(thing, tactile, found[name]) for name, thing in TARGETS.items()]
    return {"targets": rows, "seconds": seconds, "maps": maps}


def _palpated(seed: int) -> dict[str, Any]:
    """Palpate the scene with nodules; return a row for each nodule, the number of false outlines and the duration."""
    scene = load_scene(NODULES_SCENE)
    sweep = Sweep(scene, seed, FINGERS)
    seconds = _durations(sweep.explore(scene.script))["whole"]
    lumps = found_lumps(sweep.map, scene.nodules)
    nodules = [{"seed": seed} | lump for lump in lumps if lump["nodule"] is not None]
    return {"nodules": nodules, "false_outlines": len(lumps) - len(nodules), "seconds": seconds}


def quick_scene() -> Scene:
    """Return the scene with a script for the index finger that stays near the targets."""
    scene = load_scene(SCENE)
    script: tuple[Step, ...] = (
        Strokes(act="strokes", x_m=(-0.022, 0.022), y_m=(0.0215, 0.0265, 0.0315, 0.0365, 0.0415), speed_mm_s=40),
        Presses(act="presses", x_m=(0.011, 0.018, 0.025, 0.032), y_m=(0.001, 0.008, 0.015, 0.022), hold_s=0.6),
        Presses(
            act="presses",
            fingers=("index",),
            x_m=(-0.036, -0.022, -0.043, -0.029, -0.015),
            y_m=(0.003, 0.010, 0.017),
            hold_s=2.5,
            wait_s=1.5,
        ),
    )
    return scene.model_copy(update={"script": script})


class Sweep:
    """Simulated fingers that explore a scene by a script, and their map.

    Attributes:
        map: the map.
        time_s: virtual time.
    """

    def __init__(self, scene: Scene, seed: int, fingers: tuple[str, ...]) -> None:
        """Draw a session's sensors, tissue and contacts from the seed."""
        self.map, self.time_s = TactileMap(), 0.0
        self._scene, self._seed, self._fingers = scene, seed, fingers
        self._remote = RemoteFingers(scene, seed, fingers)

    def explore(self, script: tuple[Step, ...]) -> list[Segment]:
        """Wait for the pre-heat, run a script once, and return the hand's movements."""
        scene = self._scene.model_copy(update={"script": script})
        hand = ScriptedHand(scene, seed=self._seed, fingers=self._fingers)
        for _ in range(round(WARM_UP_S / TICK_S)):
            self._step(hand)
        hand.start()
        for _ in range(round(hand.total_seconds() / TICK_S)):
            self._step(hand)
        return hand.timeline()

    def measure(self, place: Found) -> None:
        """Rest on a place with two fingers in turn, whose plates have different temperatures."""
        presses = [
            Presses(
                act="presses",
                fingers=(finger,),
                x_m=(place.x_m,),
                y_m=(place.y_m - FINGER_Y_M[FINGERS.index(finger)],),
                hold_s=MEASURED_S,
                wait_s=WARM_UP_S,
            )
            for finger in MEASURING
            if finger in self._fingers
        ]
        self.explore(tuple(presses))

    def _step(self, hand: ScriptedHand) -> None:
        # The contact forces do not push the arm back.
        hand.step(TICK_S, np.zeros(len(FINGERS)))
        touch = self._remote.move(hand.x_m, hand.y_m, hand.z_m)
        self.time_s += TICK_S
        if round(self.time_s / TICK_S) % PACKET_EVERY == 0:
            self.map.add(self.time_s, touch.rows, touch.summaries)


def _durations(segments: list[Segment]) -> dict[str, float]:
    """Return the durations of strokes, presses and rests, s, in this order; only rests begin with a wait."""
    whole_s = segments[-1].start_s + segments[-1].duration_s
    strokes_s = max((s.start_s + s.duration_s for s in segments if s.act == "stroke"), default=0.0)
    rests_s = min((s.start_s for s in segments if s.act == "wait"), default=whole_s)
    return {"strokes": strokes_s, "presses": rests_s - strokes_s, "rests": whole_s - rests_s, "whole": whole_s}


def _judge(thing: SceneObject, tactile: TactileMap, found: Found | None) -> dict[str, Any]:
    row = judged(thing, tactile, found)
    good = row["value"] is not None and row["place_error_mm"] <= 1e3 * GOAL_M
    if row["quantity"] == "temperature":
        good = good and abs(row["error"]) <= GOAL_K
    elif row["quantity"] == "stiffness":
        good = good and abs(row["error"]) <= GOAL_SHARE * row["true_value"]
    return row | {"within_goal": good}


def _problem(row: dict[str, Any]) -> str:
    if row["value"] is None:
        return f"seed {row['seed']}: {row['target']} was not found"
    return (
        f"seed {row['seed']}: {row['target']} was found {row['place_error_mm']:.1f} mm from its place, "
        f"with {row['quantity']} {row['value']:.4g} instead of {row['true_value']}"
    )


def _shown(tactile: TactileMap, quantity: str) -> dict[str, Any] | None:
    """Return the map for the figure, with None for cells without a value; return None without a map."""
    whole = picture(tactile, quantity)
    if whole is None:
        return None
    return {
        "left_m": whole.left_m,
        "near_m": whole.near_m,
        "value": [[None if math.isnan(v) else round(v, 5) for v in line] for line in whole.value.tolist()],
        "confidence": whole.confidence.tolist(),
        "legend": tactile.legend(quantity),
        "confident_sd": CONFIDENT_SD[quantity],
    }

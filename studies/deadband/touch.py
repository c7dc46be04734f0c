"""Touch through a deadband: recorded forces by Weber fraction, and whole touch packets of five simulated fingers."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.link.deadband import TOUCH_STEPS, Deadband, touch_perceptible
from common.scenes.scene import load_scene
from sim_sensors.operator_hand.hand import ScriptedHand
from studies.touches.teleoperation import SCENE
from teletaction.testbed.remote_fingers import RemoteFingers
from teletaction.testbed.rendered_fingers import TICK_S

WEBER = (0.02, 0.05, 0.07, 0.10, 0.15, 0.20, 0.27)
"""Weber fractions tried; with the largest, people still work as well as without a deadband (Chaudhari et al. 2011)."""


def force_rows(forces_n: Sequence[NDArray[np.float64]], rate_hz: float) -> Iterator[dict[str, Any]]:
    """A row for each Weber fraction: share of packets sent, and largest error relative to the transmitted force.

    The least force step over the Weber fraction is a floor for that force.
    """
    least_n = TOUCH_STEPS["contact_force_n"].least
    for weber in WEBER:
        sent, off = 0, list[NDArray[np.float64]]()
        for force_n in forces_n:
            deadband, sent_n, held_n = Deadband(1.0 / rate_hz), np.nan, np.empty(len(force_n))
            for tick, newton in enumerate(force_n.tolist()):
                if deadband.step(tick / rate_hz, not abs(newton - sent_n) <= max(least_n, weber * sent_n)):
                    sent_n, sent = newton, sent + 1
                held_n[tick] = sent_n
            off.append(np.abs(held_n - force_n) / np.maximum(np.abs(held_n), least_n / weber))
        share = sent / sum(map(len, forces_n))
        yield {
            "rate_hz": rate_hz,
            "weber": weber,
            "sent_share": share,
            "largest_error": max(float(error.max()) for error in off),
        }


def touch_rows(seconds: float, seed: int) -> list[dict[str, Any]]:
    """Ticks and packets of five fingers at work on the scene, by the hand's act and in total."""
    scene = load_scene(SCENE)
    hand, remote = ScriptedHand(scene, seed=seed), RemoteFingers(scene, seed, FINGERS)
    hand.start()
    deadband, last = Deadband(TICK_S), None
    ticks, sent, news = Counter[str](), Counter[str](), Counter[str]()
    for tick in range(round(seconds / TICK_S)):
        hand.step(TICK_S, np.zeros(len(FINGERS)))
        touch = remote.move(hand.x_m, hand.y_m, hand.z_m)
        perceptible = last is None or touch_perceptible(last, touch)
        act = hand.segment.act
        ticks[act] += 1
        news[act] += perceptible
        if deadband.step(tick * TICK_S, perceptible):
            sent[act] += 1
            last = touch
    every = {"all": sum(ticks.values())} | ticks
    sent["all"], news["all"] = sent.total(), news.total()
    return [
        {"act": act, "ticks": count, "news": news[act], "sent": sent[act], "sent_share": sent[act] / count}
        for act, count in every.items()
    ]

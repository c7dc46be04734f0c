"""A simulated examiner: presses over a square, first lightly, then around the place that the patient reports.

Levels rise over the whole square until the first report of pain. Then all presses stay within the limit that follows
the patient. Rounds of presses around the estimated place find its centre. Where these do not find it, the examiner ends
the limit and continues, up to a number of presses.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from common.tenderness.tender_place import TenderPlace, tender_place
from remote_site.safety.pain_limit import PainLimit
from studies.tenderness.patients import REST_S, SIDE_M, Kind, Patient

LEVELS_N = (1.0, 1.4, 2.0, 2.8, 3.9, 5.0)
"""Forces of the passes over the square, N; the last is the default limit."""
AROUND_M = 0.005
"""Distance of the presses around a reported place, m."""
PLACE_ERROR_M = 0.0005
"""Standard deviation of the stated place of a press, m."""
MOST_PRESSES = 800
"""Number of presses after which the examiner gives up."""
SURE, SURE_M = 0.9, 0.003
"""Probability of the place, and standard deviation of its centre, m, at which the examiner stops the search."""


@dataclass(slots=True)
class Examination:
    """An examination so far.

    Attributes:
        limit: the force limit of the remote site.
        t_s: time, s.
        presses: number of presses.
        after, exceeded: number of presses after the first report, and of those above the threshold of the press.
        ended_limits: number of times that the examiner has ended the limit.
        reported: whether the patient has reported pain.
    """

    patient: Patient
    rng: np.random.Generator
    limit: PainLimit = field(default_factory=lambda: PainLimit(presses=10_000))
    t_s: float = 0.0
    presses: int = 0
    after: int = 0
    exceeded: int = 0
    ended_limits: int = 0
    reported: bool = False

    def press(self, x_m: float, y_m: float, level_n: float) -> bool:
        """Press at a place; return whether the patient has reported pain."""
        level_n = min(level_n, self.limit.limit_n)
        stated_x, stated_y = (x_m, y_m) + PLACE_ERROR_M * self.rng.standard_normal(2)
        pressed = self.patient.press(self.t_s, x_m, y_m, level_n)
        self.presses += 1
        if self.reported:
            self.after += 1
            self.exceeded += pressed.exceeded
        x, y = [float(stated_x)], [float(stated_y)]
        samples = (pressed.time_s.tolist(), pressed.force_n.tolist(), pressed.answer.tolist())
        for t_s, force_n, answer in zip(*samples, strict=True):
            self.limit.step(t_s, [force_n], x, y, answer)
        reported = bool(pressed.answer.any())
        self.reported = self.reported or reported
        self.t_s = float(pressed.time_s[-1]) + REST_S
        return reported

    def place(self) -> TenderPlace | None:
        """Return the most tender place."""
        return tender_place(self.limit.finder.presses, self.limit.reaction)


def examine(patient: Patient, kind: Kind, seed: int) -> Examination:
    """Examine a patient."""
    done = Examination(patient, np.random.default_rng([seed, 741]))
    for level_n in LEVELS_N:
        for x_m, y_m in _raster(kind.presses_a_side):
            if done.presses >= MOST_PRESSES:
                return done
            if done.press(x_m, y_m, level_n) and _found(done, kind.rounds):
                for place in _raster(kind.presses_a_side):
                    done.press(*place, LEVELS_N[-1])
                return done
    return done


def _found(done: Examination, rounds: int) -> bool:
    """Press around the reported place; return whether its centre is known, else end the limit."""
    for _ in range(rounds):
        around = done.place()
        if around is None:
            break
        if around.probability >= SURE and around.sd_m <= SURE_M:
            return True
        steps = AROUND_M * np.arange(-2, 3)
        for dx_m in steps:
            for dy_m in steps:
                x_m, y_m = (min(SIDE_M, max(0.0, at)) for at in (around.x_m + dx_m, around.y_m + dy_m))
                done.press(x_m, y_m, LEVELS_N[-1])
    done.limit.end()
    done.ended_limits += 1
    return False


def _raster(a_side: int) -> Iterator[tuple[float, float]]:
    line = np.linspace(0.0, SIDE_M, a_side)
    for row, y_m in enumerate(line):
        for x_m in line if row % 2 == 0 else line[::-1]:
            yield float(x_m), float(y_m)

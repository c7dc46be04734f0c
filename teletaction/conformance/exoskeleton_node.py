"""Duties of the exoskeleton alone: the forces that it applies, and their release."""

from common.fingers import FINGERS
from common.limits import FORCE_SAFE_S, MODULE_TIMEOUT_S
from teletaction.conformance.checklist import HALF_A_REPORT_S, Checklist, How, NotApplicable, Outcome, acting_s, phases
from teletaction.conformance.node_on_trial import FORCE_N, ExoskeletonOnTrial
from teletaction.conformance.node_talk import Values, settled

EXOSKELETON: Checklist[ExoskeletonOnTrial] = Checklist("Exoskeleton; nobody wears it")

NEAR_N = 0.1
LOW_N = 0.05
"""Second force of a trial, N; it differs from the first by more than NEAR_N."""
_STATE = "ExoskeletonState"


def _hold(node: ExoskeletonOnTrial, values: Values, seconds: float) -> list[tuple[float, Values]]:
    states = node.talk.states(node.talk.repeat(lambda: node.talk.say("FingerForces", values), seconds))
    if not states:
        raise NotApplicable(f"no {_STATE}")
    return states


@EXOSKELETON.duty(
    "E1", "Applies to each finger the force that is commanded for it, within 0.1 N, and reports it", How.EXERCISE
)
def _forces(node: ExoskeletonOnTrial) -> Outcome:
    for pushed in FINGERS:
        wanted = {finger: FORCE_N if finger == pushed else 0.0 for finger in FINGERS}
        last = _hold(node, {"enabled": 1.0, **wanted}, 0.3)[-1][1]
        off_n = max(abs(last[finger] - wanted[finger]) for finger in FINGERS)
        if off_n > NEAR_N:
            return Outcome(False, f"{pushed} alone with {FORCE_N} N: " + ", ".join(f"{last[f]:.2f}" for f in FINGERS))
    return Outcome(True, f"{FORCE_N} N on each finger alone")


@EXOSKELETON.duty("E2", "Not enabled, it applies no force, independent of the other bits", How.EXERCISE)
def _not_enabled(node: ExoskeletonOnTrial) -> Outcome:
    node.settle()
    states = _hold(node, {"enabled": 0.0, **dict.fromkeys(FINGERS, FORCE_N)}, 0.3)
    most_n = max(values[finger] for _, values in states for finger in FINGERS)
    return Outcome(most_n == 0.0, f"{most_n:.2f} N at most")


@EXOSKELETON.duty("E3", "150 ms after the last good frame at the latest every force is exactly 0", How.EXERCISE)
def _falls(node: ExoskeletonOnTrial) -> Outcome:
    longest_s = 0.0
    for _ in phases(node):
        node.talk.say("FingerForces", node.acting("FingerForces"))
        states = node.talk.states(node.talk.listen(3.0 * FORCE_SAFE_S))
        if not states:
            raise NotApplicable(f"no {_STATE}")
        pushing = [(at_s, any(values[finger] > 0.0 for finger in FINGERS)) for at_s, values in states]
        longest_s = max(longest_s, acting_s(pushing))
    return Outcome(
        longest_s <= FORCE_SAFE_S + HALF_A_REPORT_S, f"one frame seen to push for {1e3 * longest_s:.0f} ms at most"
    )


@EXOSKELETON.duty(
    "E4", "150 ms after a command changes it applies the new force to each finger, within 0.1 N", How.EXERCISE
)
def _changes(node: ExoskeletonOnTrial) -> Outcome:
    furthest_n = 0.0
    for wanted_n in (FORCE_N, LOW_N, FORCE_N):
        states = _hold(node, {"enabled": 1.0, **dict.fromkeys(FINGERS, wanted_n)}, 3.0 * FORCE_SAFE_S)
        judged = settled(states, FORCE_SAFE_S)
        furthest_n = max([furthest_n, *(abs(values[finger] - wanted_n) for values in judged for finger in FINGERS)])
    return Outcome(furthest_n <= NEAR_N + 1e-9, f"{furthest_n:.2f} N off at most")


@EXOSKELETON.duty("E5", "Reports enabled as it was commanded last, 100 ms after a change at the latest", How.EXERCISE)
def _enabled(node: ExoskeletonOnTrial) -> Outcome:
    for enabled in (1.0, 0.0):
        states = _hold(node, {**node.acting("FingerForces"), "enabled": enabled}, 3.0 * MODULE_TIMEOUT_S)
        if settled(states, MODULE_TIMEOUT_S + HALF_A_REPORT_S)[0]["enabled"] != enabled:
            return Outcome(False, f"commanded {enabled:g}, reported {1.0 - enabled:g}")
    return Outcome(True, "on and off")

"""Duties of a module's own temperature limit, tested by heating."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

from common.limits import PLATE_FAULT_C, PLATE_PEAK_C
from teletaction.conformance.checklist import Checklist, How, NotApplicable, Outcome, Unsafe
from teletaction.conformance.drives import REPEAT_S, WARMEST_C, Drives, DriveState

RELEASE_C = 41.0
ARITHMETIC_K = 0.1
"""Tolerance of temperatures, K; the module may compute another temperature from the same counts."""
FAST_PERMILLE, SLOW_PERMILLE, SLOW_FROM_C = 1000, 300, 38.0
LONGEST_S = 60.0
MOST_BLIND = 10
"""Largest number of turns of 20 ms without a report; heating then ends."""
FALLS_K = 1.0
"""Fall of a plate under a heating command that shows a reversed drive, K."""


@dataclass(frozen=True, slots=True)
class Heated:
    """Reports of a plate that was heated until its module cut out, and then cooled by itself."""

    heating: list[DriveState]
    cooling_asked: list[DriveState]
    """Reports under a cooling command, while the plate is above the release temperature."""
    cooling: list[DriveState]
    """Reports under a constant heating command."""
    released: list[DriveState]
    """Reports without a drive command, below the release temperature."""
    answered: bool
    """Whether the module answered IDENTIFY while it was cut out."""


class Heating:
    """A plate that is heated only once, for all duties of the cut-out."""

    def __init__(self, drives: Drives) -> None:
        self.drives = drives

    @property
    def found(self) -> Heated:
        """Reports of the heated plate.

        Raises:
            NotApplicable: the plate does not reach its limit.
            Unsafe: the plate exceeds 43 C.
        """
        if isinstance(self._once, NotApplicable):
            raise self._once
        return self._once

    @cached_property
    def _once(self) -> Heated | NotApplicable:
        self.drives.warmest_c = PLATE_PEAK_C
        try:
            return self._heat()
        except NotApplicable as reason:
            return reason
        finally:
            with suppress(Unsafe):
                self.drives.settle()

    def _heat(self) -> Heated:
        drives, motor_mv = self.drives, self.drives.mild[1]
        cold_c = drives.ready().plate_c - FALLS_K
        heating = self._until(
            lambda state: state.cut_out or state.plate_c > PLATE_FAULT_C + 0.4 or state.plate_c < cold_c
        )
        if not heating or (not heating[-1].cut_out and heating[-1].plate_c < PLATE_FAULT_C + ARITHMETIC_K):
            raise NotApplicable(f"the plate only reached {heating[-1].plate_c if heating else 0.0:.1f} C")
        if not heating[-1].cut_out:
            return Heated(heating, [], [], [], False)
        cooling_asked = drives.hold(-SLOW_PERMILLE, motor_mv, 0.06) if heating[-1].plate_c > RELEASE_C + 0.3 else []
        cooling = self._until(lambda state: state.plate_c < RELEASE_C - 0.5 or not state.cut_out)
        answered = bool(drives.talk.ask())
        return Heated(heating, cooling_asked, cooling, drives.hold(0, motor_mv, 0.3), answered)

    def _until(self, done: Callable[[DriveState], bool]) -> list[DriveState]:
        """Command heat until a report meets `done`: full drive up to 38 C, then a drive that grows slowly."""
        seen: list[DriveState] = []
        permille = FAST_PERMILLE
        slow, blind = False, 0
        until_s = self.drives.talk.end.now() + LONGEST_S
        while self.drives.talk.end.now() < until_s and not (seen and done(seen[-1])):
            if slow:
                permille = min(FAST_PERMILLE, permille + 1)
            elif seen and (seen[-1].plate_c > SLOW_FROM_C or seen[-1].cut_out):
                slow, permille = True, SLOW_PERMILLE
            self.drives.drive(permille, self.drives.mild[1])
            states = self.drives.listen(REPEAT_S)
            blind = 0 if states else blind + 1
            if blind > MOST_BLIND:
                raise Unsafe("no reports while it is heated")
            end = next((n for n, state in enumerate(states) if done(state)), len(states))
            seen += states[: end + 1]
        return seen


CUT_OUT: Checklist[Heating] = Checklist("The temperature limit of every module with drives; nobody touches the plate")


@CUT_OUT.duty(
    "D14",
    "At 42.0 C by its own measurement, not below 40 C, the Peltier drive is 0 and THERMAL_CUT_OUT is set",
    How.HEAT,
)
def _cuts_out(heating: Heating) -> Outcome:
    found = heating.found.heating
    hot = [state for state in found if state.plate_c >= PLATE_FAULT_C + ARITHMETIC_K or state.cut_out]
    strange = next((state for state in hot if state.permille != 0 or not state.cut_out), None)
    if strange is not None:
        return Outcome(False, f"{strange.plate_c:.2f} C, {strange.permille} thousandths, flags {strange.flags:#04x}")
    return Outcome(found[-1].plate_c > WARMEST_C, f"cut out at {found[-1].plate_c:.2f} C")


@CUT_OUT.duty(
    "D15",
    "It lasts until the plate is below 41.0 C and the drive that it holds back is 0 or below; then it ends",
    How.HEAT,
)
def _lets_go(heating: Heating) -> Outcome:
    found = heating.found
    if not found.heating[-1].cut_out:
        raise NotApplicable("it did not cut out")
    held = [*found.cooling_asked, *found.cooling]
    strange = next((state for state in held if state.permille != 0 or not state.cut_out), None)
    if strange is not None:
        return Outcome(False, f"{strange.permille} thousandths, flags {strange.flags:#04x} at {strange.plate_c:.2f} C")
    if not found.cooling or found.cooling[-1].plate_c >= RELEASE_C:
        raise NotApplicable("the plate does not cool below 41 C by itself")
    ended = bool(found.released) and not found.released[-1].cut_out
    return Outcome(ended, f"held down to {found.cooling[-1].plate_c:.2f} C, then {'ended' if ended else 'not ended'}")


@CUT_OUT.duty("D16", "Cut out, it answers IDENTIFY within 100 ms and a motor keeps running", How.HEAT)
def _keeps_running(heating: Heating) -> Outcome:
    found = heating.found
    if not found.heating[-1].cut_out:
        raise NotApplicable("it did not cut out")
    if not found.answered:
        return Outcome(False, "no answer")
    stopped = [state for state in found.cooling if state.motor_mv != heating.drives.mild[1]]
    return Outcome(not stopped, f"answered; motor stopped in {len(stopped)} of {len(found.cooling)} reports")

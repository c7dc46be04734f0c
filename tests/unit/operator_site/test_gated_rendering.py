"""Rendering and its gate in one step: with a session, a fault, and missing input."""

import math
from types import EllipsisType

import pytest
from msgspec.structs import replace

from common.config.site_models import RenderingConfig
from common.faults.fault import Fault, FaultCode
from common.limits import FORCE_SAFE_S, MOTOR_FLOOR_RPM, PRODUCED_J
from common.wire.messages import Event, EventKind, ExplorationMode, Touch
from common.wire.packets import N
from operator_site.fingertips import LATEST_TAP_S
from operator_site.gated_rendering import GatedRendering
from operator_site.safety.gated_output import GatedOutput
from operator_site.safety.limit_flags import Limit
from tests.unit.operator_site.touches import INDEX, tick_input, touch

TICK_S = 0.002
GAP_S = 0.1
CUT_OUT = Fault(FaultCode.MODULE_CUT_OUT, "index")
TAP = Event(1, EventKind.TAP, INDEX, 0, 0, 0.2)
GROOVE = Event(2, EventKind.GROOVE, INDEX, 0, 0, 100.0)


def touching(*events: Event, sequence: int = 1) -> Touch:
    """The index finger is tapping a stiff surface at z = 0."""
    tapped = {"mode": ExplorationMode.TAPPING, "contact": 1, "stiffness_n_m": 300, "k_tap": 4000, "b_tap_per_s": 30}
    return touch(*events, sequence=sequence, **tapped)


class Run:
    """A rendering stepped at 500 Hz."""

    def __init__(self) -> None:
        self.rendering = GatedRendering(RenderingConfig(), TICK_S, GAP_S)
        self.now = tick_input(z_m=(-0.005,) * N)
        self.touch: Touch | None = touching()
        self.hand_measured = True

    def press(self) -> GatedOutput:
        """Come down on the surface, slowly enough for the force to follow, and stay."""
        for tick in range(200):
            self(z_m=(0.005 - 0.010 * tick / 199,) * N)
        return self()

    def __call__(self, ticks: int = 1, *, touch: Touch | EllipsisType | None = ..., **changes: object) -> GatedOutput:
        if touch is not ...:
            self.touch = touch
        self.now = replace(self.now, **changes)  # type: ignore[arg-type]
        for _ in range(ticks):
            t_s = self.now.time_s + TICK_S
            self.now = replace(self.now, time_s=t_s, fault_cleared=False)
            if self.hand_measured:
                self.now = replace(self.now, pose_s=t_s, heights_s=t_s)
            now = replace(self.now, fault_cleared=bool(changes.get("fault_cleared")))
            output = self.rendering.step(now, self.touch)
        return output


def test_a_finger_in_a_touched_surface_feels_force_and_the_others_none() -> None:
    output = Run().press()
    assert output.force_n[INDEX] == pytest.approx(1.5, rel=0.05)
    assert [force for finger, force in enumerate(output.force_n) if finger != INDEX] == [0.0] * (N - 1)


def test_an_unmeasured_hand_feels_nothing_until_it_presses_again() -> None:
    run = Run()
    assert run.press().force_n[INDEX] > 1.0
    run.hand_measured = False
    output = run(round(FORCE_SAFE_S / TICK_S))
    assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * N
    run.hand_measured = True
    unpaid_n = math.sqrt(2.0 * run.rendering.wall.stiffest_n_m * PRODUCED_J)
    assert run(100).force_n[INDEX] <= unpaid_n + 1e-9, "it is not kicked out of what it came to lie in"
    assert run.press().force_n[INDEX] == pytest.approx(1.5, rel=0.05)


@pytest.mark.parametrize(
    "missing",
    [{"engaged": False}, {"gap_ns": None}, {"gap_ns": round(0.2e9)}, {"touch": None}],
    ids=["not engaged", "never a touch", "touch too old", "touch lost"],
)
def test_missing_input_is_neutral_and_never_repeated(missing: dict[str, object]) -> None:
    run = Run()
    assert run.press().force_n[INDEX] > 1.0
    output = run(round(FORCE_SAFE_S / TICK_S), **missing)
    assert output.force_n == output.motor_rpm == [0.0] * N
    assert run.rendering.fault is None


def test_an_event_is_played_once_in_a_session_and_again_in_the_next() -> None:
    run = Run()
    run(10)
    started = run(1, touch=touching(TAP, sequence=2))
    assert started.motor_rpm[INDEX] >= MOTOR_FLOOR_RPM
    assert [event.ident for event in run.rendering.fingertips.impulses_played] == [1]
    run(1, touch=touching(TAP, sequence=3))
    assert run.rendering.fingertips.impulses_played == []
    run(1, session=8)
    assert [event.ident for event in run.rendering.fingertips.impulses_played] == [1]


@pytest.mark.parametrize(("silent_s", "felt"), [(0.05, [1]), (1.5 * LATEST_TAP_S, [])], ids=["soon after", "too late"])
def test_a_tap_that_comes_while_outputs_rest_is_felt_afterwards(silent_s: float, felt: list[int]) -> None:
    run = Run()
    run(10)
    run(1, engaged=False, touch=touching(TAP, GROOVE, sequence=2))
    assert run(round(silent_s / TICK_S), touch=touching(TAP, GROOVE, sequence=3)).motor_rpm == [0.0] * N
    started = run(1, engaged=True)
    assert [event.ident for event in run.rendering.fingertips.impulses_played] == felt
    assert (started.motor_rpm[INDEX] >= MOTOR_FLOOR_RPM) is bool(felt)
    run(1, engaged=False)
    run(1, engaged=True)
    assert run.rendering.fingertips.impulses_played == []


def test_of_many_taps_that_come_while_outputs_rest_the_last_one_is_felt() -> None:
    run = Run()
    run(10)
    for number in range(1, 40):
        run(1, engaged=False, touch=touching(Event(number, EventKind.TAP, INDEX, 0, 0, 0.2), sequence=number + 1))
    run(1, engaged=True)
    assert [event.ident for event in run.rendering.fingertips.impulses_played] == [39]


def test_a_module_that_cut_out_latches_a_fault_until_it_is_cleared() -> None:
    run = Run()
    output = run(100, device_faults=(CUT_OUT,))
    assert output.fault == CUT_OUT
    assert output.force_n == [0.0] * N
    assert all(bits & Limit.RELEASED for bits in output.limited)
    assert run(100, device_faults=()).fault == output.fault
    output = run(1, fault_cleared=True)
    assert output.fault is None
    assert run.rendering.fault is None
    assert output.force_n[INDEX] < 0.2, "force rises from zero"


def test_the_same_input_gives_the_same_bits() -> None:
    def outputs() -> list[GatedOutput]:
        run = Run()
        return [run(1, x_m=0.0001 * n, pose_s=10.0 + n * TICK_S) for n in range(200)]

    assert outputs() == outputs()

"""An encoder that is stuck is named when its finger is sent somewhere; a finger that something holds is not."""

from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.faults.fault import Fault
from common.faults.texts import fault_text
from remote_site.devices.stuck_encoder import PERSIST_S, SETTLE_S, StuckEncoder
from tests.unit.remote_site.servo_finger import HOVER_M, TICK_S, Seen, follow, presses


def watch(seen: Iterator[Seen], stuck_from_s: float = float("inf")) -> Iterator[tuple[float, Fault | None]]:
    encoder, before_s, last_m = StuckEncoder(), -TICK_S, HOVER_M
    for now in seen:
        if now.t_s < stuck_from_s:
            last_m = now.height_m
        yield now.t_s, encoder.step(now.t_s - before_s, last_m, now.force_n, now.set_m)
        before_s = now.t_s


@pytest.mark.long
@settings(max_examples=25)
@given(st.floats(0.0, 400_000.0), st.integers(0, 2**32), st.integers(1, 8))
def test_a_sound_encoder_is_never_a_fault(stiffness_n_m: float, seed: int, late: int) -> None:
    for _, fault in watch(follow(presses(seed, 6.0), stiffness_n_m, seed, late)):
        assert fault is None


@pytest.mark.parametrize("stiffness_n_m", [0.0, 500.0, 2000.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_stuck_encoder_is_named_soon_after_its_finger_was_sent_elsewhere(stiffness_n_m: float, seed: int) -> None:
    path = list(presses(seed, 20.0))
    found_s = next(t_s for t_s, fault in watch(follow(iter(path), stiffness_n_m, seed), 2.0) if fault)
    left_s = next(n * TICK_S for n, set_m in enumerate(path) if n * TICK_S > 2.0 and abs(set_m - path[1000]) > 0.001)
    assert found_s <= left_s + 4.0 * SETTLE_S + PERSIST_S + 0.3


def test_a_fault_has_its_evidence_and_a_new_count_ends_it() -> None:
    encoder = StuckEncoder()
    for tick in range(2000):
        encoder.step(TICK_S, 0.001, 0.0, 0.001 if tick < 500 else 0.003)
    assert fault_text(encoder.fault) == "joint or encoder stuck: it was sent 2.0 mm, and has not moved by a count"
    assert encoder.step(TICK_S, 0.001005, 0.0, 0.003) is None


def test_a_finger_without_commands_may_stand_still() -> None:
    encoder = StuckEncoder()
    for set_m in [None] * 1000 + [HOVER_M] * 1000:
        assert encoder.step(TICK_S, HOVER_M, 0.0, set_m) is None

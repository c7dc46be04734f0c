"""A good network: everything acts, and the same seed gives the same session."""

import pytest

from tests.virtual.conftest import ON_THE_WAY_S
from tests.virtual.judge import check_ramp
from tests.virtual.session import VirtualSession, virtual_session


@pytest.mark.long
def test_contact_force_vibration_and_heat_appear(session: VirtualSession) -> None:
    session.work()
    session.run(0.1)  # the plate comes from the warmth of the wait
    stroke = session.run(2.9)
    assert all(now.peltier > 0.0 for now in stroke), "the plate is held against its losses"
    truth = stroke + session.run(5.0)  # and the next one, whose material is felt until the finger moves
    assert max(now.contact_n for now in truth) > 0.5
    assert max(now.force_n for now in truth) > 0.5
    assert max(now.motor_rpm for now in truth) > 3000.0
    assert max(now.heater for now in truth) > 0.5, "the free sensor is heated"
    assert session.both_engaged


def test_force_ramps_up_from_zero_on_engaging(session: VirtualSession) -> None:
    # The hand waits for the session; here the operator presses before there is one.
    session.operator.client.want_engaged = False
    session.run(0.5)
    session.sim_operator.hand.start()
    session.until(lambda s: s.sim_operator.hand.segment.act == "stroke", 5.0)
    assert session.now.force_n == 0.0
    session.operator.client.want_engaged = True
    session.until(lambda s: s.both_engaged, 1.0)
    engaged_s = session.time_s
    check_ramp(session.run(0.5), engaged_s)
    session.resume()


@pytest.mark.long
@pytest.mark.parametrize("drift", [50e-6, -50e-6])
def test_clocks_that_drift_apart_by_100_ppm_disturb_nothing(session: VirtualSession, drift: float) -> None:
    session.remote_clock.drift, session.operator_clock.drift = drift, -drift
    session.work()
    ident = session.remote.server.session.ident
    session.run_coarsely(12.0)
    assert session.both_engaged
    assert session.remote.server.session.ident == ident
    assert not session.operator.client.acceptance.refused.keys() - {"clock"}


@pytest.mark.long
def test_the_same_seed_gives_the_same_truth_and_another_one_does_not() -> None:
    def truth(seed: int) -> list[tuple[float, ...]]:
        with virtual_session(seed) as session:
            session.network.impair(delay_s=0.010, jitter_s=0.010, drop=0.05, duplicate=0.05, reorder=0.05, replay=0.05)
            session.run_coarsely(ON_THE_WAY_S)
            session.run(0.7)
            session.network.impair(stalled=True)
            session.run(0.3)
            session.network.heal()
            session.run(0.8)
            assert max(now.force_n for now in session.truth) > 0.2
            return list(session.truth)

    first = truth(1)
    assert truth(1) == first
    assert truth(2) != first

"""Touch packets from the recorded readings of a session."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from common.wire.messages import STIFFNESS_KNOWN_LN_SD, ThermalStatus, TouchRow
from common.wire.packets import Floats, LinkState
from common.wire.touch_summary import NOTHING, SUMMARY_INTERVAL_S, TouchSummary
from remote_site.devices.sensor_frame import SensorFrame
from teletaction.recordings.recorded_session import RecordedSession
from tests.places import GOLDEN
from tests.unit.remote_site.shipped_tables import perception

INDEX = 1


class Tick(NamedTuple):
    """Time, s, whether the index finger touched, and of the packet: the finger's line, and all for a person to read."""

    time_s: float
    contact: bool
    line: TouchRow
    summaries: tuple[TouchSummary, ...]


@pytest.fixture(scope="module")
def ticks() -> list[Tick]:
    identified, found = perception(["thumb", "index"]), []
    with GOLDEN.open("rb") as file:
        for number, (_, _, _, data) in enumerate(RecordedSession(GOLDEN, file).messages(("remote/sensed",))):
            sensed = SensorFrame.unpack(data)
            identified.step(sensed)
            identified.work()
            packet = identified.packet(1, number, number, LinkState.ENGAGED)
            found.append(Tick(sensed.time_s, identified.touches[INDEX].contact, packet.rows[INDEX], packet.summaries))
    return found


def column(ticks: list[Tick], name: str) -> Floats:
    return np.array([getattr(tick.line, name) for tick in ticks])


@pytest.mark.long
def test_the_objects_constants_come_with_how_well_they_are_known(ticks: list[Tick]) -> None:
    known = column(ticks, "conductivity_w_mk") > 0.0
    sd = column(ticks, "effusivity_ln_sd")
    assert known.any()
    assert (sd[~known] == 10.0).all()
    assert (sd[known] > 0.0).all()
    assert sd[known].max() < 3.0
    assert sd[known].min() < 0.7 * sd[known].max()


def test_a_free_finger_reports_nothing_of_an_object(ticks: list[Tick]) -> None:
    free = column(ticks, "thermal_status") == ThermalStatus.NO_CONTACT
    assert free.any()
    assert not column(ticks, "conductivity_w_mk")[free].any()
    assert (column(ticks, "object_c_sd")[free] == 50.0).all()
    touched_s = -1.0
    for tick in ticks:
        touched_s = tick.time_s if tick.contact else touched_s
        if tick.time_s - touched_s > SUMMARY_INTERVAL_S:
            assert tick.summaries[INDEX] == NOTHING
        assert tick.summaries[2] == NOTHING, "a finger that is not in use"


def test_a_stiffness_has_its_uncertainty_and_there_is_none_without_contact(ticks: list[Tick]) -> None:
    touching = column(ticks, "contact") > 0.0
    sd = column(ticks, "stiffness_ln_sd")
    assert (sd[~touching] == 10.0).all()
    for name in ("stiffness_n_m", "damping_n_s_m", "slope_x", "slope_y"):
        assert not column(ticks, name)[~touching].any()
    assert (column(ticks, "stiffness_n_m")[touching] > 0.0).all()
    assert (sd[touching] < STIFFNESS_KNOWN_LN_SD).mean() > 0.5


def test_a_summary_changes_ten_times_a_second_at_most_and_is_one_object_between(
    ticks: list[Tick],
) -> None:
    changes_s = [now.time_s for before, now in pairwise(ticks) if now.summaries is not before.summaries]
    assert len(changes_s) > 20
    assert min(later - earlier for earlier, later in pairwise(changes_s)) >= SUMMARY_INTERVAL_S - 1e-9


def test_the_likeliest_material_comes_first_and_roughness_has_its_uncertainty(ticks: list[Tick]) -> None:
    summaries = {tick.summaries[INDEX] for tick in ticks}
    assert len({len(one.candidates) for one in summaries if one.candidates}) > 1
    for one in summaries:
        probabilities = [probability for _, probability in one.candidates]
        assert probabilities == sorted(probabilities, reverse=True)
        assert sum(probabilities) <= 1.0 + 1e-6
    rough = [one for one in summaries if one.roughness_v is not None]
    assert rough
    for one in rough:
        assert one.roughness_sd_v is not None
        assert 0.0 < one.roughness_sd_v < 0.5 * (one.roughness_v or 0.0)

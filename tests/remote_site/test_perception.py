"""What the operator site is told of an object, from what the remote site sensed in a recorded session."""

from pathlib import Path

import numpy as np
import pytest

from common.messages import STIFFNESS_KNOWN_LN_SD, TOUCH_COLUMN, ThermalStatus
from common.packets import Floats, LinkState
from remote_site.material_table import MaterialTable
from remote_site.perception import Perception
from remote_site.sensed import Sensed
from remote_site.surface_class import SurfaceTable
from teletaction.recorded_session import RecordedSession

SESSION = Path(__file__).parents[1] / "golden" / "session.mcap"
TABLES = Path(__file__).parents[2] / "remote_site" / "tables"


@pytest.fixture(scope="module")
def rows() -> Floats:
    """One finger's line of each tenth packet."""
    perception = Perception(
        ["thumb", "index"], MaterialTable.load(TABLES / "materials.json"), SurfaceTable.load(TABLES / "surfaces.json")
    )
    found = []
    with SESSION.open("rb") as file:
        for number, (_, _, _, data) in enumerate(RecordedSession(SESSION, file).messages(("remote/sensed",))):
            perception.step(Sensed.unpack(data))
            perception.work()
            if number % 10 == 0:
                found.append(perception.packet(1, number, number, LinkState.ENGAGED).block[1])
    return np.array(found)


def column(rows: Floats, name: str) -> Floats:
    return rows[:, TOUCH_COLUMN[name]]


def test_the_objects_constants_come_with_how_well_they_are_known(rows: Floats) -> None:
    known = column(rows, "conductivity_w_mk") > 0.0
    sd = column(rows, "effusivity_ln_sd")
    assert known.any()
    assert (sd[~known] == 10.0).all()
    assert (sd[known] > 0.0).all()
    assert sd[known].max() < 3.0
    assert sd[known].min() < 0.7 * sd[known].max()


def test_a_free_finger_tells_nothing_of_an_object(rows: Floats) -> None:
    free = column(rows, "thermal_status") == ThermalStatus.NO_CONTACT
    assert free.any()
    assert not column(rows, "conductivity_w_mk")[free].any()
    assert (column(rows, "object_c_sd")[free] == 50.0).all()


def test_a_stiffness_comes_with_how_well_it_is_known_and_without_contact_there_is_none(rows: Floats) -> None:
    touching = column(rows, "contact") > 0.0
    sd = column(rows, "stiffness_ln_sd")
    assert (sd[~touching] == 10.0).all()
    for name in ("stiffness_n_m", "damping_n_s_m", "slope_x", "slope_y"):
        assert not column(rows, name)[~touching].any()
    assert (column(rows, "stiffness_n_m")[touching] > 0.0).all()
    assert (sd[touching] < STIFFNESS_KNOWN_LN_SD).mean() > 0.5

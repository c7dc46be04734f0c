"""What is recorded of a finger's identification: a stiffness only once it is known."""

from dataclasses import replace
from pathlib import Path

import msgpack
import pytest

from common.fingers import FINGERS
from common.messages import STIFFNESS_KNOWN_LN_SD
from remote_site.material_table import MaterialTable
from remote_site.patient_gate import GatedCommand
from remote_site.perception import Perception
from remote_site.sensed import Sensed
from remote_site.site_recording import SCHEMAS, SiteRecording
from remote_site.surface_class import SurfaceTable

TABLES = Path(__file__).parents[2] / "remote_site" / "tables"
FIVE = (0.0,) * len(FINGERS)
SENSED = Sensed(1.0, 0.0, 0.0, FIVE, FIVE, (None,) * len(FINGERS), (None,) * len(FINGERS))

COMMAND = GatedCommand(True, False, 0.0, 0.0, list(FIVE), list(FIVE), [0] * len(FINGERS), None)


class Kept:
    """A recorder that keeps what is written."""

    def __init__(self) -> None:
        self.written: dict[str, bytes] = {}

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        self.written[topic] = data


@pytest.mark.parametrize(("ln_sd", "recorded"), [(0.02, 850.0), (STIFFNESS_KNOWN_LN_SD, None), (10.0, None)])
def test_a_stiffness_that_is_not_yet_known_is_recorded_as_none(ln_sd: float, recorded: float | None) -> None:
    perception = Perception(
        ["index"], MaterialTable.load(TABLES / "materials.json"), SurfaceTable.load(TABLES / "surfaces.json")
    )
    perception.step(SENSED)
    perception.work()
    touch = replace(perception.touches[1], stiffness_n_m=850.0, stiffness_ln_sd=ln_sd)
    kept = Kept()
    recording = SiteRecording(kept)  # type: ignore[arg-type]
    recording.tick(1, None, SENSED, None, (), COMMAND, {1: touch})
    assert msgpack.unpackb(kept.written["remote/thermal"])[-1] == recorded
    assert "stiffness_n_m or null" in str(SCHEMAS["remote/thermal"]["description"])

"""Outputs without a gate are neutral."""

from common.fingers import FINGERS
from operator_site.safety.gated_output import SKIN_NEUTRAL_C, GatedOutput
from operator_site.safety.limit_flags import limit_names


def test_without_a_gate_nothing_is_driven() -> None:
    output = GatedOutput.neutral("the gate raised")
    assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * len(FINGERS)
    assert output.plate_set_c == [SKIN_NEUTRAL_C] * len(FINGERS)
    assert [limit_names(limited) for limited in output.limited] == [("released",)] * len(FINGERS)
    assert output.fault == "the gate raised"

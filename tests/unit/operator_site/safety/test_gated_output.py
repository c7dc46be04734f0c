"""Outputs without a gate are neutral."""

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from operator_site.safety.gated_output import SKIN_NEUTRAL_C, released
from operator_site.safety.limit_flags import limit_names


def test_nothing_is_driven_without_a_gate() -> None:
    output = released(Fault(FaultCode.TIME_NOT_FINITE))
    assert output.force_n == output.motor_rpm == output.peltier_drive == [0.0] * len(FINGERS)
    assert output.plate_set_c == [SKIN_NEUTRAL_C] * len(FINGERS)
    assert [limit_names(limited) for limited in output.limited] == [("released",)] * len(FINGERS)
    assert output.fault == Fault(FaultCode.TIME_NOT_FINITE)

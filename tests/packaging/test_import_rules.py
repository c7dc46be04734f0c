"""Import rules inside the sites: safety knows nothing above it, and devices, renderers and perception no gate."""

import grimp
import pytest

SHARED = {
    "operator_site.safety.gated_output",
    "operator_site.safety.limit_flags",
    "operator_site.safety.sampled_wall",
    "remote_site.safety.gated_command",
    "remote_site.safety.sliding_extrema",
    "remote_site.safety.limit_flags",
    "remote_site.safety.servo",
}
"""Safety modules that others may use: outputs and flags of the gates, constants, and pure arithmetic."""
GATES = {
    "operator_site.safety.force_limits",
    "operator_site.safety.operator_gate",
    "operator_site.safety.plate_following",
    "remote_site.safety.approach_limiter",
    "remote_site.safety.height_setpoint",
    "remote_site.safety.heater_limits",
    "remote_site.safety.residual_work",
    "remote_site.safety.patient_gate",
    "remote_site.safety.following_error",
}
HEATERS = {"remote_site.thermal.heater_control", "remote_site.heating"}
DEVICES = {"operator_site.devices.devices", "remote_site.devices.devices"}
"""They import all drivers of their site."""
WITHOUT_A_GATE = DEVICES | {"operator_site.rendering", "remote_site.heating", "remote_site.identification.perception"}


@pytest.fixture(scope="module")
def graph() -> grimp.ImportGraph:
    return grimp.build_graph("common", "operator_site", "remote_site")


@pytest.mark.parametrize("module", sorted(GATES | SHARED))
def test_safety_imports_common_and_safety_only(graph: grimp.ImportGraph, module: str) -> None:
    others = {name for name in graph.find_modules_directly_imported_by(module) if not name.startswith("common.")}
    assert others <= GATES | SHARED


@pytest.mark.parametrize("module", sorted(WITHOUT_A_GATE))
def test_nothing_reaches_a_gate_but_the_site(graph: grimp.ImportGraph, module: str) -> None:
    assert not graph.find_upstream_modules(module) & GATES


def test_perception_drives_no_heater(graph: grimp.ImportGraph) -> None:
    assert not graph.find_upstream_modules("remote_site.identification.perception") & HEATERS


def test_each_driver_is_one_of_the_devices(graph: grimp.ImportGraph) -> None:
    drivers = {"exoskeleton", "hand_encoders", "hot_side", "ntc", "still_finger", "tacttip"}
    assert {f"operator_site.{name}" for name in drivers} <= graph.find_upstream_modules("operator_site.devices.devices")
    drivers = {"measured_hand", "ssr_plausibility", "telemanipulator", "texture_sensor", "thermal_sensor"}
    assert {f"remote_site.{name}" for name in drivers} <= graph.find_upstream_modules("remote_site.devices.devices")

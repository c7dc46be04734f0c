"""Five-fingered haptic teleoperation: the command line, sessions, recordings, and the Python interface.

`import teletaction as tt` gives the names of `__all__`. They are loaded on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from remote_site.stiffness.recorded.identify_stiffness import StiffnessAnswer
    from remote_site.texture.recorded.identify_texture import SurfaceAnswer, load_surfaces
    from remote_site.texture.surface_table import SurfaceTable
    from remote_site.thermal.calibration.temperature_calibration import TemperatureFit
    from remote_site.thermal.calibration.thermal_calibration import ThermalFit
    from remote_site.thermal.material_table import MaterialTable
    from remote_site.thermal.recorded.identify_thermal import MaterialAnswer
    from remote_site.traces.press_files import Press, read_presses
    from remote_site.traces.trace_files import StrokeTrace, ThermalTrace, read_stroke, read_thermal
    from teletaction.api.identification import (
        calibrate_temperature,
        calibrate_thermal,
        identify_stiffness,
        identify_texture,
        identify_thermal,
    )
    from teletaction.api.recording import Recording, Stream
    from teletaction.api.rendering import render_thermal, render_vibration
    from teletaction.api.simulation import simulate, simulate_stroke, simulate_thermal
    from teletaction.api.tactile_map import draw_map

__all__ = [
    "MaterialAnswer",
    "MaterialTable",
    "Press",
    "Recording",
    "StiffnessAnswer",
    "Stream",
    "StrokeTrace",
    "SurfaceAnswer",
    "SurfaceTable",
    "TemperatureFit",
    "ThermalFit",
    "ThermalTrace",
    "calibrate_temperature",
    "calibrate_thermal",
    "draw_map",
    "identify_stiffness",
    "identify_texture",
    "identify_thermal",
    "load_surfaces",
    "read_presses",
    "read_stroke",
    "read_thermal",
    "render_thermal",
    "render_vibration",
    "simulate",
    "simulate_stroke",
    "simulate_thermal",
]
_MODULES = {
    "remote_site.stiffness.recorded.identify_stiffness": ("StiffnessAnswer",),
    "remote_site.texture.recorded.identify_texture": ("SurfaceAnswer", "load_surfaces"),
    "remote_site.texture.surface_table": ("SurfaceTable",),
    "remote_site.thermal.calibration.temperature_calibration": ("TemperatureFit",),
    "remote_site.thermal.calibration.thermal_calibration": ("ThermalFit",),
    "remote_site.thermal.material_table": ("MaterialTable",),
    "remote_site.thermal.recorded.identify_thermal": ("MaterialAnswer",),
    "remote_site.traces.press_files": ("Press", "read_presses"),
    "remote_site.traces.trace_files": ("StrokeTrace", "ThermalTrace", "read_stroke", "read_thermal"),
    "teletaction.api.identification": (
        "calibrate_temperature",
        "calibrate_thermal",
        "identify_stiffness",
        "identify_texture",
        "identify_thermal",
    ),
    "teletaction.api.recording": ("Recording", "Stream"),
    "teletaction.api.rendering": ("render_thermal", "render_vibration"),
    "teletaction.api.simulation": ("simulate", "simulate_stroke", "simulate_thermal"),
    "teletaction.api.tactile_map": ("draw_map",),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'teletaction' has no attribute {name!r}")
    return getattr(import_module(_MODULE_OF[name]), name)

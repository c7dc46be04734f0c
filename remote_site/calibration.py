"""Calibration of both look-up tables from labelled recordings."""

from remote_site.texture_calibration import calibrate_texture
from remote_site.thermal_calibration import calibrate_thermal

__all__ = ["calibrate_texture", "calibrate_thermal"]

"""Computes the temperature of a fingertip: skin models, plate set-points and the plate's controller.

Rendering uses `scene_skin`, `plate_setpoint` and `plate_controller`.
"""

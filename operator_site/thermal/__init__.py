"""Computes the temperature of a fingertip: skin models, and set-points and drives of the plates.

Rendering uses `scene_skin` and `plates`.
"""

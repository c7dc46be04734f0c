"""Texture: roughness, grooves and surfaces.

The registry runs `texture`, `recorded_strokes` and `groove_spacing`.
"""

"""Roughness, grooves and the surface under a stroking finger.

Others use `texture_identification`. `surface_table` and `texture_law` are what calibration finds.
"""

"""Roughness, grooves and the surface under a stroking finger.

Other folders use `texture_identification`. `surface_table` and `texture_law` hold the results of calibration.
"""

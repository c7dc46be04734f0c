"""Height, slope, stiffness and damping of a pressed surface.

Other folders use `surface_estimate`.
"""

"""Height, slope, stiffness and damping of a pressed surface.

Others use `surface_estimate`.
"""

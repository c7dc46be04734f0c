"""Stiffness and height of a pressed surface: live, and from recorded presses.

Other folders use `surface_estimate` and `recorded`.
"""

"""Stiffness and height of a pressed surface.

The registry runs `surface_identification`.
"""

"""Stiffness and height of a pressed surface.

`run` measures and `figure` draws.
"""
